#include "app/appliance/machine_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

namespace fs = std::filesystem;

constexpr double kPercent = 100;
constexpr double kMilli = 1e-3;
constexpr double kMicro = 1e-6;
/// While their driver starts, some thermal zones report absurd temperatures; these are the limits
/// in degrees Celsius.
constexpr double kColdest = -100;
constexpr double kHottest = 250;
/// Only the first lines of /proc/stat and /proc/meminfo are needed.
constexpr std::size_t kLongestFile = 8192;

/// The beginning of a file; nothing if it cannot be read.
std::optional<std::string> content_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        return std::nullopt;
    }
    std::string text(kLongestFile, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    return file.bad() ? std::nullopt : std::optional(std::move(text));
}

/// The first word of a file; empty if there is none.
std::string word_of(const fs::path& path) {
    std::istringstream words(content_of(path).value_or(""));
    std::string word;
    words >> word;
    return word;
}

template <class Number>
std::optional<Number> parsed(std::string_view word) {
    Number number{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    const bool whole = error == std::errc{} && end == word.data() + word.size();
    return whole && std::isfinite(static_cast<double>(number)) ? std::optional(number)
                                                               : std::nullopt;
}

/// The integer in a file, multiplied by `step`; nothing if the file holds no integer.
std::optional<double> scaled(const fs::path& path, double step) {
    const auto number = parsed<std::int64_t>(word_of(path));
    return number ? std::optional(static_cast<double>(*number) * step) : std::nullopt;
}

/// Folders in `folder` whose names begin with `beginning`, sorted.
std::vector<fs::path> folders_in(const fs::path& folder, std::string_view beginning) {
    std::vector<fs::path> found;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->path().filename().string().starts_with(beginning)) {
            found.push_back(at->path());
        }
    }
    std::ranges::sort(found);
    return found;
}

/// The number after a name such as "MemTotal:" at the start of a line.
std::optional<double> number_behind(std::string_view text, std::string_view name) {
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string key;
        std::string number;
        if (words >> key >> number && key == name) {
            return parsed<double>(number);
        }
    }
    return std::nullopt;
}

std::optional<double> greatest(std::optional<double> a, std::optional<double> b) {
    return a && b ? std::max(a, b) : a ? a : b;
}

}  // namespace

std::string machine_id(const fs::path& root) {
    return word_of(root / "etc/machine-id");
}

MachineWatch::MachineWatch(fs::path root)
    : root_(std::move(root)),
      zones_(folders_in(root_ / "sys/class/thermal", "thermal_zone")),
      supplies_(folders_in(root_ / "sys/class/power_supply", "")) {
    for (const fs::path& monitor : folders_in(root_ / "sys/class/hwmon", "hwmon")) {
        if (word_of(monitor / "name") == "rpi_volt") {
            alarm_ = monitor / "in0_lcrit_alarm";
        }
    }
}

MachineValues MachineWatch::look() {
    return {temperature(), load(), memory(), supply(), undervoltage(), uptime()};
}

std::optional<double> MachineWatch::temperature() const {
    std::optional<double> hottest;
    for (const fs::path& zone : zones_) {
        const auto degrees = scaled(zone / "temp", kMilli);
        if (degrees && *degrees > kColdest && *degrees < kHottest) {
            hottest = greatest(hottest, degrees);
        }
    }
    return hottest;
}

// user nice system idle iowait irq softirq steal; user includes the guest times that follow (Linux,
// Documentation/filesystems/proc.rst).
std::optional<MachineWatch::ProcessorTime> MachineWatch::processor_time() const {
    constexpr std::size_t kTimes = 8;
    constexpr std::size_t kIdle = 3;
    constexpr std::size_t kWaiting = 4;
    std::istringstream words(content_of(root_ / "proc/stat").value_or(""));
    std::string word;
    if (!(words >> word) || word != "cpu") {
        return std::nullopt;
    }
    ProcessorTime time;
    for (std::size_t i = 0; i < kTimes; ++i) {
        words >> word;
        const auto ticks = words ? parsed<std::uint64_t>(word) : std::nullopt;
        if (!ticks) {
            return std::nullopt;
        }
        time.all += *ticks;
        time.idle += i == kIdle || i == kWaiting ? *ticks : 0;
    }
    return time;
}

std::optional<double> MachineWatch::load() {
    const auto now = processor_time();
    const auto before = std::exchange(before_, now);
    // The iowait time may decrease.
    if (!now || !before || now->all <= before->all || now->idle < before->idle) {
        return std::nullopt;
    }
    const auto all = static_cast<double>(now->all - before->all);
    const auto idle = static_cast<double>(now->idle - before->idle);
    return std::clamp(kPercent * (all - idle) / all, 0.0, kPercent);
}

std::optional<double> MachineWatch::memory() const {
    const std::string text = content_of(root_ / "proc/meminfo").value_or("");
    const auto total = number_behind(text, "MemTotal:");
    const auto available = number_behind(text, "MemAvailable:");
    if (!total || !available || !(*total > 0)) {
        return std::nullopt;
    }
    return std::clamp(kPercent * (*total - *available) / *total, 0.0, kPercent);
}

std::optional<double> MachineWatch::supply() const {
    std::optional<double> highest;
    for (const fs::path& folder : supplies_) {
        // A battery has no "online"; an unplugged charger has 0.
        if (word_of(folder / "online") != "0") {
            highest = greatest(highest, scaled(folder / "voltage_now", kMicro));
        }
    }
    return highest;
}

std::optional<double> MachineWatch::undervoltage() const {
    const auto alarm = alarm_ ? scaled(*alarm_, 1) : std::nullopt;
    return alarm ? std::optional(*alarm != 0 ? 1.0 : 0.0) : std::nullopt;
}

std::optional<double> MachineWatch::uptime() const {
    return parsed<double>(word_of(root_ / "proc/uptime"));
}

}  // namespace tribus
