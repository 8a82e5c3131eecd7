#include "tests/bench/lateness.h"

#include <pthread.h>
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "config/build/build.h"
#include "config/language/mistakes.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/data_thread.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/scheduling.h"
#include "tests/bench/tester.h"

namespace tribus::bench {
namespace {

/// The devices are never opened: the output gets a StampingLink, the input none.
constexpr const char* kConfiguration = R"([input.receiver]
protocol = "ibus"
device = "/dev/receiver"
[output.servos]
protocol = "sbus"
device = "/dev/servos"
period = "7ms"
schedule = "grid"
[pipeline.main]
from = "receiver"
to = "servos"
)";
static_assert(kGridPeriod == std::chrono::milliseconds(7), "as in the configuration");

SchedulingSettings scheduling_of(const LatenessSettings& settings) {
    SchedulingSettings scheduling;
    scheduling.priority = settings.priority.value_or(scheduling.priority);
    scheduling.cpu = settings.cpu;
    scheduling.realtime = settings.priority.has_value();
    return scheduling;
}

/// The first samples come from a thread that is not warmed up.
constexpr std::size_t kWarmUp = 4;

/// Accepts every frame and notes how late it is. Allocates only in its constructor.
class StampingLink final : public ByteLink {
  public:
    StampingLink(const Output& output, std::vector<Duration>& late, std::size_t most)
        : output_(output), late_(late) {
        late_.reserve(most);
    }
    ReadStatus read(Reception&) override { return ReadStatus::nothing; }
    WriteStatus write(std::span<const std::uint8_t>) override {
        // The deadline was a whole number of periods before the next one.
        const Duration ahead = (output_.due() - monotonic_now()) % kGridPeriod;
        if (++frames_ > kWarmUp && late_.size() < late_.capacity()) {
            late_.push_back(kGridPeriod - ahead);
        }
        return WriteStatus::written;
    }
    void discard_unread() override {}
    int descriptor() const override { return -1; }

  private:
    const Output& output_;
    std::vector<Duration>& late_;
    std::size_t frames_ = 0;
};

Distribution bare_timer(const LatenessSettings& settings, Instant first, std::size_t periods) {
    std::vector<Duration> late;
    late.reserve(periods);
    const Scheduling scheduling = make_realtime(scheduling_of(settings));
    for (std::size_t i = 0; i < periods && !interrupted(); ++i) {
        const Instant deadline = first + static_cast<std::int64_t>(i) * kGridPeriod;
        sleep_until(deadline);
        const Instant now = monotonic_now();
        if (i >= kWarmUp) {
            late.push_back(now - deadline);
        }
    }
    return Distribution(std::move(late));
}

}  // namespace

tl::expected<LatenessResult, std::string> measure_lateness(const LatenessSettings& settings) {
    auto configuration = load_configuration(kConfiguration, "bench");
    if (!configuration) {
        return tl::unexpected(format_mistake(configuration.error().front()));
    }
    const auto periods = static_cast<std::size_t>(settings.length / kGridPeriod);
    const auto engine = build_engine(*configuration);
    std::vector<Duration> grid;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    for (const PortPlan& plan : plan_ports(*configuration)) {
        const bool is_output = first_of(plan.wiring.stations, StationKind::output).has_value();
        wiring.push_back(plan.wiring);
        links.push_back(
            is_output ? std::make_unique<StampingLink>(engine->outputs().front(), grid, periods)
                      : nullptr);
    }
    Loop loop(*engine, std::move(wiring), std::move(links));
    if (auto prepared = loop.prepare(); !prepared) {
        return tl::unexpected(prepared.error());
    }
    DataThread thread(loop, scheduling_of(settings));
    if (auto prepared = thread.prepare(); !prepared) {
        return tl::unexpected(prepared.error());
    }
    thread.run();
    const Instant bare_first = monotonic_now() + 2 * kGridPeriod + kGridPeriod / 2;
    Distribution bare;
    std::thread alone([&] { bare = bare_timer(settings, bare_first, periods); });
    alone.join();
    loop.request_end();
    thread.join();
    ::munlockall();
    return LatenessResult{Distribution(std::move(grid)), std::move(bare)};
}

}  // namespace tribus::bench
