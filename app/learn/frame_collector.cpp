#include "app/learn/frame_collector.h"

namespace tribus {

FrameCollector::FrameCollector(const InputConfig& input)
    : decoder_(input.protocol->make_decoder(input.settings)),
      pauses_(input.port.line.bytes_time(1)) {}

void FrameCollector::decode(std::span<const std::uint8_t> bytes, Instant at) {
    DecodedFrame found;
    while (byte_decoder().next(bytes, at, found)) {
        keep(found, at);
    }
}

void FrameCollector::look_for_pause(std::size_t count, Instant at) {
    if (pauses_.before(count, at, byte_decoder().waiting())) {
        DecodedFrame found;
        while (byte_decoder().silence(found)) {
            keep(found, latest_read_);
        }
    }
    latest_read_ = at;
}

void FrameCollector::keep(const DecodedFrame& found, Instant at) {
    pauses_.frame_came(found.first_byte, found.length);
    keep(found.channels, at);
}

void FrameCollector::keep(const ChannelFrame& frame, Instant at) {
    // Growing would take twice the memory.
    frames_.reserve(kMostFrames);
    if (frames_.size() < kMostFrames) {
        frames_.push_back({at, frame});
    } else {
        overflowed_ = true;
    }
}

void FrameCollector::receive(const CanFrame& frame, Instant at) {
    if (const auto snapshot = std::get<std::unique_ptr<CanDecoder>>(decoder_)->next(frame, at)) {
        keep(*snapshot, at);
    }
}

}  // namespace tribus
