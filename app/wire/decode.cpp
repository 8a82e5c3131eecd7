#include "app/wire/decode.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string_view>
#include <utility>
#include <vector>

#include "app/cli/exit_status.h"
#include "core/counted.h"

namespace tribus {
namespace {

/// Which protocol decodes which burst of a recording.
struct Allotment {
    std::size_t best = 0;
    std::uint64_t frames_of_best = 0;
    /// For each burst that is a frame of another protocol and not touched by a frame of the best:
    /// the index of that protocol.
    std::vector<std::optional<std::size_t>> alone;
};

struct Coverage {
    std::uint64_t frames = 0;
    std::vector<bool> touched;  ///< for each burst: a frame contains a byte of it
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
    allotment.alone.resize(recording.bursts.size());
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        for (std::size_t index = 0; !touched[burst] && index < uses.size(); ++index) {
            if (is_one_frame_of(recording.bursts[burst], uses[index])) {
                allotment.alone[burst] = index;
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
        const auto owner = allotment.alone[burst];
        if (!owner) {
            best.feed(burst, recording.bursts[burst]);
            continue;
        }
        FrameFinder other(uses[*owner], collect);
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
                   FramePrinter& printer, std::ostream& messages) {
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
    messages << fmt::format("tribus: no frame of {} in {}\n", fmt::join(names, " or "),
                            counted(tally.bytes, "byte"));
    return kExitFailed;
}

}  // namespace

FrameDecoding::FrameDecoding(const ProtocolUse& use, FramePrinter printer)
    : protocol_(use.protocol->name),
      printer_(printer),
      finder_(use, [this](const FoundFrame& found) { printer_.frame(found); }) {}

void FrameDecoding::finish(const LogFacts& /*facts*/) {
    finder_.finish();
    printer_.summary(finder_.tally());
}

DecodedAmount FrameDecoding::amount() const {
    const Tally tally = finder_.tally();
    return {tally.frames, tally.bytes};
}

int decode_bytes(const Recording& recording, std::span<const ProtocolUse> uses,
                 FramePrinter& printer, std::ostream& messages) {
    const std::vector<ProtocolUse> serial = of_shape(uses, WireShape::bytes);
    if (serial.size() == 1) {
        FrameDecoding decoding(serial.front(), printer);
        return decode_recording(recording, decoding, messages);
    }
    const Allotment allotment = allot(recording, serial);
    if (allotment.frames_of_best == 0) {
        return decode_unknown(recording, serial, printer, messages);
    }
    return decode_allotted(recording, serial, allotment, printer);
}

}  // namespace tribus
