#include "app/wire/frames/frame_finder.h"

#include <utility>

namespace tribus {

FrameFinder::FrameFinder(const ProtocolUse& use, FrameHandler handler)
    : protocol_(use.protocol),
      line_(use.line),
      handler_(std::move(handler)),
      decoder_(make_byte_decoder(*use.protocol, use.settings)),
      pauses_(use.line.bytes_time(1)),
      judge_(use.supervision) {}

void FrameFinder::report(const DecodedFrame& frame) {
    while (starts_.size() > 1 && starts_[1].position <= frame.first_byte) {
        starts_.pop_front();
    }
    const BurstStart& burst = starts_.front();
    const std::uint64_t byte = frame.first_byte - burst.position;
    FoundFrame found{.protocol = protocol_,
                     .frame = frame,
                     .place = {burst.burst, static_cast<std::size_t>(byte)},
                     .start = burst.start,
                     .details = decoder_->details()};
    if (found.start) {
        *found.start += line_.bytes_time(byte);
    }
    found.judged = judge_.judge(frame.channels, found.start);
    ++frames_;
    pauses_.frame_came(frame.first_byte, frame.length);
    handler_(found);
}

void FrameFinder::feed_run(std::span<const std::uint8_t> bytes, Instant received) {
    bytes_ += bytes.size();
    DecodedFrame frame;
    while (decoder_->next(bytes, received, frame)) {
        report(frame);
    }
}

/// A burst is received at the end of its last byte.
void FrameFinder::look_for_pause(const Burst& burst) {
    if (!burst.start) {
        pauses_.forget();
        return;
    }
    const Instant end(*burst.start + line_.bytes_time(burst.bytes.size()));
    if (pauses_.before(burst.bytes.size(), end, decoder_->waiting())) {
        DecodedFrame frame;
        while (decoder_->silence(frame)) {
            report(frame);
        }
    }
}

void FrameFinder::feed(std::size_t index, const Burst& burst) {
    if (starts_.empty() || starts_.back().burst != index) {
        starts_.push_back({bytes_, index, burst.start});
    }
    look_for_pause(burst);
    judge_.bytes_came(burst.start);
    const Instant received(burst.start.value_or(Duration::zero()));
    const std::span<const std::uint8_t> bytes = burst.bytes;
    std::size_t run = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        if (at < burst.damaged.size() && burst.damaged[at]) {
            feed_run(bytes.subspan(run, at - run), received);
            decoder_->damaged_byte();
            ++bytes_;
            run = at + 1;
            // The damaged byte may have ended a candidate that contains other frames.
            feed_run({}, received);
        }
    }
    feed_run(bytes.subspan(run), received);
}

void FrameFinder::finish() {
    while (const auto frame = decoder_->finish()) {
        report(*frame);
    }
}

Tally FrameFinder::tally() const {
    const auto rejected = decoder_->rejected();
    return {.bytes = bytes_,
            .frames = frames_,
            .rejected = {rejected.begin(), rejected.end()},
            .skipped_bytes = decoder_->skipped_bytes()};
}

}  // namespace tribus
