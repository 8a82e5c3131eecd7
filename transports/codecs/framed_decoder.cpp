#include "transports/codecs/framed_decoder.h"

#include <algorithm>

namespace tribus {
namespace {

bool any_damaged(const LineBuffer& buffer, std::size_t count) {
    constexpr std::size_t kMostAtOnce = DamageMarks::kWordBits - 1;
    for (std::size_t at = 0; buffer.any_damaged() && at < count; at += kMostAtOnce) {
        if (buffer.damaged(at, std::min(kMostAtOnce, count - at))) {
            return true;
        }
    }
    return false;
}

}  // namespace

/// Judges what begins with the first byte of the buffer. `length`: the bytes that were needed.
FramedDecoder::Candidate FramedDecoder::look(std::size_t& length) {
    length = 1;
    while (buffer_.see(length)) {
        if (any_damaged(buffer_, length)) {
            return Candidate::none;
        }
        const std::size_t needed = needed_bytes(buffer_.view(0, length));
        if (needed == 0) {
            return Candidate::none;
        }
        if (needed == length) {
            const bool holds = check_holds(buffer_.view(0, length));
            rejected_[kChecksum].count += holds ? 0U : 1U;
            return holds ? Candidate::whole : Candidate::none;
        }
        length = needed;
    }
    return any_damaged(buffer_, buffer_.size()) ? Candidate::none : Candidate::incomplete;
}

bool FramedDecoder::search(bool more_may_come, Instant received, DecodedFrame& frame) {
    while (buffer_.see(1)) {
        std::size_t length = 0;
        const Candidate candidate = look(length);
        if (candidate == Candidate::whole) {
            frame = {.first_byte = buffer_.first_position(), .length = length};
            frame.channels.frame_lost = false;
            frame.channels.failsafe = false;
            frame.channels.received = received;
            const bool channels = read(buffer_.view(0, length), frame.channels);
            buffer_.drop(length);
            if (channels) {
                return true;
            }
            continue;
        }
        if (candidate == Candidate::incomplete && more_may_come) {
            return false;
        }
        buffer_.drop(1);
        ++skipped_bytes_;
    }
    return false;
}

ByteDecoder::Taken FramedDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                         DecodedFrame& frame) {
    read_at_ = received;
    buffer_.open(bytes);
    const bool found = search(true, received, frame);
    return {.bytes = bytes.size() - buffer_.close().size(), .frame = found};
}

bool FramedDecoder::silence(DecodedFrame& frame) {
    buffer_.open({});
    const bool found = search(false, read_at_, frame);
    buffer_.close();
    return found;
}

std::optional<DecodedFrame> FramedDecoder::finish() {
    DecodedFrame frame;
    return silence(frame) ? std::optional(frame) : std::nullopt;
}

void FramedDecoder::damaged_byte() {
    buffer_.append_damaged();
    ++rejected_[kDamaged].count;
}

void FramedDecoder::reset() {
    skipped_bytes_ += buffer_.size();
    buffer_.open({});
    buffer_.drop(buffer_.size());
    buffer_.close();
}

}  // namespace tribus
