#include "transports/links/pwm/pwm_device.h"

#include <fcntl.h>
#include <linux/ioctl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

namespace tribus {
namespace {

/// As in linux/pwm.h, which is newer than the headers of the systems that this is built on.
struct Waveform {
    std::uint32_t output = 0;
    std::uint32_t zero = 0;
    std::uint64_t period_ns = 0;  ///< 0: off
    std::uint64_t pulse_ns = 0;
    std::uint64_t pulse_begins_ns = 0;
};
static_assert(sizeof(Waveform) == 32);

constexpr unsigned kMagic = 0x75;
constexpr unsigned long kRequest = _IO(kMagic, 1);
constexpr unsigned long kFree = _IO(kMagic, 2);
constexpr unsigned long kRound = _IOWR(kMagic, 3, Waveform);
constexpr unsigned long kSetRounded = _IOW(kMagic, 5, Waveform);

/// A chip whose outputs share a period can have one that another program has set.
constexpr std::uint64_t kMostPeriodOffParts = 20;

Waveform waveform(std::size_t output, Duration period, std::uint32_t pulse_nanoseconds) {
    return {.output = static_cast<std::uint32_t>(output),
            .period_ns = static_cast<std::uint64_t>(period / std::chrono::nanoseconds(1)),
            .pulse_ns = pulse_nanoseconds};
}

}  // namespace

PwmDevice::PwmDevice(const std::filesystem::path& path)
    : path_(path),
      device_(path.empty() ? UniqueFd() : UniqueFd(::open(path.c_str(), O_RDWR | O_CLOEXEC))) {}

bool PwmDevice::gone() const {
    struct stat facts {};
    return is_open() && (::fstat(device_.get(), &facts) != 0 || facts.st_nlink == 0);
}

std::string PwmDevice::refused(std::size_t output) const {
    return path_.string() + " output " + std::to_string(output) + ": " + std::strerror(errno);
}

/// A chip whose outputs share a period takes another one only as long as one output is requested.
/// So it is set before the next output is taken, though nothing is sent yet.
std::string PwmDevice::take(std::size_t output, Duration period) const {
    const Waveform nothing = waveform(output, period, 0);
    if (::ioctl(device_.get(), kRequest, output) != 0 ||
        ::ioctl(device_.get(), kSetRounded, &nothing) != 0) {
        return refused(output);
    }
    return switch_off(output);
}

void PwmDevice::give_back(std::size_t output) const {
    ::ioctl(device_.get(), kFree, output);
}

std::string PwmDevice::set(std::size_t output, Duration period,
                           std::uint32_t pulse_nanoseconds) const {
    const Waveform wave = waveform(output, period, pulse_nanoseconds);
    Waveform rounded = wave;
    if (::ioctl(device_.get(), kRound, &rounded) != 0) {
        return refused(output);
    }
    const auto [shorter, longer] = std::minmax(rounded.period_ns, wave.period_ns);
    if (longer - shorter > wave.period_ns / kMostPeriodOffParts) {
        return path_.string() + " output " + std::to_string(output) +
               ": the chip makes a period of " + std::to_string(rounded.period_ns) + " ns of " +
               std::to_string(wave.period_ns) + " ns; another program may have set it";
    }
    return ::ioctl(device_.get(), kSetRounded, &wave) == 0 ? std::string() : refused(output);
}

std::string PwmDevice::switch_off(std::size_t output) const {
    const Waveform off = waveform(output, Duration{}, 0);
    return ::ioctl(device_.get(), kSetRounded, &off) == 0 ? std::string() : refused(output);
}

}  // namespace tribus
