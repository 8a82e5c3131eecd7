#include "app/wire/decode_can.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <cstdint>
#include <ostream>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/wire/fitting_protocols.h"
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

int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& messages) {
    std::uint64_t frames_of_best = 0;
    const std::size_t best = uses.size() == 1 ? 0 : best_of(uses, recording, frames_of_best);
    printer.heading();
    CanFrameFinder finder(uses[best], [&](const FoundFrame& found) { printer.frame(found); });
    feed_all(finder, recording);
    CanTally tally = finder.tally();
    tally.error_frames = recording.error_frames;
    tally.log_start = recording.log_start;
    const bool unknown = uses.size() > 1 && frames_of_best == 0 && tally.can_frames > 0;
    if (!unknown) {
        printer.can_summary(tally);
        if (tally.frames == 0 && tally.can_frames > 0) {
            messages << no_frame_text(recording, uses[best].protocol->name);
        }
        return kExitFine;
    }
    // The counters of one protocol's rejected frames would mean nothing here.
    tally.rejected.clear();
    tally.other_can_frames = tally.can_frames;
    printer.can_summary(tally);
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    messages << fmt::format("tribus: no snapshot of {} in {}\n", fmt::join(names, " or "),
                            counted(tally.can_frames, "CAN frame"));
    return kExitFailed;
}

int decode_can_stream(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
                      std::ostream& results, std::ostream& messages) {
    printer.heading();
    results.flush();
    CanFrameFinder finder(use, [&printer](const FoundFrame& found) { printer.frame(found); });
    const CanLogEnd end = read_can_log(
        source, [&finder](const RecordedCanFrame& frame) { finder.feed(frame); }, results,
        messages);
    CanTally tally = finder.tally();
    tally.error_frames = end.error_frames;
    tally.log_start = end.log_start;
    printer.can_summary(tally);
    return end.failed ? kExitFailed : kExitFine;
}

}  // namespace tribus
