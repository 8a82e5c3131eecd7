#include "transports/links/spi/spi_pace.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

namespace tribus {

SpiPace::SpiPace(std::string device, SpiPort port, Duration byte_time, const WorkerSettings& worker)
    : device_(std::move(device)),
      port_(std::move(port)),
      byte_time_(byte_time),
      worker_(worker),
      watch_(byte_time) {}

bool SpiPace::transferred(std::size_t bytes, Duration took, Duration pause) {
    told_refusal_ = false;
    watch_.transferred(bytes, took);
    const std::size_t zeros = watch_.wanted_zeros();
    if (zeros == 0 || static_cast<std::int64_t>(zeros) * byte_time_ > pause) {
        return true;
    }
    const auto compared = zeros_through(port_.file, worker_.now)(port_.hz, zeros);
    return !compared || !watch_.compared(*compared) || measure_anew();
}

bool SpiPace::measure_anew() {
    const auto found = find_spi_rate(byte_time_, zeros_through(port_.file, worker_.now));
    if (!found) {
        return false;
    }
    watch_ = SpiClockWatch(byte_time_);
    constexpr double kPercent = 100;
    const double change = static_cast<double>(port_.hz) / *found - 1;
    port_.hz = *found;
    // A clock that changes once changes again and again.
    if (std::abs(change) > SpiClockWatch::kMostDrift / 2 && worker_.warn != nullptr &&
        !std::exchange(told_change_, true)) {
        worker_.warn(fmt::format(
            "{}: its clock has changed by {:+.1f} %, so bits had the wrong length until it was "
            "measured anew just now. Fix the core's clock: core_freq_min=500 (Raspberry Pi 4) or "
            "core_freq=250 (Raspberry Pi 3) in config.txt",
            device_, change * kPercent));
    }
    return true;
}

void SpiPace::refused(int error) {
    if (worker_.warn != nullptr && !std::exchange(told_refusal_, true)) {
        worker_.warn(fmt::format("{}: it refuses transfers: {}", device_, std::strerror(error)));
    }
}

}  // namespace tribus
