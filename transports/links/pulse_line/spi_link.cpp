#include "transports/links/pulse_line/spi_link.h"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace tribus {
namespace {

constexpr std::uint64_t kWakeOnce = 1;

}  // namespace

SpiLink::SpiLink(UniqueFd port, UniqueFd wake_up, double calibration)
    : port_(std::move(port)), wake_up_(std::move(wake_up)), calibration_(calibration) {
    thread_ = std::thread([this] { work(); });
}

SpiLink::~SpiLink() {
    ends_.store(true);
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kWakeOnce, sizeof kWakeOnce);
    thread_.join();
}

ReadStatus SpiLink::read(Reception& reception) {
    reception.count = 0;
    reception.full = false;
    return ReadStatus::nothing;
}

WriteStatus SpiLink::write(std::span<const std::uint8_t> frame) {
    if (frame.size() > waiting_.size()) {
        return WriteStatus::unavailable;
    }
    {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (!lock) {
            return WriteStatus::busy;
        }
        std::copy(frame.begin(), frame.end(), waiting_.begin());
        waiting_bytes_ = frame.size();
    }
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kWakeOnce, sizeof kWakeOnce);
    return status_.load(std::memory_order_relaxed);
}

/// Draws the frame that waits. Returns false if none does.
bool SpiLink::take_frame() {
    std::array<std::uint8_t, kMostFrameBytes> records{};
    std::size_t bytes = 0;
    {
        const std::scoped_lock lock(mutex_);
        records = waiting_;
        bytes = std::exchange(waiting_bytes_, 0);
    }
    return draw_pulses(std::span(records).first(bytes), calibration_, waveform_);
}

void SpiLink::send_frame() {
    const ssize_t sent = ::write(port_.get(), waveform_.bits.data(), waveform_.bytes);
    const int error = errno;
    if (sent == static_cast<ssize_t>(waveform_.bytes)) {
        status_.store(WriteStatus::written);
    } else {
        const bool gone = sent < 0 && (error == ENODEV || error == ENXIO || error == ESHUTDOWN);
        status_.store(gone ? WriteStatus::lost : WriteStatus::unavailable);
    }
}

void SpiLink::work() {
    // Before everything that is not real time; refused without the right to it.
    const sched_param priority{.sched_priority = 1};
    ::sched_setscheduler(0, SCHED_FIFO, &priority);
    std::uint64_t count = 0;
    while (!ends_.load()) {
        if (::read(wake_up_.get(), &count, sizeof count) == sizeof count && !ends_.load() &&
            take_frame()) {
            send_frame();
        }
    }
}

}  // namespace tribus
