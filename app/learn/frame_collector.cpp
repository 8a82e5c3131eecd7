#include "app/learn/frame_collector.h"

namespace tribus {

FrameCollector::FrameCollector(const InputConfig& input) : pauses_(input.port.line.bytes_time(1)) {
    if (input.protocol->make_decoder != nullptr) {
        decoder_ = input.protocol->make_decoder(input.settings);
    } else {
        can_decoder_ = input.protocol->make_can_decoder(input.settings);
    }
}

void FrameCollector::decode(std::span<const std::uint8_t> bytes, Instant at) {
    DecodedFrame found;
    while (decoder_->next(bytes, at, found)) {
        keep(found, at);
    }
}

void FrameCollector::look_for_pause(std::size_t count, Instant at) {
    if (pauses_.before(count, at, decoder_->waiting())) {
        DecodedFrame found;
        while (decoder_->silence(found)) {
            keep(found, latest_read_);
        }
    }
    latest_read_ = at;
}

void FrameCollector::keep(const DecodedFrame& found, Instant at) {
    pauses_.frame_came(found.first_byte, found.length);
    frames_.push_back({at, found.channels});
}

void FrameCollector::receive(const CanFrame& frame, Instant at) {
    if (const auto snapshot = can_decoder_->next(frame, at)) {
        frames_.push_back({at, *snapshot});
    }
}

}  // namespace tribus
