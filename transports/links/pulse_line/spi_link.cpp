#include "transports/links/pulse_line/spi_link.h"

#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

constexpr std::uint32_t kBitsASecond = 1'000'000;
constexpr std::uint64_t kWakeOnce = 1;

std::string spi_problem(int error) {
    switch (error) {
        case EACCES:
        case EPERM:
            return "this user may not use it; join its group, which `ls -l` shows (gpio by the "
                   "package's udev rule, spi on Raspberry Pi OS), and for a service see "
                   "/usr/share/doc/tribus/docs/service.md, \"SPI in the service\"";
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return "there is no such device; on a Raspberry Pi dtparam=spi=on in config.txt makes "
                   "/dev/spidev0.0";
        case ENOTTY:
        case EINVAL:
            return "this is no SPI port that sends 8 bits at 1 MHz; give one such as "
                   "/dev/spidev0.0";
        default:
            return std::strerror(error);
    }
}

bool set_up(int port) {
    std::uint8_t mode = SPI_MODE_0;
    std::uint8_t bits = 8;
    std::uint32_t speed = kBitsASecond;
    return ::ioctl(port, SPI_IOC_WR_MODE, &mode) >= 0 &&
           ::ioctl(port, SPI_IOC_WR_BITS_PER_WORD, &bits) >= 0 &&
           ::ioctl(port, SPI_IOC_WR_MAX_SPEED_HZ, &speed) >= 0;
}

}  // namespace

tl::expected<std::unique_ptr<SpiLink>, std::string> SpiLink::open(const std::string& device,
                                                                  double calibration) {
    const auto failed = [&device](int error) {
        return tl::unexpected(device + ": " + spi_problem(error));
    };
    UniqueFd port(::open(device.c_str(), O_RDWR | O_CLOEXEC));
    if (!port.valid() || !set_up(port.get())) {
        return failed(errno);
    }
    UniqueFd wake_up(::eventfd(0, EFD_CLOEXEC));
    if (!wake_up.valid()) {
        return failed(errno);
    }
    try {
        return std::unique_ptr<SpiLink>(
            new SpiLink(std::move(port), std::move(wake_up), calibration));
    } catch (const std::system_error& error) {
        return tl::unexpected(device + ": cannot start a thread: " + error.what());
    }
}

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
