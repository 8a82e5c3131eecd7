#include "transports/links/spi/spi_link.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "transports/links/spi/spi_port.h"

namespace tribus {

SpiLink::SpiLink(SpiPace pace, SpiSignal signal)
    : pace_(std::move(pace)), signal_(std::move(signal)) {}

ReadStatus SpiLink::read(Reception& reception) {
    reception.count = 0;
    reception.full = false;
    return ReadStatus::nothing;
}

WriteStatus SpiLink::write_asked(std::span<const std::uint8_t> frame, FrameLife life) {
    if (frame.size() > waiting_.size()) {
        return WriteStatus::unavailable;
    }
    return keep_frame(frame, life) ? worker_.wake(life) : WriteStatus::busy;
}

/// Returns false if the worker takes a frame just now.
bool SpiLink::keep_frame(std::span<const std::uint8_t> frame, FrameLife life) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock) {
        std::copy(frame.begin(), frame.end(), waiting_.begin());
        waiting_bytes_ = frame.size();
        waiting_until_ = later(life.made, life.valid_for);
    }
    return lock.owns_lock();
}

/// Draws the frame that waits. Returns false if none does.
bool SpiLink::take_frame(Instant& valid_until) {
    std::array<std::uint8_t, kMostFrameBytes> frame{};
    std::size_t bytes = 0;
    {
        const std::scoped_lock lock(mutex_);
        frame = waiting_;
        bytes = std::exchange(waiting_bytes_, 0);
        valid_until = waiting_until_;
    }
    return signal_.draw(std::span(frame).first(bytes), waveform_);
}

/// The worker sends the frame that waits, if one does.
WriteStatus SpiLink::send_newest() {
    Instant valid_until{};
    if (!take_frame(valid_until)) {
        return outcome_;
    }
    const Instant begin = pace_.now();
    if (begin > valid_until) {
        return WriteStatus::busy;
    }
    const ssize_t sent = ::write(pace_.file(), waveform_.bits.data(), waveform_.bytes);
    const int error = errno;
    const bool gone = sent == -1 && is_spi_port_gone(error);
    outcome_ = sent == static_cast<ssize_t>(waveform_.bytes) ? WriteStatus::written
               : gone                                        ? WriteStatus::lost
                                                             : WriteStatus::unavailable;
    if (outcome_ == WriteStatus::written &&
        !pace_.transferred(waveform_.bytes, pace_.now() - begin)) {
        outcome_ = WriteStatus::lost;
    }
    return outcome_;
}

}  // namespace tribus
