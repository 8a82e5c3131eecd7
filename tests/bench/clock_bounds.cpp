#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "tests/bench/bound.h"
#include "tests/bench/latency.h"
#include "tests/bench/subject.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

/// Counts how often the kernel programs the clock of a processor (an x86 with the TSC deadline
/// timer), in a trace of its own.
class ClockCounter {
  public:
    ClockCounter() : counts_(::mkdir(kTrace, 0700) == 0 || ::access(kTrace, F_OK) == 0) {
        counts_ = counts_ && say("buffer_size_kb", "4096") &&
                  say("events/msr/write_msr/filter", kProgramming) &&
                  say("events/msr/write_msr/enable", "1");
    }
    ClockCounter(const ClockCounter&) = delete;
    ClockCounter& operator=(const ClockCounter&) = delete;
    ~ClockCounter() {
        say("events/msr/write_msr/enable", "0");
        ::rmdir(kTrace);
    }

    bool counts() const { return counts_; }

    /// How often until now.
    std::uint64_t programmings(int cpu) const {
        std::ifstream file(fmt::format("{}/per_cpu/cpu{}/stats", kTrace, cpu));
        std::uint64_t sum = 0;
        for (std::string word; file >> word;) {
            std::uint64_t count = 0;
            if ((word == "entries:" || word == "overrun:") && file >> count) {
                sum += count;
            }
        }
        return sum;
    }

  private:
    static constexpr const char* kTrace = "/sys/kernel/tracing/instances/tribus-bounds";
    /// IA32_TSC_DEADLINE (Intel SDM volume 4, table 2-2).
    static constexpr const char* kProgramming = "msr == 0x6e0";

    static bool say(const char* file, const char* text) {
        std::ofstream stream(fmt::format("{}/{}", kTrace, file));
        return static_cast<bool>(stream << text << std::flush);
    }

    bool counts_;
};

struct Programmings {
    double programmings = 0;
    double frames = 0;
};

Programmings programmings_for(Subject& subject, std::uint64_t rounds, const ClockCounter& counter,
                              int cpu) {
    const std::uint64_t before = counter.programmings(cpu);
    drive(subject, {.rounds = rounds});
    return {.programmings = static_cast<double>(counter.programmings(cpu) - before),
            .frames = static_cast<double>(subject.arrived())};
}

/// Programmings of the clock a frame. The subject ends before this returns.
tl::expected<double, std::string> programmings_of(tl::expected<Subject, std::string> started,
                                                  const ClockCounter& counter,
                                                  const BoundSettings& settings) {
    auto subject = carrying(std::move(started));
    if (!subject) {
        return Refused(subject.error());
    }
    const TesterPriority priority;
    const auto rounds = static_cast<std::uint64_t>(settings.length / 5 / kFramePeriod);
    // Behind the last frame repeats begin. A difference of two runs is without them.
    const auto few = programmings_for(*subject, rounds / 4, counter, *settings.cpu);
    const auto many = programmings_for(*subject, rounds, counter, *settings.cpu);
    return (many.programmings - few.programmings) / (many.frames - few.frames);
}

Figures clock_programmings(const BoundSettings& settings) {
    const ClockCounter counter;
    if (!counter.counts() || !settings.cpu) {
        return Refused(
            "counts the event msr:write_msr on a processor for itself; needs root, "
            "/sys/kernel/tracing, an x86 with two processors, and no --unpinned");
    }
    const RelaySettings bare = bare_relay(settings, RelaySettings::Waits::epoll);
    const RelaySettings waiting = with_deadline(bare);
    std::vector<Figure> figures;
    for (const std::size_t lanes : {std::size_t{1}, std::size_t{64}}) {
        const std::array<tl::expected<double, std::string>, 4> counts{
            programmings_of(Subject::relay(lanes, bare), counter, settings),
            programmings_of(Subject::appliance(lanes, appliance(settings)), counter, settings),
            programmings_of(Subject::relay(lanes, waiting), counter, settings),
            programmings_of(Subject::relay(lanes, bare), counter, settings)};
        for (const auto& count : counts) {
            if (!count) {
                return Refused(count.error());
            }
        }
        const bool one = lanes == 1;
        figures.push_back(
            {.row = one ? "clock programmings a frame above bare relay"
                        : "clock programmings, 64 pipelines / bare relay",
             .value = one ? *counts[1] - *counts[0] : *counts[1] / *counts[0],
             .bound = one ? 0.05 : 1.1,
             .note = fmt::format("{:.3f} beside {:.3f} and {:.3f}, with a deadline {:.3f}",
                                 *counts[1], *counts[0], *counts[3], *counts[2])});
    }
    return figures;
}

}  // namespace

std::vector<Bound> clock_bounds() {
    return {{"clock", "how often the kernel programs its clock", true, clock_programmings}};
}

}  // namespace tribus::test
