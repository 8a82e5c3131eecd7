#include "transports/links/spi/spi_pace.h"

#include <chrono>
#include <cmath>
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

bool SpiPace::is_right() {
    constexpr Duration kPause = std::chrono::seconds(1);
    if (!fits_ && worker_.now() - measured_at_ >= kPause) {
        measure_anew();
    }
    return fits_;
}

void SpiPace::transferred(std::size_t bytes, Duration took) {
    told_refusal_ = false;
    watch_.transferred(bytes, took);
    if (const std::size_t zeros = watch_.wanted_zeros(); zeros > 0) {
        const auto compared = zeros_through(port_.file, worker_.now)(port_.hz, zeros);
        if (compared && watch_.compared(*compared)) {
            measure_anew();
        }
    }
}

void SpiPace::measure_anew() {
    const auto found = find_spi_rate(byte_time_, zeros_through(port_.file, worker_.now));
    measured_at_ = worker_.now();
    watch_ = SpiClockWatch(byte_time_);
    fits_ = found.has_value();
    if (!found) {
        warn(told_no_rate_, fmt::format("its clock has changed, and {}", found.error()));
        return;
    }
    told_no_rate_ = false;
    constexpr double kPercent = 100;
    const double change = static_cast<double>(port_.hz) / *found - 1;
    port_.hz = *found;
    if (std::abs(change) > SpiClockWatch::kMostDrift / 2) {
        warn(told_change_,
             fmt::format("its clock has changed by {:+.1f} %: bits were wrong until now, when it "
                         "was measured anew",
                         change * kPercent));
    }
}

void SpiPace::refused(int error) {
    if (worker_.warn != nullptr && !std::exchange(told_refusal_, true)) {
        worker_.warn(fmt::format("{}: it refuses transfers: {}", device_, std::strerror(error)));
    }
}

/// A clock that changes once changes again and again.
void SpiPace::warn(bool& told, const std::string& what) {
    if (worker_.warn != nullptr && !std::exchange(told, true)) {
        worker_.warn(fmt::format(
            "{}: {}. Fix the core's clock: core_freq_min=500 (Raspberry Pi 4) or core_freq=250 "
            "(Raspberry Pi 3) in config.txt",
            device_, what));
    }
}

}  // namespace tribus
