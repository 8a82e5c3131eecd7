#include "app/wire/decode_can.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/wire/frames/can_frame_finder.h"
#include "core/counted.h"

namespace tribus {
namespace {

void feed_all(CanFrameFinder& finder, const Recording& recording) {
    for (const RecordedCanFrame& frame : recording.can_frames) {
        finder.feed(frame);
    }
}

std::size_t best_of(std::span<const ProtocolUse> uses, const Recording& recording,
                    std::uint64_t& frames_of_best) {
    std::size_t best = 0;
    for (std::size_t index = 0; index < uses.size(); ++index) {
        CanFrameFinder finder(uses[index], [](const FoundFrame&) {});
        feed_all(finder, recording);
        const std::uint64_t frames = finder.tally().frames;
        if (frames > frames_of_best) {
            best = index;
            frames_of_best = frames;
        }
    }
    return best;
}

}  // namespace

std::uint64_t most_snapshots(std::span<const ProtocolUse> uses, const Recording& recording) {
    std::uint64_t frames_of_best = 0;
    best_of(uses, recording, frames_of_best);
    return frames_of_best;
}

CanDecoding::CanDecoding(const ProtocolUse& use, FramePrinter printer)
    : protocol_(use.protocol->name),
      printer_(printer),
      finder_(use, [this](const FoundFrame& found) { printer_.frame(found); }) {}

void CanDecoding::finish(const LogFacts& facts) {
    CanTally tally = finder_.tally();
    tally.error_frames = facts.error_frames;
    tally.log_start = facts.log_start;
    printer_.can_summary(tally);
}

DecodedAmount CanDecoding::amount() const {
    const CanTally tally = finder_.tally();
    return {tally.frames, tally.can_frames};
}

int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& messages) {
    std::uint64_t frames_of_best = 0;
    const std::size_t best = best_of(uses, recording, frames_of_best);
    if (uses.size() == 1 || frames_of_best > 0 || recording.can_frames.empty()) {
        CanDecoding decoding(uses[best], printer);
        return decode_recording(recording, decoding, messages);
    }
    // The counters of one protocol's rejected frames would mean nothing here.
    CanTally tally{.can_frames = recording.can_frames.size(),
                   .other_can_frames = recording.can_frames.size(),
                   .rejected = {},
                   .error_frames = recording.error_frames,
                   .log_start = recording.log_start};
    for (const RecordedCanFrame& recorded : recording.can_frames) {
        tally.bytes += recorded.frame.remote ? 0 : recorded.frame.length;
    }
    printer.heading();
    printer.can_summary(tally);
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    messages << fmt::format("tribus: no snapshot of {} in {}\n", fmt::join(names, " or "),
                            counted(tally.can_frames, "CAN frame"));
    return kExitFailed;
}

}  // namespace tribus
