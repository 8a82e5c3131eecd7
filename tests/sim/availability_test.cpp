#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
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
#include "tests/sim/stored_table.h"

/// Availability: an output has control whenever a link is usable, however many frames are marked,
/// missing or not plausible. It is compared with the rule of a flight controller.
namespace tribus::test::availability_test {
namespace {

using namespace std::chrono_literals;
using reference::PlainLinkUp;

constexpr Duration kPeriod = 10ms;
constexpr Duration kTimeout = 100ms;
/// So much later than the plain rule control may come.
constexpr Duration kMostLater = 100ms + kPeriod;
/// The share of the time in control may be so much lower.
constexpr double kMostLess = 0.001;

struct Outage {
    Instant from;
    Duration length;
};
constexpr std::array kOutages{Outage{Instant(20s), 200ms}, Outage{Instant(40s), 500ms},
                              Outage{Instant(60s), 1s}, Outage{Instant(80s), 3s}};
constexpr Instant kEnd = Instant(103s);

bool in_an_outage(Instant at) {
    return std::ranges::any_of(kOutages, [at](const Outage& outage) {
        return at >= outage.from && at < outage.from + outage.length;
    });
}

enum class Sent : std::uint8_t { good, marked, missing, implausible };

/// What becomes of the frame with that number, sent at that time.
using Quality = std::function<Sent(std::uint32_t number, Instant at, std::mt19937& random)>;

Quality share(Sent instead, double share) {
    return [=](std::uint32_t /*number*/, Instant /*at*/, std::mt19937& random) {
        return std::bernoulli_distribution(share)(random) ? instead : Sent::good;
    };
}
/// A jammed hop of 47, as FrSky's receivers mark it.
Quality one_in_47() {
    return [](std::uint32_t number, Instant /*at*/, std::mt19937& /*random*/) {
        return number % 47 == 46 ? Sent::marked : Sent::good;
    };
}
/// ExpressLRS before 3.4 marks each frame for which no new packet has come (its PR 2457).
Quality packets_per_second(int rate, Duration period) {
    return [=](std::uint32_t /*number*/, Instant at, std::mt19937& /*random*/) {
        const Duration each = Duration(1s) / rate;
        const Duration now = at.time_since_epoch();
        return now / each != (now - period) / each ? Sent::good : Sent::marked;
    };
}

struct Receiver {
    std::string_view protocol;
    Duration period{};
    bool marks = false;
};
constexpr std::array kReceivers{
    Receiver{"sbus", 7ms, true}, Receiver{"sbus", 9ms, true}, Receiver{"sbus", 14ms, true},
    Receiver{"ibus", 7700us},    Receiver{"ibus", 4ms},       Receiver{"crsf", 4ms},
    Receiver{"crsf", 20ms},      Receiver{"sumd", 10ms},      Receiver{"ghst", 4ms},
};

struct Case {
    Receiver receiver;
    std::string quality;
    std::vector<Quality> of_inputs;
    std::string mode = "priority";
};

std::string job(const Case& one) {
    std::string text;
    std::string from;
    for (std::size_t i = 0; i < one.of_inputs.size(); ++i) {
        text += fmt::format(
            "[input.in{0}]\nprotocol = \"{1}\"\ndevice = \"/dev/in{0}\"\nplausible = [900, 2100]\n",
            i, one.receiver.protocol);
        from += fmt::format("{}\"in{}\"", i == 0 ? "" : ", ", i);
    }
    return text + fmt::format(
                      "[output.out]\nprotocol = \"sbus\"\ndevice = \"/dev/out\"\n"
                      "period = \"10ms\"\nschedule = \"grid\"\n"
                      "[pipeline.main]\nfrom = [{}]\nto = \"out\"\nmode = \"{}\"\n",
                      from, one.mode);
}

/// Of one output, beside the plain rule.
struct Availability {
    /// After the start, and after each outage.
    std::vector<std::optional<Duration>> to_control;
    std::vector<std::optional<Duration>> to_control_by_rule;
    /// Whether there was a frame newer than the timeout all the time from the first good one until
    /// the rule gave control. The rule bridges longer pauses than the timeout.
    std::vector<bool> always_fresh;
    double share = 0;
    double share_by_rule = 0;
};

class Flight final : public StationObserver {
  public:
    explicit Flight(const Case& one)
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
        Availability availability{.to_control = first_control(false),
                                  .to_control_by_rule = first_control(true),
                                  .always_fresh = {}};
        for (std::size_t i = 0; i < availability.to_control.size(); ++i) {
            availability.always_fresh.push_back(
                always_fresh(event(i), availability.to_control_by_rule[i]));
        }
        for (const Seen& seen : seen_) {
            availability.share += seen.fresh && seen.control ? 1 : 0;
            availability.share_by_rule += seen.fresh && seen.up ? 1 : 0;
        }
        const auto fresh = static_cast<double>(std::ranges::count_if(seen_, &Seen::fresh));
        availability.share /= fresh;
        availability.share_by_rule /= fresh;
        return availability;
    }
    void wrote(Station /*station*/, Instant at, const Transmission& /*sent*/) override {
        // An output judges a frame by the end of its period.
        const bool fresh = std::ranges::any_of(latest_good_, [at](const auto& good) {
            return good && at + kPeriod < *good + kTimeout;
        });
        bool up = false;
        for (PlainLinkUp& rule : rules_) {
            up = rule.is_up(at) || up;
        }
        seen_.push_back({at, fresh, engine_->outputs()[0].stage() == OutputStage::control, up});
    }

  private:
    struct Seen {
        Instant at;
        bool fresh = false;
        bool control = false;
        bool up = false;
    };

    void send(std::size_t i) {
        const Instant at = next_[i];
        next_[i] += one_.receiver.period;
        const Sent sent = one_.of_inputs[i](numbers_[i]++, at, random_);
        if (sent == Sent::missing || in_an_outage(at)) {
            loop_->run_until(at);
            return;
        }
        ChannelFrame frame;
        frame.frame_lost = sent == Sent::marked;
        frame.failsafe = false;
        for (std::size_t channel = 0; channel < 16; ++channel) {
            frame.set(channel, Pulse::from_microseconds(sent == Sent::implausible ? 2140 : 1500));
        }
        loop_->receive(input_station(i), encoders_[i].encode(frame, at).bytes(), at);
        if (sent == Sent::good) {
            rules_[i].valid_frame(at);
            latest_good_[i] = at;
        }
    }

    /// After the start and after each outage: until control came.
    std::vector<std::optional<Duration>> first_control(bool by_rule) const {
        std::vector<std::optional<Duration>> all;
        const auto has = [by_rule](const Seen& seen) { return by_rule ? seen.up : seen.control; };
        const auto after = [&](Instant from) -> std::optional<Duration> {
            const auto first = std::ranges::find_if(
                seen_, [&](const Seen& seen) { return seen.at >= from && has(seen); });
            return first == seen_.end() ? std::nullopt : std::optional(first->at - from);
        };
        for (std::size_t i = 0; i <= kOutages.size(); ++i) {
            all.push_back(after(event(i)));
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
    std::mt19937 random_{2026};
};

std::vector<std::pair<std::string, Quality>> qualities(const Receiver& receiver) {
    std::vector<std::pair<std::string, Quality>> all{{"all good", share(Sent::good, 0)}};
    constexpr std::array kShares{2, 5, 10, 15, 20, 30, 50};
    const auto add = [&](std::string_view name, Sent instead) {
        for (const int percent : kShares) {
            all.emplace_back(fmt::format("{} % {}", percent, name),
                             share(instead, percent / 100.0));
        }
    };
    if (receiver.marks) {
        add("marked", Sent::marked);
        all.emplace_back("one in 47 marked", one_in_47());
        for (const int rate : {25, 50, 100, 150}) {
            if (rate * receiver.period < 1s) {
                all.emplace_back(fmt::format("ExpressLRS at {} Hz", rate),
                                 packets_per_second(rate, receiver.period));
            }
        }
    }
    add("missing", Sent::missing);
    add("implausible", Sent::implausible);
    return all;
}

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const Receiver& receiver : kReceivers) {
        for (const auto& [name, quality] : qualities(receiver)) {
            all.push_back({receiver, name, {quality}});
        }
    }
    for (const std::string_view mode : {"priority", "sticky", "freshest", "median"}) {
        for (const auto& [name, quality] : qualities(kReceivers[1])) {
            const std::size_t count = mode == "median" ? 3 : 2;
            all.push_back(
                {kReceivers[1], name, std::vector<Quality>(count, quality), std::string(mode)});
        }
    }
    return all;
}

std::string seconds(const std::vector<std::optional<Duration>>& durations) {
    std::string text;
    for (const auto& duration : durations) {
        text += duration ? fmt::format(" {:5.2f}", std::chrono::duration<double>(*duration).count())
                         : "     -";
    }
    return text;
}

TEST(Availability, is_that_of_a_flight_controller_or_better) {
    std::string table =
        "# Time in seconds until an SBUS output has control, after the start and after outages of\n"
        "# 0.2, 0.5, 1 and 3 s, and the share of the time in control in which a frame newer than\n"
        "# the timeout (100 ms) existed; first of tribus (recover 500 ms), then of the plain rule\n"
        "# of a flight controller (up after 500 ms without a pause of 150 ms between valid\n"
        "# frames).\n";
    std::string before;
    for (const Case& one : cases()) {
        const Availability availability = Flight(one).availability();
        const std::string title =
            fmt::format("\n{} each {:.1f} ms{}\n", one.receiver.protocol,
                        std::chrono::duration<double, std::milli>(one.receiver.period).count(),
                        one.of_inputs.size() == 1
                            ? ""
                            : fmt::format(", {} receivers, {}", one.of_inputs.size(), one.mode));
        table += title == before ? "" : title;
        before = title;
        table +=
            fmt::format("{:<22}{}  {:6.2f} %  |{}  {:6.2f} %\n", one.quality,
                        seconds(availability.to_control), 100 * availability.share,
                        seconds(availability.to_control_by_rule), 100 * availability.share_by_rule);
        SCOPED_TRACE(title + one.quality);
        EXPECT_GE(availability.share, availability.share_by_rule - kMostLess);
        for (std::size_t i = 0; i < availability.to_control.size(); ++i) {
            const auto& by_rule = availability.to_control_by_rule[i];
            if (by_rule && availability.always_fresh[i]) {
                ASSERT_TRUE(availability.to_control[i]) << "no control after event " << i;
                EXPECT_LE(*availability.to_control[i], *by_rule + kMostLater) << "event " << i;
            }
        }
    }
    expect_stored("availability.txt", table);
}

}  // namespace
}  // namespace tribus::test::availability_test
