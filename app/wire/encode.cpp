#include "app/wire/encode.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/configured_use.h"
#include "app/cli/exit_status.h"
#include "app/wire/frames/frame_json.h"
#include "core/counted.h"

namespace tribus {
namespace {

/// A frame with 18 fractional pulses and its details takes less than 500 characters.
constexpr std::size_t kLongestJsonLine = std::size_t{64} * 1024;
/// With so many unusable lines, the input is something else.
constexpr unsigned kMostJsonMistakes = 20;

const std::map<std::string, EncodeFormat> kFormats{{"binary", EncodeFormat::binary},
                                                   {"hex", EncodeFormat::hex},
                                                   {"timed", EncodeFormat::timed},
                                                   {"vcd", EncodeFormat::vcd},
                                                   {"candump", EncodeFormat::candump}};

/// Linux limits interface names to 15 characters.
constexpr std::size_t kLongestInterface = 15;

/// Writes all channels that decode printed, if the protocol has room for them. The configuration's
/// default of 14 suits receivers that know no more.
const GivenSettings kEncodeDefaults{{"channels", "18"}};

/// Counts the flags of frames that the protocol cannot carry: its readers take the values for good
/// ones.
class DroppedFlags {
  public:
    DroppedFlags(const ProtocolUse& use, bool marks_frame_lost)
        : protocol_(use.protocol->name),
          carries_failsafe_(use.protocol->signals_failsafe == nullptr ||
                            use.protocol->signals_failsafe(use.settings)),
          carries_frame_lost_(marks_frame_lost) {}

    void take(const ChannelFrame& frame) {
        if (frame.failsafe) {
            failsafe_ += carries_failsafe_ ? 0U : 1U;
        } else if (frame.frame_lost) {
            frame_lost_ += carries_frame_lost_ ? 0U : 1U;
        }
    }
    void report(std::ostream& messages) const {
        for (const auto& [count, mark] :
             {std::pair(failsafe_, "failsafe"), std::pair(frame_lost_, "frame-lost")}) {
            if (count > 0) {
                messages << fmt::format(
                    "tribus: {} marked {} written without the mark, which {} cannot carry\n",
                    counted(count, "frame"), mark, protocol_);
            }
        }
    }

  private:
    std::string_view protocol_;
    bool carries_failsafe_;
    bool carries_frame_lost_;
    std::uint64_t failsafe_ = 0;
    std::uint64_t frame_lost_ = 0;
};

/// The next line, cut at the longest allowed length; then `too_long` is true.
std::optional<std::string_view> next_line(std::istream& lines, std::vector<char>& buffer,
                                          bool& too_long) {
    lines.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto count = static_cast<std::size_t>(lines.gcount());
    too_long = lines.fail() && count + 1 == buffer.size();
    if (lines.fail() && !too_long) {
        return std::nullopt;
    }
    const std::size_t line_end = lines.eof() || too_long ? 0 : 1;
    return std::string_view(buffer.data(), count - line_end);
}

struct EncodeArguments {
    std::string file;
    std::string protocol;
    std::string format;
    std::string interface;
    std::string as;
    GivenSettings given;
};

int fail(std::string_view message, int status) {
    std::cerr << "tribus: " << message << '\n';
    return status;
}

/// Adds the defaults of this command for settings that the protocol has.
GivenSettings with_defaults(const Protocol& protocol, GivenSettings given) {
    for (const Setting& setting : protocol.settings) {
        const auto own = kEncodeDefaults.find(setting.key);
        if (own != kEncodeDefaults.end()) {
            given.insert(*own);
        }
    }
    return given;
}

/// The given format, or the protocol's usual one. The error says what is allowed.
tl::expected<EncodeFormat, std::string> choose_format(const Protocol& protocol,
                                                      const EncodeArguments& arguments) {
    const bool can = protocol.shape == WireShape::can_frames;
    if (arguments.format.empty()) {
        return can ? EncodeFormat::candump : EncodeFormat::binary;
    }
    const EncodeFormat format = kFormats.at(arguments.format);
    if (can == (format == EncodeFormat::candump)) {
        return format;
    }
    return tl::unexpected(
        can ? fmt::format("--format {}: {} runs on CAN; allowed: candump", arguments.format,
                          protocol.name)
            : fmt::format(
                  "--format candump: {} does not run on CAN; allowed: binary, hex, timed, vcd",
                  protocol.name));
}

tl::expected<std::string, std::string> choose_interface(const Protocol& protocol,
                                                        const std::string& given) {
    if (given.empty()) {
        return std::string(kDefaultInterface);
    }
    if (protocol.shape != WireShape::can_frames) {
        return tl::unexpected(
            fmt::format("--interface: {} does not run on CAN; leave it out", protocol.name));
    }
    if (given.size() > kLongestInterface || given.find_first_of(" \t\r\n") != std::string::npos) {
        return tl::unexpected(
            fmt::format("--interface {}: interface names have at most {} characters and no blanks",
                        given, kLongestInterface));
    }
    return given;
}

/// The one protocol to encode.
tl::expected<ProtocolUse, std::string> asked_for(const EncodeArguments& arguments) {
    if (!arguments.as.empty()) {
        if (!arguments.protocol.empty() || !arguments.given.empty()) {
            return tl::unexpected(std::string(kAsAlone));
        }
        return configured_use(arguments.as, SettingScope::output);
    }
    if (arguments.protocol.empty()) {
        return tl::unexpected(fmt::format("--protocol or --as is required; allowed: {}",
                                          protocol_list(SettingScope::output)));
    }
    const auto plain = choose_protocols(arguments.protocol, SettingScope::output, arguments.given);
    if (!plain) {
        return tl::unexpected(plain.error());
    }
    if (plain->size() != 1) {
        return tl::unexpected(std::string("--protocol: encode needs one protocol, not auto"));
    }
    const Protocol& protocol = *plain->front().protocol;
    auto whole =
        use_protocol(protocol, SettingScope::output, with_defaults(protocol, arguments.given));
    return whole ? std::move(whole) : plain->front();
}

int run_encode(const EncodeArguments& arguments) {
    const auto use = asked_for(arguments);
    if (!use) {
        return fail(use.error(), kExitWrongUse);
    }
    const Protocol& protocol = *use->protocol;
    if (protocol.shape == WireShape::bytes && protocol.needs_pipeline != nullptr &&
        !protocol.needs_pipeline(use->settings)) {
        return fail(fmt::format("{} sends named values, and a line of channels has none; `tribus "
                                "simulate` shows what such an output sends",
                                protocol.name),
                    kExitWrongUse);
    }
    const auto format = choose_format(protocol, arguments);
    if (!format) {
        return fail(format.error(), kExitWrongUse);
    }
    const auto interface = choose_interface(protocol, arguments.interface);
    if (!interface) {
        return fail(interface.error(), kExitWrongUse);
    }
    if (arguments.file.empty() || arguments.file == "-") {
        return encode_lines(std::cin, "standard input", *use, *format, std::cout, std::cerr,
                            *interface);
    }
    errno = 0;
    std::ifstream file(arguments.file, std::ios::binary);
    // A folder opens without an error and fails only when it is read.
    const bool nothing = !file || file.peek() == std::ifstream::traits_type::eof();
    if (nothing && errno != 0) {
        return fail(fmt::format("{}: {}", arguments.file, std::strerror(errno)), kExitFailed);
    }
    return encode_lines(file, arguments.file, *use, *format, std::cout, std::cerr, *interface);
}

}  // namespace

int encode_lines(std::istream& lines, std::string_view name, const ProtocolUse& use,
                 EncodeFormat format, std::ostream& results, std::ostream& messages,
                 std::string_view interface) {
    const auto writer = make_frame_writer(use, format, interface, results);
    std::vector<char> buffer(kLongestJsonLine);
    unsigned mistakes = 0;
    bool too_long = false;
    DroppedFlags dropped(use, writer->marks_frame_lost());
    for (unsigned number = 1; results.good(); ++number) {
        const auto line = next_line(lines, buffer, too_long);
        if (!line) {
            break;
        }
        JsonMistake mistake;
        if (too_long) {
            mistake.text = fmt::format(
                "a line of more than {} characters; this is not output of decode --format json",
                kLongestJsonLine);
        } else if (auto frame = parse_frame_json(*line); !frame) {
            mistake = frame.error();
        } else if (*frame) {
            const auto written = writer->write(**frame);
            mistake.text = written ? std::string() : written.error();
            if (written) {
                dropped.take((*frame)->channels);
            }
        }
        if (mistake.text.empty()) {
            continue;
        }
        messages << fmt::format("{}:{}:{}: {}\n", name, number, mistake.column, mistake.text);
        if (++mistakes == kMostJsonMistakes || too_long) {
            messages << "tribus: stopped, too many lines cannot be used\n";
            break;
        }
    }
    writer->finish(messages);
    dropped.report(messages);
    return mistakes == 0 ? kExitFine : kExitFailed;
}

Command encode_command() {
    const auto arguments = std::make_shared<EncodeArguments>();
    std::vector<CommandOption> options{
        {.name = "FILE",
         .value = &arguments->file,
         .help = "JSON lines; absent or -: standard input"},
        {.name = "--protocol",
         .value = &arguments->protocol,
         .help = "Protocol to encode; required, unless --as is given",
         .value_name = "PROTOCOL",
         .offers = [] { return protocol_names_for(SettingScope::output); }},
        {.name = "--as", .value = &arguments->as, .help = kAsHelp, .value_name = "FILE:NAME"},
        {.name = "--format",
         .value = &arguments->format,
         .help = "timed: hex after microseconds; vcd: the level on the wire; candump: the log of "
                 "CAN protocols. Default: binary, or candump for a CAN protocol",
         .choices = {"binary", "candump", "hex", "timed", "vcd"},
         .value_name = "FORMAT"},
        {.name = "--interface",
         .value = &arguments->interface,
         .help = "Interface in the candump log",
         .value_name = "NAME",
         .default_text = std::string(kDefaultInterface)}};
    return {
        .name = "encode",
        .help = "Encode the JSON lines that decode prints to bytes or CAN frames",
        .notes = fmt::format(kProtocolNotes, "encode", protocol_list(SettingScope::output)),
        .options = std::move(options),
        .examples =
            {{"tribus encode --protocol sbus --format hex frames.jsonl", ""},
             {"tribus decode --format json in.sbus | tribus encode --protocol ibus > out.ibus",
              "from one protocol to another"},
             {"tribus encode --as servos.toml:servos --format vcd frames.jsonl > wire.vcd",
              "the level on the wire, as that output of a configuration sends"}},
        .exits = {{kExitFailed, "a line is not what decode prints, or the file cannot be read"}},
        .selected = settings_by_protocol(SettingScope::output, arguments->given),
        .run = [arguments] { return run_encode(*arguments); },
    };
}

}  // namespace tribus
