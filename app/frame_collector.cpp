#include "app/frame_collector.h"

namespace tribus {

FrameCollector::FrameCollector(const InputConfig& input) {
    if (input.protocol->make_decoder != nullptr) {
        decoder_ = input.protocol->make_decoder(input.settings);
    } else {
        can_decoder_ = input.protocol->make_can_decoder(input.settings);
    }
}

void FrameCollector::decode(std::span<const std::uint8_t> bytes, Instant at) {
    DecodedFrame found;
    while (decoder_->next(bytes, at, found)) {
        frames_.push_back({at, found.channels});
    }
}

void FrameCollector::receive(const CanFrame& frame, Instant at) {
    if (const auto snapshot = can_decoder_->next(frame, at)) {
        frames_.push_back({at, *snapshot});
    }
}

}  // namespace tribus
