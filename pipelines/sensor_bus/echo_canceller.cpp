#include "pipelines/sensor_bus/echo_canceller.h"

#include <algorithm>
#include <chrono>

namespace tribus {
namespace {

/// One byte at 115200 baud with one start bit and two stop bits.
constexpr Duration kByteTime = std::chrono::nanoseconds(95'486);
/// Allowance for drivers that deliver late. Shorter than the 4 ms between a reply and the next slot
/// of a receiver.
constexpr Duration kLateDelivery = std::chrono::milliseconds(2);

}  // namespace

void EchoCanceller::sent(std::span<const std::uint8_t> frame, Instant now) {
    finish();
    length_ = std::min(frame.size(), frame_.size());
    std::copy_n(frame.begin(), length_, frame_.begin());
    until_ = now + static_cast<Duration::rep>(length_) * kByteTime + kLateDelivery;
}

void EchoCanceller::cancel(std::span<const std::uint8_t>& bytes, Instant now) {
    expire(now);
    const std::size_t echoed = std::min(bytes.size(), length_ - echoed_);
    differs_ =
        differs_ || !std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(echoed),
                                frame_.begin() + static_cast<std::ptrdiff_t>(echoed_));
    echoed_ += echoed;
    bytes = bytes.subspan(echoed);
    if (echoed_ == length_) {
        finish();
    }
}

bool EchoCanceller::cancel_damaged(Instant now) {
    expire(now);
    if (length_ == 0) {
        return false;
    }
    differs_ = true;
    if (++echoed_ == length_) {
        finish();
    }
    return true;
}

void EchoCanceller::expire(Instant now) {
    if (now > until_) {
        finish();
    }
}

void EchoCanceller::finish() {
    if (length_ > 0) {
        if (echoed_ == 0) {
            ++counts_.missing;
        } else if (differs_ || echoed_ < length_) {
            ++counts_.collisions;
        } else {
            ++counts_.returned;
        }
    }
    length_ = 0;
    echoed_ = 0;
    differs_ = false;
}

}  // namespace tribus
