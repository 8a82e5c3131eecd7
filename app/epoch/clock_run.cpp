#include "app/epoch/clock_run.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "config/language/read_file.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// No suspend is as short. The two clocks are not read at the same time.
constexpr Duration kLeastSuspend = std::chrono::milliseconds(50);
constexpr int kReadings = 3;
constexpr std::size_t kMostWordBytes = 64;

/// The first word of a file; empty if it cannot be read.
std::string word_of(const char* path) {
    const auto text = read_file(path, kMostWordBytes, FileKinds::any).value_or("");
    return text.substr(0, text.find_first_of(" \n"));
}

/// With its own time namespace a container has other clocks.
std::string time_namespace() {
    std::error_code none;
    return std::filesystem::read_symlink("/proc/self/ns/time", none).string();
}

/// A pause between the two readings makes the difference larger.
Duration time_asleep() {
    Duration least = Duration::max();
    for (int reading = 0; reading < kReadings; ++reading) {
        const Duration awake = awake_time_now();
        least = std::min(least, monotonic_now().time_since_epoch() - awake);
    }
    return std::max(least, Duration{});
}

/// Boards without a clock that runs meanwhile do not count the time of a suspend.
std::string suspends() {
    static std::string latest;
    if (std::string now = word_of("/sys/power/suspend_stats/success"); !now.empty()) {
        latest = std::move(now);
    }
    return latest;
}

}  // namespace

bool ClockRun::is_same(const ClockRun& other) const {
    return name == other.name && std::chrono::abs(asleep - other.asleep) < kLeastSuspend;
}

ClockRun clock_run() {
    static const std::string start = word_of("/proc/sys/kernel/random/boot_id");
    static const std::string clocks = time_namespace();
    return {.name = start.empty() ? start : start + "," + clocks + "," + suspends(),
            .asleep = time_asleep()};
}

}  // namespace tribus
