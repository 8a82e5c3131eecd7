#include "transports/recordings/recording_source.h"

#include <algorithm>

#include "transports/recordings/burst_reader.h"
#include "transports/recordings/candump.h"

namespace tribus {
namespace {

class InterfaceNames final : public RecordingTaker {
  public:
    void feed_frame(const RecordedCanFrame& frame) override {
        if (std::ranges::find(names, frame.interface) == names.end()) {
            names.push_back(frame.interface);
        }
    }
    std::vector<std::string> names;
};

}  // namespace

void SeveralTakers::feed_burst(std::size_t index, const Burst& burst) {
    for (RecordingTaker* taker : takers_) {
        taker->feed_burst(index, burst);
    }
}

void SeveralTakers::feed_frame(const RecordedCanFrame& frame) {
    for (RecordingTaker* taker : takers_) {
        taker->feed_frame(frame);
    }
}

LogFacts RecordingInMemory::read(RecordingTaker& taker) {
    for (std::size_t index = 0; index < recording_.bursts.size(); ++index) {
        taker.feed_burst(index, recording_.bursts[index]);
    }
    for (const RecordedCanFrame& frame : recording_.can_frames) {
        taker.feed_frame(frame);
    }
    return recording_.log;
}

tl::expected<void, std::string> RecordingInPieces::judge() {
    InterfaceNames found;
    read(found);
    interfaces_ = std::move(found.names);
    return failed_ ? tl::expected<void, std::string>(tl::unexpect, *failed_)
                   : tl::expected<void, std::string>{};
}

LogFacts RecordingInPieces::read(RecordingTaker& taker) {
    content_.rewind();
    if (kind_ == RecordingKind::candump) {
        return read_log(taker);
    }
    BurstReader reader(content_, file_, kind_);
    GapWatch gaps;
    auto burst = reader.next();
    for (std::size_t index = 0; burst && *burst; ++index, burst = reader.next()) {
        gaps.take((*burst)->start.value_or(Duration::zero()), reader.line());
        taker.feed_burst(kind_ == RecordingKind::raw ? 0 : index, **burst);
    }
    if (!burst) {
        failed_ = std::move(burst.error());
    }
    rest_ = reader.rest();
    gaps_ = gaps;
    return {};
}

LogFacts RecordingInPieces::read_log(RecordingTaker& taker) {
    CandumpFrames frames(content_, file_, LogTimes::optional);
    GapWatch gaps;
    auto frame = frames.next();
    for (; frame && *frame; frame = frames.next()) {
        gaps.take((*frame)->at, frames.line());
        if (interface_.empty() || (*frame)->interface == interface_) {
            taker.feed_frame(**frame);
        }
    }
    if (!frame) {
        failed_ = std::move(frame.error());
    }
    rest_ = frames.rest();
    gaps_ = gaps;
    return frames.facts();
}

}  // namespace tribus
