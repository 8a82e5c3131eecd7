#include "app/decode.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "app/exit_status.h"
#include "app/frame_json.h"
#include "app/frame_text.h"
#include "app/streams.h"

namespace tribus {
namespace {

/// Two frames of any serial protocol: enough to tell raw bytes from text while more is to come.
constexpr std::size_t kEnoughToTell = 64;

const std::map<std::string, DecodeFormat> kFormats{
    {"text", DecodeFormat::text}, {"json", DecodeFormat::json}, {"csv", DecodeFormat::csv}};
const std::map<std::string, RecordingKind> kInputFormats{{"raw", RecordingKind::raw},
                                                         {"hex", RecordingKind::hex},
                                                         {"timed", RecordingKind::timed},
                                                         {"saleae", RecordingKind::saleae}};

std::string_view name_of(RecordingKind kind) {
    for (const auto& [name, value] : kInputFormats) {
        if (value == kind) {
            return name;
        }
    }
    return "";
}

Burst raw_burst(std::string_view bytes) {
    return {.start = std::nullopt, .bytes = {bytes.begin(), bytes.end()}, .damaged = {}};
}

/// How a recording is shared out among several protocols.
struct Allotment {
    std::size_t best = 0;
    std::uint64_t frames_of_best = 0;
    std::vector<std::size_t> owners;  ///< of each burst: index of a protocol
};

struct Coverage {
    std::uint64_t frames = 0;
    std::vector<bool> touched;  ///< of each burst: a frame has a byte in it
};

Coverage coverage_of(const Recording& recording, const ProtocolUse& use) {
    Coverage coverage{.frames = 0, .touched = std::vector<bool>(recording.bursts.size())};
    FrameFinder finder(use, [&](const FoundFrame& found) {
        ++coverage.frames;
        std::size_t end = found.place.byte + found.frame.length;
        for (std::size_t burst = found.place.burst; burst < recording.bursts.size(); ++burst) {
            const std::size_t size = recording.bursts[burst].bytes.size();
            coverage.touched[burst] = true;
            if (end <= size) {
                break;
            }
            end -= size;
        }
    });
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        finder.feed(burst, recording.bursts[burst]);
    }
    finder.finish();
    return coverage;
}

bool is_one_frame_of(const Burst& burst, const ProtocolUse& use) {
    bool whole = false;
    FrameFinder finder(
        use, [&](const FoundFrame& found) { whole = found.frame.length == burst.bytes.size(); });
    finder.feed(0, burst);
    finder.finish();
    return whole;
}

Allotment allot(const Recording& recording, std::span<const ProtocolUse> uses) {
    Allotment allotment;
    std::vector<bool> touched(recording.bursts.size());
    for (std::size_t index = 0; index < uses.size(); ++index) {
        Coverage coverage = coverage_of(recording, uses[index]);
        if (coverage.frames > allotment.frames_of_best) {
            allotment.best = index;
            allotment.frames_of_best = coverage.frames;
            touched = std::move(coverage.touched);
        }
    }
    allotment.owners.assign(recording.bursts.size(), allotment.best);
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        for (std::size_t index = 0; !touched[burst] && index < uses.size(); ++index) {
            if (is_one_frame_of(recording.bursts[burst], uses[index])) {
                allotment.owners[burst] = index;
                break;
            }
        }
    }
    return allotment;
}

void add(Tally& total, const Tally& part) {
    total.bytes += part.bytes;
    total.frames += part.frames;
    total.skipped_bytes += part.skipped_bytes;
}

struct PrintedFrame {
    FramePlace place;
    std::string line;
};

int decode_allotted(const Recording& recording, std::span<const ProtocolUse> uses,
                    const Allotment& allotment, FramePrinter& printer) {
    std::vector<PrintedFrame> frames;
    const auto collect = [&](const FoundFrame& found) {
        frames.push_back({found.place, printer.line(found)});
    };
    FrameFinder best(uses[allotment.best], collect);
    Tally others;
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        const std::size_t owner = allotment.owners[burst];
        if (owner == allotment.best) {
            best.feed(burst, recording.bursts[burst]);
            continue;
        }
        FrameFinder other(uses[owner], collect);
        other.feed(burst, recording.bursts[burst]);
        other.finish();
        add(others, other.tally());
    }
    best.finish();
    std::stable_sort(frames.begin(), frames.end(),
                     [](const auto& a, const auto& b) { return a.place < b.place; });
    printer.heading();
    for (const PrintedFrame& frame : frames) {
        printer.line(frame.line);
    }
    Tally tally = best.tally();
    add(tally, others);
    printer.summary(tally);
    return kExitFine;
}

int decode_unknown(const Recording& recording, std::span<const ProtocolUse> uses,
                   FramePrinter& printer, std::ostream& talk) {
    Tally tally;
    for (const Burst& burst : recording.bursts) {
        tally.bytes += burst.bytes.size();
    }
    tally.skipped_bytes = tally.bytes;
    printer.heading();
    printer.summary(tally);
    if (tally.bytes == 0) {
        return kExitFine;
    }
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    talk << fmt::format("tribus: no frame of {} in {} bytes\n", fmt::join(names, " or "),
                        tally.bytes);
    return kExitFailed;
}

int decode_known(const Recording& recording, const ProtocolUse& use, FramePrinter& printer) {
    printer.heading();
    FrameFinder finder(use, [&](const FoundFrame& found) { printer.frame(found); });
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        finder.feed(burst, recording.bursts[burst]);
    }
    finder.finish();
    printer.summary(finder.tally());
    return kExitFine;
}

struct DecodeArguments {
    std::string file;
    std::string protocol = "auto";
    std::string format = "text";
    std::string input_format;
    GivenSettings given;

    DecodeFormat decode_format() const { return kFormats.at(format); }
    std::optional<RecordingKind> kind() const {
        const auto named = kInputFormats.find(input_format);
        return named == kInputFormats.end() ? std::nullopt : std::optional(named->second);
    }
};

int fail(std::string_view message, int status) {
    std::cerr << "tribus: " << message << '\n';
    return status;
}

/// `beginning` is what was read of the file so far.
int decode_raw_as_it_comes(InputFile& file, std::string beginning, const ProtocolUse& use,
                           DecodeFormat format) {
    std::string failed;
    const auto read = [&] {
        if (!beginning.empty()) {
            return std::exchange(beginning, {});
        }
        auto bytes = file.read_some();
        failed = bytes ? std::string() : bytes.error();
        return bytes.value_or(std::string());
    };
    FramePrinter printer(format, RecordingKind::raw, std::cout, std::cerr);
    const int status = decode_stream(read, use, printer, std::cout);
    return failed.empty() ? status : fail(failed, 1);
}

int decode_whole(std::string_view content, const std::string& name,
                 std::span<const ProtocolUse> uses, const DecodeArguments& arguments) {
    constexpr std::string_view kHint = "--input-format raw, hex, timed or saleae";
    const auto given = arguments.kind();
    const auto kind = given ? tl::expected<RecordingKind, std::string>(*given)
                            : tell_recording_kind(content, name);
    if (!kind) {
        return fail(fmt::format("{} ({})", kind.error(), kHint), kExitFailed);
    }
    const auto recording = parse_recording(content, name, *kind);
    if (!recording) {
        return fail(fmt::format("{} (read as {}; {} reads it otherwise)", recording.error(),
                                name_of(*kind), kHint),
                    kExitFailed);
    }
    FramePrinter printer(arguments.decode_format(), *kind, std::cout, std::cerr);
    return decode_recording(*recording, uses, printer, std::cerr);
}

int run_decode(const DecodeArguments& arguments) {
    const auto uses = choose_protocols(arguments.protocol, SettingScope::input, arguments.given);
    if (!uses) {
        return fail(uses.error(), kExitWrongUse);
    }
    auto file = InputFile::open(arguments.file);
    if (!file) {
        return fail(file.error(), kExitFailed);
    }
    std::string beginning;
    while (beginning.size() < kEnoughToTell) {
        const auto bytes = file->read_some();
        if (!bytes) {
            return fail(bytes.error(), kExitFailed);
        }
        if (bytes->empty()) {
            break;
        }
        beginning += *bytes;
    }
    const auto given = arguments.kind();
    const bool raw = given ? *given == RecordingKind::raw : looks_raw(beginning);
    if (raw && uses->size() == 1) {
        return decode_raw_as_it_comes(*file, std::move(beginning), uses->front(),
                                      arguments.decode_format());
    }
    const auto rest = file->read_all();
    if (!rest) {
        return fail(rest.error(), kExitFailed);
    }
    return decode_whole(beginning + *rest, file->name(), *uses, arguments);
}

}  // namespace

FramePrinter::FramePrinter(DecodeFormat format, RecordingKind input, std::ostream& results,
                           std::ostream& talk)
    : format_(format), input_(input), results_(results), talk_(talk) {}

void FramePrinter::heading() {
    std::string text;
    if (format_ == DecodeFormat::text) {
        append_text_heading(text);
    } else if (format_ == DecodeFormat::csv) {
        append_csv_heading(text);
    }
    results_ << text;
}

std::string FramePrinter::line(const FoundFrame& found) const {
    std::string text;
    switch (format_) {
        case DecodeFormat::text:
            append_frame_text(text, found);
            break;
        case DecodeFormat::json:
            append_frame_json(text, found);
            break;
        case DecodeFormat::csv:
            append_frame_csv(text, found);
            break;
    }
    return text;
}

void FramePrinter::frame(const FoundFrame& found) {
    line(line(found));
}

void FramePrinter::line(std::string_view printed) {
    results_ << printed;
}

void FramePrinter::summary(const Tally& tally) {
    std::string text;
    if (format_ == DecodeFormat::json) {
        append_summary_json(text, tally, name_of(input_));
    } else {
        append_summary_text(text, tally);
    }
    (format_ == DecodeFormat::csv ? talk_ : results_) << text;
}

int decode_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                     FramePrinter& printer, std::ostream& talk) {
    if (uses.size() == 1) {
        return decode_known(recording, uses.front(), printer);
    }
    const Allotment allotment = allot(recording, uses);
    if (allotment.frames_of_best == 0) {
        return decode_unknown(recording, uses, printer, talk);
    }
    return decode_allotted(recording, uses, allotment, printer);
}

int decode_stream(const std::function<std::string()>& read, const ProtocolUse& use,
                  FramePrinter& printer, std::ostream& results) {
    printer.heading();
    FrameFinder finder(use, [&](const FoundFrame& found) { printer.frame(found); });
    while (results.good()) {
        const std::string bytes = read();
        if (bytes.empty()) {
            break;
        }
        finder.feed(0, raw_burst(bytes));
        results.flush();
    }
    finder.finish();
    printer.summary(finder.tally());
    return kExitFine;
}

void add_decode_command(CLI::App& app, int& status) {
    CLI::App* const command =
        app.add_subcommand("decode", "Bytes of a protocol to frames, one a line");
    const auto arguments = std::make_shared<DecodeArguments>();
    command->add_option("file", arguments->file,
                        "Raw bytes, hex lines, timed hex lines, or the CSV of a Saleae serial "
                        "decoder; the content tells which. Absent or -: standard input, of which "
                        "raw bytes of a named protocol are decoded as they come");
    command
        ->add_option("--protocol", arguments->protocol,
                     protocol_list() +
                         "; auto: the one that finds the most frames, and lines that are one "
                         "frame of another")
        ->capture_default_str();
    command->add_option("--format", arguments->format, "text shows whole microseconds")
        ->capture_default_str()
        ->check(CLI::IsMember(kFormats));
    command
        ->add_option("--input-format", arguments->input_format,
                     "Kind of the input, where its content does not show it")
        ->check(CLI::IsMember(kInputFormats));
    for (const SettingOption& option : setting_options(SettingScope::input)) {
        const auto keep = [arguments, key = option.key](const std::string& text) {
            arguments->given.insert_or_assign(key, text);
        };
        command->add_option_function<std::string>("--" + option.key, keep, option.help);
    }
    command->callback(
        [arguments, &status] { status = finish_standard_output(run_decode(*arguments)); });
}

}  // namespace tribus
