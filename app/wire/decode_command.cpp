#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/cli/configured_use.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/wire/decode_command.h"
#include "app/wire/decode_dronecan.h"
#include "app/wire/decode_frames.h"
#include "app/wire/decode_sensor.h"
#include "app/wire/decode_values.h"
#include "app/wire/frames/can_log.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/ibus_sensor/types.h"
#include "transports/links/can/can_medium.h"
#include "transports/recordings/recording_source.h"
#include "transports/registry/registry.h"

namespace tribus {
namespace {

/// Two frames of any serial protocol: enough to tell raw bytes from text before the input ends.
constexpr std::size_t kEnoughToTell = 64;

/// The position of a word in a list of names.
std::optional<std::size_t> position_of(std::string_view word,
                                       std::span<const std::string_view> names) {
    const auto found = std::ranges::find(names, word);
    return found == names.end() ? std::nullopt : std::optional(std::size_t(found - names.begin()));
}

struct DecodeArguments {
    std::string file;
    std::string protocol = "auto";
    std::string format = "text";
    std::string input_format;
    std::string interface;
    std::string as;
    std::string dialect;
    GivenSettings given;

    DecodeFormat decode_format() const {
        return DecodeFormat(position_of(format, kDecodeFormatNames).value_or(0));
    }
    std::optional<RecordingKind> kind() const {
        const auto named = position_of(input_format, kRecordingKindNames);
        return named ? std::optional(RecordingKind(*named)) : std::nullopt;
    }
    SensorDialect sensor_dialect() const {
        const auto named = position_of(dialect, kSensorDialectNames);
        return named ? SensorDialect(*named) : SensorDialect::flysky;
    }
    /// With settings, or as an input of a configuration, only the channels of DroneCAN are decoded.
    bool explains_dronecan() const {
        return protocol == kDroneCanName && as.empty() && given.empty();
    }
    /// True if the recording may also be one of the sensor bus.
    bool any_protocol() const { return protocol == "auto" && as.empty() && given.empty(); }
};

constexpr std::string_view kKindHint = "--input-format raw, hex, timed or saleae";

int fail(std::string_view message, int status) {
    std::cerr << "tribus: " << message << '\n';
    return status;
}

bool starts_as_candump(std::string_view beginning) {
    const std::size_t first = beginning.find_first_not_of(" \t\r\n");
    return first != std::string_view::npos && beginning[first] == '(';
}

/// The format, if the first characters already show it.
std::optional<RecordingKind> early_kind(std::string_view beginning) {
    if (looks_raw(beginning)) {
        return RecordingKind::raw;
    }
    return starts_as_candump(beginning) ? std::optional(RecordingKind::candump) : std::nullopt;
}

bool only_can(std::span<const ProtocolUse> uses) {
    return std::ranges::all_of(
        uses, [](const ProtocolUse& use) { return use.protocol->shape == WireShape::can_frames; });
}

/// The protocols that the kind of recording allows. The error says what is wrong.
tl::expected<std::vector<ProtocolUse>, std::string> suited_to(std::span<const ProtocolUse> uses,
                                                              RecordingKind kind,
                                                              std::string_view file_name,
                                                              std::string_view interface) {
    const WireShape shape =
        kind == RecordingKind::candump ? WireShape::can_frames : WireShape::bytes;
    if (shape == WireShape::bytes && !interface.empty()) {
        return tl::unexpected(
            fmt::format("--interface: {} is not a candump log, and only such a log has interfaces; "
                        "leave it out",
                        file_name));
    }
    std::vector<ProtocolUse> suited = of_shape(uses, shape);
    if (!suited.empty()) {
        return suited;
    }
    const std::string_view asked = uses.front().protocol->name;
    const std::string allowed = protocol_list(kCanMedium);
    return tl::unexpected(
        shape == WireShape::can_frames
            ? fmt::format("{}: a log of CAN frames, and {} is not a CAN protocol; allowed: {}",
                          file_name, asked, allowed)
            : fmt::format("{}: bytes of a serial line, but {} is read from CAN frames: lines such "
                          "as (1436509052.249713) can0 123#1122, as candump -L writes them",
                          file_name, asked));
}

/// Reads `file` piece by piece, starting with the `beginning` that was already read.
std::function<std::string()> reader_of(InputFile& file, std::string& beginning,
                                       std::string& failed) {
    return [&] {
        if (!beginning.empty()) {
            return std::exchange(beginning, {});
        }
        auto bytes = file.read_some();
        failed = bytes ? std::string() : bytes.error();
        return bytes.value_or(std::string());
    };
}

DecodeOutput output_of(RecordingKind kind, const DecodeArguments& arguments) {
    return {arguments.decode_format(), kind, std::cout, std::cerr};
}

std::unique_ptr<Decoding> transfer_decoding(const DecodeArguments& arguments) {
    return std::make_unique<TransferDecoding>(terminal_columns(),
                                              output_of(RecordingKind::candump, arguments));
}

/// Makes the decoding that the options ask for.
std::unique_ptr<Decoding> make_decoding(const ProtocolUse& use, RecordingKind kind,
                                        const DecodeArguments& arguments) {
    if (use.protocol == &kSensorBusProtocol) {
        return std::make_unique<SensorDecoding>(SensorTypes(arguments.sensor_dialect()),
                                                output_of(kind, arguments));
    }
    if (arguments.explains_dronecan()) {
        return transfer_decoding(arguments);
    }
    if (use.protocol->make_decoder == nullptr && use.protocol->make_value_reader != nullptr) {
        return std::make_unique<ValueDecoding>(use, output_of(kind, arguments));
    }
    return std::make_unique<FrameDecoding>(use, output_of(kind, arguments));
}

int decode_as_it_comes(InputFile& file, std::string beginning, const ProtocolUse& use,
                       RecordingKind kind, const DecodeArguments& arguments) {
    std::string failed;
    const auto read = reader_of(file, beginning, failed);
    const auto decoding = make_decoding(use, kind, arguments);
    const int status =
        kind == RecordingKind::candump
            ? decode_log({read, file.name(), arguments.interface}, *decoding, std::cout, std::cerr)
            : decode_stream(read, *decoding, std::cout, std::cerr);
    return failed.empty() ? status : fail(failed, kExitFailed);
}

std::string mistake_in_kind(std::string_view mistake, RecordingKind kind) {
    return fmt::format("{} (read as {}; {} selects another format)", mistake,
                       kRecordingKindNames.at(std::size_t(kind)), kKindHint);
}

int decode_judged(RecordingInPieces& recording, const std::string& name,
                  std::vector<ProtocolUse> uses, const DecodeArguments& arguments) {
    const bool can = recording.kind() == RecordingKind::candump;
    if (can) {
        auto chosen = check_interface(recording.interfaces(), name, arguments.interface);
        if (!chosen) {
            return fail(chosen.error(), kExitFailed);
        }
        recording.select_interface(arguments.interface);
    } else if (arguments.any_protocol() && is_sensor_bus(recording)) {
        uses = {{.protocol = &kSensorBusProtocol, .settings = {}, .line = kSensorBusProtocol.line}};
    }
    if (uses.size() == 1 || (can && arguments.any_protocol() && only_dronecan(recording, uses))) {
        const auto decoding = uses.size() == 1
                                  ? make_decoding(uses.front(), recording.kind(), arguments)
                                  : transfer_decoding(arguments);
        return decode_recording(recording, *decoding, std::cerr);
    }
    return decode_frames(recording, uses, output_of(recording.kind(), arguments));
}

/// Decodes a file of any length. It is judged as a whole before anything is printed. `uses` are all
/// CAN or all serial, unless the kind is not known yet.
int decode_whole(FilePieces& content, const std::string& name, std::vector<ProtocolUse> uses,
                 std::optional<RecordingKind> kind, const DecodeArguments& arguments) {
    if (!kind) {
        const auto told = detect_recording_kind(content, name);
        if (!told) {
            return fail(fmt::format("{} ({})", told.error(), kKindHint), kExitFailed);
        }
        // For CAN protocols any text is parsed as a log, whose parser reports best what is wrong.
        kind = only_can(uses) && *told != RecordingKind::raw ? RecordingKind::candump : *told;
        auto suited = suited_to(uses, *kind, name, arguments.interface);
        if (!suited) {
            return fail(suited.error(), kExitWrongUse);
        }
        uses = std::move(*suited);
    }
    RecordingInPieces recording(content, name, *kind);
    if (const auto judged = recording.judge(); !judged) {
        return fail(*kind == RecordingKind::candump ? judged.error()
                                                    : mistake_in_kind(judged.error(), *kind),
                    kExitFailed);
    }
    if (recording.rest()) {
        std::cerr << *recording.rest() << '\n';
    }
    const int status = decode_judged(recording, name, std::move(uses), arguments);
    const auto& failed = content.failed() ? content.failed() : recording.failed();
    return failed ? fail(*failed, kExitFailed) : status;
}

/// Reads as much of the file as is needed to recognise its format.
tl::expected<std::string, std::string> read_beginning(InputFile& file) {
    std::string beginning;
    while (beginning.size() < kEnoughToTell && !starts_as_candump(beginning)) {
        auto bytes = file.read_some();
        if (!bytes || bytes->empty()) {
            return bytes ? std::move(beginning) : std::move(bytes);
        }
        beginning += *bytes;
    }
    return beginning;
}

/// The protocols that the options allow.
tl::expected<std::vector<ProtocolUse>, std::string> asked_for(const DecodeArguments& arguments) {
    if (arguments.protocol != "auto" && find_protocol(arguments.protocol) == nullptr) {
        return tl::unexpected(
            fmt::format("--protocol: {} is not a known protocol; allowed: auto, {}",
                        in_quotes(arguments.protocol), protocol_list(SettingScope::input)));
    }
    if (arguments.as.empty()) {
        return choose_protocols(arguments.protocol, SettingScope::input, arguments.given);
    }
    if (arguments.protocol != "auto" || !arguments.given.empty()) {
        return tl::unexpected(std::string(kAsAlone));
    }
    return configured_use(arguments.as, SettingScope::input).map([](ProtocolUse use) {
        return std::vector{std::move(use)};
    });
}

int run_decode(const DecodeArguments& arguments) {
    if (!arguments.dialect.empty() && arguments.protocol != kSensorBusName) {
        return fail(fmt::format("--dialect: only --protocol {} has dialects", kSensorBusName),
                    kExitWrongUse);
    }
    auto uses = asked_for(arguments);
    if (!uses) {
        return fail(uses.error(), kExitWrongUse);
    }
    auto file = InputFile::open(arguments.file);
    if (!file) {
        return fail(file.error(), kExitFailed);
    }
    auto beginning = read_beginning(*file);
    if (!beginning) {
        return fail(beginning.error(), kExitFailed);
    }
    const auto given = arguments.kind();
    const auto kind = given ? given : early_kind(*beginning);
    if (kind) {
        uses = suited_to(*uses, *kind, file->name(), arguments.interface);
    }
    if (!uses) {
        return fail(uses.error(), kExitWrongUse);
    }
    const bool log = kind == RecordingKind::candump;
    // A complete log is judged as a whole before anything is printed.
    const bool flows = kind == RecordingKind::raw || (log && !file->is_whole());
    if (flows && log && arguments.protocol == "auto") {
        uses = without_dronecan(*uses);
    }
    if (flows && uses->size() == 1) {
        return decode_as_it_comes(*file, std::move(*beginning), uses->front(), *kind, arguments);
    }
    const std::string name = file->name();
    const auto pieces = FilePieces::of(std::move(*file), std::move(*beginning));
    return pieces ? decode_whole(**pieces, name, std::move(*uses), kind, arguments)
                  : fail(pieces.error(), kExitFailed);
}

}  // namespace

Command decode_command() {
    const auto arguments = std::make_shared<DecodeArguments>();
    std::vector<CommandOption> options{
        {.name = "FILE",
         .value = &arguments->file,
         .help = "Raw bytes, hex lines, timed hex lines, the CSV of a Saleae serial decoder, or a "
                 "candump log; the content shows which. Absent or -: standard input; raw bytes of "
                 "a named protocol and the lines of candump -L are decoded as they arrive"},
        {.name = "--protocol",
         .value = &arguments->protocol,
         .help =
             "auto: the protocol that finds the most frames; single lines may be frames of another",
         .shows_value = true,
         .value_name = "PROTOCOL",
         .offers =
             [] {
                 auto names = protocol_names_for(SettingScope::input);
                 names.insert(names.begin(), "auto");
                 return names;
             }},
        {.name = "--as", .value = &arguments->as, .help = kAsHelp, .value_name = "FILE:NAME"},
        {.name = "--dialect",
         .value = &arguments->dialect,
         .help = "For ibus-sensor: the dialect of the disputed types",
         .choices = {kSensorDialectNames.begin(), kSensorDialectNames.end()},
         .value_name = "DIALECT",
         .default_text = std::string(kSensorDialectNames.front())},
        {.name = "--format",
         .value = &arguments->format,
         .help = "text shows whole microseconds",
         .shows_value = true,
         .choices = {"csv", "json", "text"}},
        {.name = "--input-format",
         .value = &arguments->input_format,
         .help = "Format of the input, if its content does not show it",
         .choices = {"candump", "hex", "raw", "saleae", "timed"},
         .value_name = "FORMAT"},
        {.name = "--interface",
         .value = &arguments->interface,
         .help = "For a candump log: the interface whose frames are decoded; needed if it has "
                 "several",
         .value_name = "NAME"}};
    return {
        .name = "decode",
        .help = "Decode bytes or CAN frames to frames of channels, one a line",
        .notes = fmt::format(kProtocolNotes, "decode", protocol_list(SettingScope::input)),
        .options = std::move(options),
        .examples = {{"tribus decode receiver.txt", "the protocol is found out"},
                     {"tribus decode --protocol sbus --format json flight.sbus", ""},
                     {"tribus decode --as servos.toml:receiver receiver.txt",
                      "as that input of a configuration reads it"},
                     {"candump -L can0 | tribus decode --protocol can", "as it arrives"}},
        .exits = {{kExitFailed, "auto finds no protocol, or the input cannot be read"}},
        .selected = settings_by_protocol(SettingScope::input, arguments->given),
        .run = [arguments] { return run_decode(*arguments); },
    };
}

}  // namespace tribus
