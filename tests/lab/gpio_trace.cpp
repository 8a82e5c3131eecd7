#include "tests/lab/gpio_trace.h"

#include <algorithm>
#include <regex>
#include <sstream>

#include "tests/lab/shell.h"

namespace tribus::test {

namespace {

using Clock = std::chrono::steady_clock;

const std::string kTracing = "/sys/kernel/tracing";

struct Event {
    Clock::time_point at;
    std::string level;
};

std::vector<Event> events() {
    // `tribus-gpio-217  [001] d..1.  1234.567890: gpio_value: 509 set 1`
    static const std::regex kSet(R"( (\d+)\.(\d{6}): gpio_value: +\d+ +set +(\d))");
    std::istringstream trace(read_file(kTracing + "/trace"));
    std::vector<Event> all;
    std::smatch parts;
    for (std::string line; std::getline(trace, line);) {
        if (std::regex_search(line, parts, kSet)) {
            all.push_back({Clock::time_point(std::chrono::seconds(std::stoll(parts[1])) +
                                             std::chrono::microseconds(std::stoll(parts[2]))),
                           parts[3]});
        }
    }
    return all;
}

}  // namespace

LevelTrace::LevelTrace() {
    shell("mountpoint -q " + kTracing + " || mount -t tracefs none " + kTracing);
    // Uses the clock of steady_clock. This also clears the trace.
    write_kernel_file(kTracing + "/trace_clock", "mono");
    shell(": >" + kTracing + "/trace");
    write_kernel_file(kTracing + "/events/gpio/gpio_value/enable", "1");
}

LevelTrace::~LevelTrace() {
    write_kernel_file(kTracing + "/events/gpio/enable", "0");
}

std::vector<std::string> LevelTrace::levels() const {
    std::vector<std::string> levels;
    for (const Event& event : events()) {
        levels.push_back(event.level);
    }
    return levels;
}

std::vector<Clock::time_point> LevelTrace::edges() const {
    const std::vector<Event> all = events();
    std::vector<Clock::time_point> edges;
    for (std::size_t i = 1; i < all.size(); ++i) {
        if (all[i].level != all[i - 1].level) {
            edges.push_back(all[i].at);
        }
    }
    return edges;
}

std::size_t LevelTrace::edges_after(Clock::time_point instant) const {
    const auto all = edges();
    return static_cast<std::size_t>(
        std::ranges::count_if(all, [&](Clock::time_point edge) { return edge > instant; }));
}

}  // namespace tribus::test
