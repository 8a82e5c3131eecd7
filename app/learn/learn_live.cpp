#include "app/learn/learn_live.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/cli/streams.h"
#include "app/learn/frame_collector.h"
#include "app/learn/learn_step.h"
#include "config/build/build.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/can/can_link.h"
#include "transports/links/link.h"

namespace tribus {
namespace {

using namespace std::chrono_literals;

constexpr Duration kHandsOffTime = 5s;
/// Receivers need up to two seconds to notice; their failsafe must be seen for some time after
/// that.
constexpr Duration kOffTime = 8s;
constexpr Duration kBackTime = 3s;
constexpr int kPollMilliseconds = 20;

/// Waits for the receiver and the person at the same time.
class Watch {
  public:
    Watch(const InputConfig& input, std::unique_ptr<Link> link)
        : collector_(input), link_(std::move(link)) {}

    /// Returns false if the device or the terminal is gone.
    bool until_enter() {
        bool entered = false;
        while (fine_ && !entered) {
            entered = wait(true);
        }
        return fine_;
    }
    bool for_time(Duration time) {
        const Instant until = monotonic_now() + time;
        while (fine_ && monotonic_now() < until) {
            wait(false);
        }
        return fine_;
    }
    FrameCollector& collector() { return collector_; }

  private:
    /// Receives from the device; returns true if the person pressed Enter.
    bool wait(bool for_person) {
        std::array<pollfd, 2> watched{
            {{link_->descriptor(), POLLIN, 0}, {for_person ? STDIN_FILENO : -1, POLLIN, 0}}};
        ::poll(watched.data(), watched.size(), kPollMilliseconds);
        if (watched[0].revents != 0) {
            take();
        }
        if (watched[1].revents == 0) {
            return false;
        }
        std::array<char, 256> line{};
        fine_ = fine_ && ::read(STDIN_FILENO, line.data(), line.size()) > 0;
        return true;
    }
    void take() {
        const Instant now = monotonic_now();
        if (ByteLink* bytes = link_->as_bytes()) {
            fine_ = bytes->read(reception_) != ReadStatus::lost && fine_;
            if (fine_) {
                collector_.receive(reception_.view(), reception_.damaged, now);
            }
            return;
        }
        fine_ = link_->as_can()->read(can_reception_, now, wall_time_now()) != ReadStatus::lost;
        for (const ReceivedCanFrame& received : can_reception_.view()) {
            collector_.receive(received.frame, received.at);
        }
    }

    FrameCollector collector_;
    std::unique_ptr<Link> link_;
    Reception reception_;
    CanReception can_reception_;
    bool fine_ = true;
};

/// Tells the person what to do, for the terminal or as JSON.
class LearnPrompts {
  public:
    explicit LearnPrompts(LearnGuide guide) : json_(guide == LearnGuide::json) {}

    void move() const {
        constexpr std::string_view kMove =
            "Transmitter and receiver on. Move every stick and every switch to both of its ends, "
            "twice.";
        json_ ? tell_learn_step("waiting", fmt::format("{} Then hands off.", kMove))
              : tell_person(fmt::format("{} Then press Enter.", kMove), "1/4  ");
    }
    void hands_off() const {
        if (!json_) {
            tell_person("Throttle low, hands off the sticks for five seconds ...", "2/4  ");
        }
    }
    void off() const {
        json_ ? tell_learn_step("off",
                                "Switch the transmitter OFF. The next step comes eight "
                                "seconds after you say so.")
              : tell_person("Switch the transmitter OFF, then press Enter and wait eight seconds.",
                            "3/4  ");
    }
    void wait() const {
        if (!json_) {
            tell_person("...", "     ");
        }
    }
    void on() const {
        json_ ? tell_learn_step("on", "Switch the transmitter ON again, until it is connected.")
              : tell_person("Switch the transmitter ON again. When it is connected, press Enter.",
                            "4/4  ");
    }

  private:
    bool json_;
};

}  // namespace

tl::expected<LearnedFrames, std::string> watch_with_a_person(const Configuration& configuration,
                                                             std::size_t input, LearnGuide guide) {
    if (guide == LearnGuide::terminal && ::isatty(STDIN_FILENO) == 0) {
        return tl::unexpected(std::string(
            "a person must switch the transmitter off and on, so this needs a terminal; without "
            "one give a recording: --recording FILE --off-at 12s --back-at 20s"));
    }
    const auto engine = build_engine(configuration);
    const auto values = build_value_engine(configuration, *engine);
    const auto plans = plan_ports(configuration);
    const auto plan = std::ranges::find_if(plans, [&](const PortPlan& candidate) {
        const auto& stations = candidate.wiring.stations;
        return std::ranges::find(stations, input_station(input)) != stations.end();
    });
    auto link = open_port(configuration, Stations(*engine, values.get()), *plan);
    if (!link) {
        return tl::unexpected(link.error());
    }
    Watch watch(configuration.inputs[input], std::move(*link));
    LearnedFrames learned;
    const LearnPrompts prompts(guide);
    prompts.move();
    bool fine = watch.until_enter();
    if (fine && watch.collector().frames().empty()) {
        const PortConfig& port = configuration.inputs[input].port;
        return tl::unexpected(fmt::format(
            "no frame came; {}`tribus run` with this configuration says what comes instead",
            port.medium->silence.doctor.empty()
                ? ""
                : fmt::format("`tribus doctor {}` or ", port.device)));
    }
    prompts.hands_off();
    fine = fine && watch.for_time(kHandsOffTime);
    learned.times.off = monotonic_now();
    prompts.off();
    fine = fine && watch.until_enter();
    prompts.wait();
    fine = fine && watch.for_time(kOffTime);
    learned.times.back = monotonic_now();
    prompts.on();
    fine = fine && watch.until_enter() && watch.for_time(kBackTime);
    if (!fine) {
        return tl::unexpected(fmt::format("{}: the device or the terminal is gone; nothing learned",
                                          configuration.inputs[input].port.device));
    }
    if (watch.collector().overflowed()) {
        return tl::unexpected(fmt::format(
            "more than {} frames came, some 12 minutes of a usual receiver; begin again, "
            "and let less time pass between the steps",
            FrameCollector::kMostFrames));
    }
    learned.frames = watch.collector().take_frames();
    return learned;
}

}  // namespace tribus
