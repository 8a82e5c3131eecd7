#include "app/wire/decode_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

void print_heading(const DecodeOutput& output) {
    output.heading(append_text_heading, append_csv_heading);
}

std::string line_of(const FoundFrame& found, DecodeFormat format) {
    return in_format(format, append_frame_text, append_frame_json, append_frame_csv, found);
}

void print_summary(const DecodeOutput& output, const Tally& tally) {
    output.summary(
        [&](std::string& text) { append_summary_text(text, tally); },
        [&](std::string& text) { append_summary_json(text, tally, output.input_name()); });
}

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
    find_frames(use, recording, [&](const FoundFrame& found) {
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
    return coverage;
}

bool is_one_frame_of(const Burst& burst, const ProtocolUse& use) {
    bool whole = false;
    const auto finder = make_frame_finder(
        use, [&](const FoundFrame& found) { whole = found.frame.length == burst.bytes.size(); });
    finder->feed_burst(0, burst);
    finder->finish();
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

void decode_allotted(const Recording& recording, std::span<const ProtocolUse> uses,
                     const Allotment& allotment, const DecodeOutput& output) {
    std::vector<PrintedFrame> frames;
    const auto collect = [&](const FoundFrame& found) {
        frames.push_back({found.place, line_of(found, output.format)});
    };
    const auto best = make_frame_finder(uses[allotment.best], collect);
    Tally others;
    for (std::size_t burst = 0; burst < recording.bursts.size(); ++burst) {
        const auto owner = allotment.alone[burst];
        if (!owner) {
            best->feed_burst(burst, recording.bursts[burst]);
            continue;
        }
        const auto other = make_frame_finder(uses[*owner], collect);
        other->feed_burst(burst, recording.bursts[burst]);
        other->finish();
        add(others, other->tally());
    }
    best->finish();
    std::stable_sort(frames.begin(), frames.end(),
                     [](const auto& a, const auto& b) { return a.place < b.place; });
    print_heading(output);
    for (const PrintedFrame& frame : frames) {
        output.results << frame.line;
    }
    Tally tally = best->tally();
    add(tally, others);
    print_summary(output, tally);
}

/// The counters of one protocol's rejected frames would mean nothing here.
int decode_unknown(const Recording& recording, std::span<const ProtocolUse> uses,
                   const DecodeOutput& output) {
    Tally tally = find_frames(uses.front(), recording, [](const FoundFrame&) {});
    tally.rejected.clear();
    tally.skipped_bytes = tally.bytes;
    if (tally.can) {
        tally.can->others = tally.can->frames;
        tally.can->log = recording.log;
    }
    print_heading(output);
    print_summary(output, tally);
    if (amount_of(tally).given == 0) {
        return kExitFine;
    }
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    output.messages << fmt::format(
        "tribus: no {} of {} in {}\n", tally.can ? "snapshot" : "frame", fmt::join(names, " or "),
        tally.can ? counted(tally.can->frames, "CAN frame") : counted(tally.bytes, "byte"));
    return kExitFailed;
}

}  // namespace

FrameDecoding::FrameDecoding(const ProtocolUse& use, const DecodeOutput& output)
    : protocol_(use.protocol->name),
      output_(output),
      finder_(make_frame_finder(use, [this](const FoundFrame& found) {
          output_.results << line_of(found, output_.format);
      })) {}

void FrameDecoding::heading() {
    print_heading(output_);
}

void FrameDecoding::finish(const LogFacts& log) {
    finder_->finish();
    Tally tally = finder_->tally();
    if (tally.can) {
        tally.can->log = log;
    }
    print_summary(output_, tally);
}

DecodedAmount FrameDecoding::amount() const {
    return amount_of(finder_->tally());
}

std::uint64_t most_frames(std::span<const ProtocolUse> uses, const Recording& recording) {
    return allot(recording, uses).frames_of_best;
}

int decode_frames(const Recording& recording, std::span<const ProtocolUse> uses,
                  const DecodeOutput& output) {
    const Allotment allotment = allot(recording, uses);
    if (uses.size() > 1 && allotment.frames_of_best == 0) {
        return decode_unknown(recording, uses, output);
    }
    if (uses.size() == 1 || recording.bursts.empty()) {
        FrameDecoding decoding(uses[allotment.best], output);
        return decode_recording(recording, decoding, output.messages);
    }
    decode_allotted(recording, uses, allotment, output);
    return kExitFine;
}

}  // namespace tribus
