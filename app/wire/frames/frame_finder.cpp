#include "app/wire/frames/frame_finder.h"

#include <algorithm>
#include <array>
#include <deque>
#include <iterator>
#include <utility>

#include "transports/codecs/can_codec.h"
#include "transports/codecs/line_pauses.h"

namespace tribus {
namespace {

class SerialFrameFinder final : public FrameFinder {
  public:
    SerialFrameFinder(const ProtocolUse& use, FrameHandler handler)
        : protocol_(use.protocol),
          line_(use.line),
          handler_(std::move(handler)),
          decoder_(make_byte_decoder(*use.protocol, use.settings)),
          pauses_(use.line.bytes_time(1)),
          judge_(use.supervision) {}

    void feed_burst(std::size_t index, const Burst& burst) override;
    void finish() override {
        while (const auto frame = decoder_->finish()) {
            report(*frame);
        }
    }
    std::optional<FramePlace> waits_since() const override;
    Tally tally() const override {
        const auto rejected = decoder_->rejected();
        return {.bytes = bytes_,
                .frames = frames_,
                .rejected = {rejected.begin(), rejected.end()},
                .skipped_bytes = decoder_->skipped_bytes()};
    }

  private:
    struct BurstStart {
        std::uint64_t position = 0;  ///< of its first byte, among all bytes fed
        std::size_t burst = 0;
        std::optional<Duration> start;
    };
    void look_for_pause(const Burst& burst);
    void feed_run(std::span<const std::uint8_t> bytes, Instant received);
    void report(const DecodedFrame& frame);
    /// No later frame begins before this byte.
    void forget_starts_before(std::uint64_t position);
    std::size_t burst_of(std::uint64_t position) const;

    const Protocol* protocol_;
    LineSettings line_;
    FrameHandler handler_;
    std::unique_ptr<ByteDecoder> decoder_;
    LinePauses pauses_;
    FrameJudge judge_;
    /// The bursts in which the next frame may start.
    std::deque<BurstStart> starts_;
    std::uint64_t bytes_ = 0;
    std::uint64_t frames_ = 0;
};

void SerialFrameFinder::forget_starts_before(std::uint64_t position) {
    while (starts_.size() > 1 && starts_[1].position <= position) {
        starts_.pop_front();
    }
}

std::size_t SerialFrameFinder::burst_of(std::uint64_t position) const {
    const auto behind = std::ranges::find_if(
        starts_, [position](const BurstStart& start) { return start.position > position; });
    return std::prev(behind)->burst;
}

std::optional<FramePlace> SerialFrameFinder::waits_since() const {
    if (decoder_->waiting() == 0) {
        return std::nullopt;
    }
    const BurstStart& burst = starts_.front();
    return FramePlace{burst.burst,
                      static_cast<std::size_t>(bytes_ - decoder_->waiting() - burst.position)};
}

void SerialFrameFinder::report(const DecodedFrame& frame) {
    forget_starts_before(frame.first_byte);
    const BurstStart& burst = starts_.front();
    const std::uint64_t byte = frame.first_byte - burst.position;
    FoundFrame found{.protocol = protocol_,
                     .frame = frame,
                     .place = {burst.burst, static_cast<std::size_t>(byte)},
                     .last_burst = burst_of(frame.first_byte + frame.length - 1),
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

void SerialFrameFinder::feed_run(std::span<const std::uint8_t> bytes, Instant received) {
    bytes_ += bytes.size();
    DecodedFrame frame;
    while (decoder_->next(bytes, received, frame)) {
        report(frame);
    }
}

/// A burst is received at the end of its last byte.
void SerialFrameFinder::look_for_pause(const Burst& burst) {
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

void SerialFrameFinder::feed_burst(std::size_t index, const Burst& burst) {
    if (starts_.empty() || starts_.back().burst != index) {
        starts_.push_back({bytes_, index, burst.start});
    }
    look_for_pause(burst);
    judge_.bytes_came(burst.start);
    const Instant received(burst.start.value_or(Duration::zero()));
    const std::span<const std::uint8_t> bytes = burst.bytes;
    std::size_t run = 0;
    for (std::size_t at = 0; at < burst.damaged.size(); ++at) {
        if (burst.damaged[at]) {
            feed_run(bytes.subspan(run, at - run), received);
            decoder_->damaged_byte();
            ++bytes_;
            run = at + 1;
            // The damaged byte may have ended a candidate that contains other frames.
            feed_run({}, received);
        }
    }
    feed_run(bytes.subspan(run), received);
    forget_starts_before(bytes_ - decoder_->waiting());
}

class CanFrameFinder final : public FrameFinder {
  public:
    CanFrameFinder(const ProtocolUse& use, FrameHandler handler)
        : protocol_(use.protocol),
          handler_(std::move(handler)),
          decoder_(make_can_decoder(*use.protocol, use.settings)),
          judge_(use.supervision) {}

    void feed_frame(const RecordedCanFrame& recorded) override;
    Tally tally() const override {
        const auto rejected = decoder_->rejected();
        return {.bytes = bytes_,
                .frames = snapshots_,
                .rejected = {rejected.begin(), rejected.end()},
                .first_fault = first_fault_,
                .can = can_};
    }

  private:
    const Protocol* protocol_;
    FrameHandler handler_;
    std::unique_ptr<CanDecoder> decoder_;
    FrameJudge judge_;
    CanTally can_;
    std::string first_fault_;
    std::uint64_t bytes_ = 0;
    std::uint64_t snapshots_ = 0;
};

void CanFrameFinder::feed_frame(const RecordedCanFrame& recorded) {
    const CanFrame& frame = recorded.frame;
    ++can_.frames;
    bytes_ += frame.remote ? 0 : frame.length;
    const bool wanted = std::ranges::any_of(
        decoder_->wanted(), [&](const CanIdMatch& match) { return match.matches(frame); });
    if (!wanted) {
        ++can_.others;
        return;
    }
    judge_.bytes_came(recorded.at);
    const auto snapshot = decoder_->next(frame, Instant(recorded.at));
    if (first_fault_.empty()) {
        std::array<char, 256> text{};
        first_fault_.assign(text.data(), decoder_->write_fault(text));
    }
    if (!snapshot) {
        return;
    }
    ++snapshots_;
    handler_({.protocol = protocol_,
              .frame = {.channels = *snapshot, .first_byte = 0, .length = 0},
              .place = {},
              .last_burst = 0,
              .start = recorded.at,
              .details = decoder_->details(),
              .judged = judge_.judge(*snapshot, recorded.at)});
}

}  // namespace

std::unique_ptr<FrameFinder> make_frame_finder(const ProtocolUse& use, FrameHandler handler) {
    if (use.protocol->shape == WireShape::can_frames) {
        return std::make_unique<CanFrameFinder>(use, std::move(handler));
    }
    return std::make_unique<SerialFrameFinder>(use, std::move(handler));
}

Tally find_frames(const ProtocolUse& use, RecordingSource& recording, FrameHandler handler) {
    const auto finder = make_frame_finder(use, std::move(handler));
    const LogFacts log = recording.read(*finder);
    finder->finish();
    Tally tally = finder->tally();
    if (tally.can) {
        tally.can->log = log;
    }
    return tally;
}

}  // namespace tribus
