#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "config/build/build.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/reference/plain_link_up.h"
#include "tests/sim/simulation.h"

/// An output of one or several receivers of some quality in virtual time, beside the rule of a
/// flight controller.
namespace tribus::test::availability {

using namespace std::chrono_literals;
using reference::PlainLinkUp;

inline constexpr Duration kPeriod = 10ms;
inline constexpr Duration kTimeout = 100ms;
inline constexpr Duration kRecover = 500ms;

struct Outage {
    Instant from;
    Duration length;
    bool of_all;  ///< or of the first receiver only
};
inline constexpr std::array kOutages{
    Outage{Instant(20s), 200ms, true}, Outage{Instant(40s), 500ms, false},
    Outage{Instant(60s), 1s, true}, Outage{Instant(80s), 3s, false}};
inline constexpr Instant kEnd = Instant(103s);

inline bool in_an_outage(std::size_t receiver, Instant at) {
    return std::ranges::any_of(kOutages, [=](const Outage& outage) {
        return (outage.of_all || receiver == 0) && at >= outage.from &&
               at < outage.from + outage.length;
    });
}

enum class Sent : std::uint8_t { good, marked, missing, implausible };

/// Tells what becomes of the frame with that number, sent at that time.
using Quality = std::function<Sent(std::uint32_t number, Instant at, std::mt19937& random)>;

struct Receiver {
    std::string_view protocol;
    Duration period{};
    bool marks = false;
    /// Pulses in us: what counts as plausible, and one outside that its frames can carry.
    std::string_view plausible = "[900, 2100]";
    int implausible = 2140;
};

struct Case {
    Receiver receiver;
    std::string quality;  ///< of the first receiver
    std::vector<Quality> of_inputs;
    std::string mode = "priority";
};

inline std::string job(const Case& one) {
    std::string text;
    std::string from;
    for (std::size_t i = 0; i < one.of_inputs.size(); ++i) {
        text += fmt::format(
            "[input.in{0}]\nprotocol = \"{1}\"\ndevice = \"/dev/in{0}\"\nplausible = {2}\n", i,
            one.receiver.protocol, one.receiver.plausible);
        from += fmt::format("{}\"in{}\"", i == 0 ? "" : ", ", i);
    }
    return text + fmt::format(
                      "[output.out]\nprotocol = \"sbus\"\ndevice = \"/dev/out\"\n"
                      "period = \"10ms\"\nschedule = \"grid\"\n"
                      "[pipeline.main]\nfrom = [{}]\nto = \"out\"\nmode = \"{}\"\n",
                      from, one.mode);
}

/// The control of one output, beside that of the plain rule.
struct Availability {
    /// After the start, and after each outage.
    std::vector<std::optional<Duration>> to_control;
    std::vector<std::optional<Duration>> to_control_by_rule;
    /// Until there had been fresh frames for `recover` without a pause.
    std::vector<std::optional<Duration>> to_recovery;
    /// Whether there were fresh frames all the time from the first good one until the rule gave
    /// control. The rule bridges longer pauses than the timeout.
    std::vector<bool> always_fresh;
    double share = 0;
    double share_by_rule = 0;
    /// The share of the time in control in which the first receiver had it.
    double share_of_first = 0;
    std::uint64_t implausible_sent = 0;
    std::uint64_t implausible_seen = 0;
};

class ReceivedFlight final : public StationObserver {
  public:
    explicit ReceivedFlight(const Case& one)
        : one_(one),
          configuration_(configuration_of(job(one))),
          engine_(build_engine(configuration_)) {
        for (std::size_t i = 0; i < one.of_inputs.size(); ++i) {
            const InputConfig& input = configuration_.inputs[i];
            encoders_.emplace_back(input.protocol->make_encoder(input.settings));
            rules_.emplace_back(Instant{});
            latest_good_.emplace_back();
            // Two receivers of one transmitter are not in step.
            next_.push_back(Instant(1ms) + i * one.receiver.period / 3);
        }
        numbers_.resize(next_.size());
        loop_.emplace(*engine_, *this, Instant{});
    }

    Availability availability() {
        while (true) {
            const auto next = std::ranges::min_element(next_);
            if (*next >= kEnd) {
                break;
            }
            send(static_cast<std::size_t>(next - next_.begin()));
        }
        loop_->run_until(kEnd);
        Availability availability{.to_control = after_events(&Seen::control),
                                  .to_control_by_rule = after_events(&Seen::up),
                                  .to_recovery = after_events(&Seen::recovered),
                                  .always_fresh = {},
                                  .implausible_sent = implausible_sent_};
        for (std::size_t i = 0; i < availability.to_control.size(); ++i) {
            availability.always_fresh.push_back(
                always_fresh(event(i), availability.to_control_by_rule[i]));
        }
        const auto share = [&](bool Seen::*what, bool Seen::*of) {
            const auto both = std::ranges::count_if(
                seen_, [=](const Seen& seen) { return seen.*what && seen.*of; });
            return static_cast<double>(both) /
                   static_cast<double>(std::ranges::count_if(seen_, of));
        };
        availability.share = share(&Seen::control, &Seen::fresh);
        availability.share_by_rule = share(&Seen::up, &Seen::fresh);
        availability.share_of_first = share(&Seen::by_first, &Seen::control);
        for (const Input& input : engine_->inputs()) {
            availability.implausible_seen += input.link().implausible().frames;
        }
        return availability;
    }
    void wrote(Station /*station*/, Instant at, const Transmission& /*sent*/) override {
        const bool fresh = std::ranges::any_of(
            latest_good_, [at](const auto& good) { return good && at < *good + kTimeout; });
        stale_at_ = fresh ? stale_at_ : at;
        bool up = false;
        for (PlainLinkUp& rule : rules_) {
            up = rule.is_up(at) || up;
        }
        const Output& output = engine_->outputs()[0];
        seen_.push_back({.at = at,
                         .fresh = fresh,
                         .recovered = at - stale_at_ > kRecover,
                         .control = output.stage() == OutputStage::control,
                         .up = up,
                         .by_first = output.controlling_input() == std::size_t{0}});
    }

  private:
    struct Seen {
        Instant at;
        bool fresh = false;
        bool recovered = false;
        bool control = false;
        bool up = false;
        bool by_first = false;
    };

    void send(std::size_t i) {
        const Instant at = next_[i];
        next_[i] += one_.receiver.period;
        const Sent sent = one_.of_inputs[i](numbers_[i]++, at, random_);
        if (sent == Sent::missing || in_an_outage(i, at)) {
            loop_->run_until(at);
            return;
        }
        ChannelFrame frame;
        frame.frame_lost = sent == Sent::marked;
        frame.failsafe = false;
        for (std::size_t channel = 0; channel < 16; ++channel) {
            frame.set(channel, Pulse::from_microseconds(1500));
        }
        if (sent == Sent::implausible) {
            // Of the channels that each frame of GHST has.
            frame.set(0, Pulse::from_microseconds(one_.receiver.implausible));
        }
        implausible_sent_ += sent == Sent::implausible ? 1 : 0;
        loop_->receive(input_station(i), encoders_[i].encode(frame, at).bytes(), at);
        if (sent == Sent::good) {
            rules_[i].valid_frame(at);
            latest_good_[i] = at;
        }
    }

    /// After the start and after each outage: until `what` came.
    std::vector<std::optional<Duration>> after_events(bool Seen::*what) const {
        std::vector<std::optional<Duration>> all;
        for (std::size_t i = 0; i <= kOutages.size(); ++i) {
            const auto first = std::ranges::find_if(
                seen_, [&](const Seen& seen) { return seen.at >= event(i) && seen.*what; });
            all.push_back(first == seen_.end() ? std::nullopt
                                               : std::optional(first->at - event(i)));
        }
        return all;
    }

    static Instant event(std::size_t i) {
        return i == 0 ? Instant{} : kOutages[i - 1].from + kOutages[i - 1].length;
    }
    bool always_fresh(Instant from, const std::optional<Duration>& until) const {
        bool begun = false;
        for (const Seen& seen : seen_) {
            if (seen.at >= from && (!until || seen.at <= from + *until)) {
                begun = begun || seen.fresh;
                if (begun && !seen.fresh) {
                    return false;
                }
            }
        }
        return true;
    }

    const Case& one_;
    Configuration configuration_;
    std::unique_ptr<Engine> engine_;
    std::optional<VirtualLoop> loop_;
    std::vector<FrameEncoder> encoders_;
    std::vector<PlainLinkUp> rules_;
    std::vector<std::optional<Instant>> latest_good_;
    std::vector<Instant> next_;
    std::vector<std::uint32_t> numbers_;
    std::vector<Seen> seen_;
    Instant stale_at_{};
    std::uint64_t implausible_sent_ = 0;
    std::mt19937 random_{2026};
};

}  // namespace tribus::test::availability
