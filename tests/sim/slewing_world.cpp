#include "tests/sim/slewing_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "tests/sim/simulation.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kEnd = Instant(20s);
/// Both values of a step are rounded to an eighth, and what a reload begins from is too.
constexpr double kRoundedUs = 0.2;

double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

}  // namespace

struct SlewingWorld::Stage {
    Configuration configuration;
    std::unique_ptr<Engine> engine;
};

SlewingWorld::~SlewingWorld() = default;

Duration SlewingWorld::between(Duration low, Duration high) {
    return low + std::chrono::microseconds(below(static_cast<std::size_t>((high - low) / 1us)));
}

double SlewingWorld::any_rate() {
    constexpr std::array kRates{10., 100., 1000., 4000.};
    return kRates[below(kRates.size())];
}

SlewingWorld::SlewingWorld(std::uint64_t seed) : random_(seed) {
    receivers_.resize(1 + below(3));
    for (Receiver& receiver : receivers_) {
        receiver.sbus = chance(60);
        receiver.interval = between(4ms, 20ms);
        receiver.next = Instant(between(0ms, 500ms));
    }
    const std::size_t outputs = 1 + below(3);
    for (std::size_t i = 0; i < outputs; ++i) {
        const bool sbus = chance(60);
        const auto period = between(sbus ? 7ms : 5ms, 30ms) / 1ms;
        constexpr std::array kSchedules{"", "schedule = \"grid\"\n",
                                        "schedule = \"grid\"\nphase = \"locked\"\n"};
        outputs_.push_back(fmt::format("protocol = \"{}\"\nperiod = \"{}ms\"\nforce = true\n{}",
                                       sbus ? "sbus" : "ibus", period, kSchedules[below(3)]));
    }
    constexpr std::array kModes{"priority", "sticky", "freshest", "median"};
    mode_ = receivers_.size() == 1 ? "priority" : kModes[below(receivers_.size() == 3 ? 4 : 3)];
    const bool all_mark = std::ranges::all_of(
        outputs_, [](const std::string& o) { return o.find("sbus") != o.npos; });
    action_ = chance(60) ? "preset" : chance(50) && all_mark ? "hold" : "silence";
    input_slew_ = any_rate();
    failsafe_slew_ = chance(60) ? std::optional(any_rate()) : std::nullopt;
    const bool may_change = receivers_.size() > 1 && mode_ != "freshest";
    changeover_ = may_change && chance(60) ? std::optional(any_rate()) : std::nullopt;
    draw();
    latest_.resize(outputs_.size());
    stage_ = stage_of(text());
    loop_ = std::make_unique<VirtualLoop>(*stage_->engine, *this, Instant{});
}

/// What a reload changes.
void SlewingWorld::draw() {
    map_slew_ = any_rate();
    hold_ = chance(30) ? between(1s, 9s) : between(0ms, 900ms);
    recover_ = between(0ms, 600ms);
    trim_us_ = static_cast<int>(below(100));
}

std::string SlewingWorld::text() const {
    std::string text = "[gpio.stop]\nline = \"STOP\"\nrole = \"force_failsafe\"\n";
    std::string from;
    std::string to;
    for (std::size_t i = 0; i < receivers_.size(); ++i) {
        text += fmt::format(
            "[input.in{0}]\nprotocol = \"{1}\"\ndevice = \"/dev/in{0}\"\n[input.in{0}.map]\n"
            "2 = {{ from = 2, slew = \"{2}us/s\" }}\n9 = {{ from = 9, trim = {3} }}\n",
            i, receivers_[i].sbus ? "sbus" : "ibus", input_slew_, trim_us_ / 10);
        from += fmt::format("{}\"in{}\"", i == 0 ? "" : ", ", i);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        text += fmt::format("[output.out{0}]\ndevice = \"/dev/out{0}\"\n{1}", i, outputs_[i]);
        to += fmt::format("{}\"out{}\"", i == 0 ? "" : ", ", i);
    }
    text +=
        fmt::format("[pipeline.main]\nfrom = [{}]\nto = [{}]\nmode = \"{}\"\n", from, to, mode_);
    if (changeover_) {
        text += fmt::format("changeover = \"{}us/s\"\n", *changeover_);
    }
    text += fmt::format(
        "[pipeline.main.failsafe]\naction = \"{}\"\nhold = \"{}ms\"\n"
        "recover = \"{}ms\"\n",
        action_, hold_ / 1ms, recover_ / 1ms);
    if (failsafe_slew_) {
        text += fmt::format("slew = \"{}us/s\"\n", *failsafe_slew_);
    }
    return text + fmt::format(
                      "[pipeline.main.channels]\n"
                      "1 = {{ from = 1, reverse = true, slew = \"{}us/s\" }}\n"
                      "10 = {{ from = 10, trim = {} }}\n",
                      map_slew_, trim_us_);
}

std::unique_ptr<SlewingWorld::Stage> SlewingWorld::stage_of(const std::string& text) {
    auto stage = std::make_unique<Stage>();
    stage->configuration = configuration_of(text);
    stage->engine = build_engine(stage->configuration);
    return stage;
}

/// Silence and failsafe flags from a few milliseconds to longer than any `hold` but the longest.
void SlewingWorld::trouble(Receiver& receiver, Instant at) {
    if (at >= receiver.sticks_stay_until) {
        receiver.first_us = 1000 + static_cast<int>(below(1001));
        receiver.second_us = 1000 + static_cast<int>(below(1001));
        receiver.sticks_stay_until = at + between(100ms, 1500ms);
    }
    if (chance(1)) {
        receiver.silent_until = at + (chance(60) ? between(20ms, 500ms) : between(500ms, 4s));
    }
    if (receiver.sbus && chance(1)) {
        receiver.failsafe_until = at + between(20ms, 1500ms);
    }
}

/// `read_at`: the thread stands still, so that the bytes are read later and may be of then.
void SlewingWorld::send(std::size_t index, Instant at, std::optional<Instant> read_at) {
    Receiver& receiver = receivers_[index];
    receiver.next = at + receiver.interval + between(0ms, 1ms);
    trouble(receiver, at);
    if (at < receiver.silent_until) {
        return;
    }
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 14; ++channel) {
        frame.set(channel, kCentrePulse);
    }
    frame.set(0, Pulse::from_microseconds(receiver.first_us));
    frame.set(1, Pulse::from_microseconds(receiver.second_us));
    frame.set(2, Pulse::from_microseconds(1100 + 300 * static_cast<int>(index)));
    frame.failsafe = at < receiver.failsafe_until;
    frame.frame_lost = frame.failsafe;
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = receiver.sbus ? SbusEncoder().write(frame, wire, at)
                                             : IbusEncoder(14).write(frame, wire, at);
    const auto bytes = std::span(wire).first(length);
    if (read_at) {
        stage_->engine->receive(index, bytes, *read_at);
    } else {
        loop_->receive(input_station(index), bytes, at);
    }
}

void SlewingWorld::stall(Instant since, Instant until) {
    loop_->run_until(since);
    for (std::size_t i = 0; i < receivers_.size(); ++i) {
        const bool discarded = until - since >= stage_->engine->inputs()[i].link().timeout();
        while (receivers_[i].next < until) {
            if (discarded) {
                receivers_[i].next += receivers_[i].interval;
                stage_->engine->bytes_discarded(i);
            } else {
                send(i, receivers_[i].next, since);
            }
        }
    }
    loop_->come_back(since, until);
}

void SlewingWorld::reload(Instant at) {
    loop_->run_until(at);
    draw();
    auto next = stage_of(text());
    const CarryOver plan = plan_carry_over(stage_->configuration, next->configuration);
    next->engine->start(at);
    next->engine->continue_from(*stage_->engine, plan.engine, at);
    std::swap(stage_, next);
    loop_->go_on_with(*stage_->engine, nullptr, at);
}

void SlewingWorld::own_trouble(Instant at) {
    switch (below(4)) {
        case 0:
            stall(at, at + (chance(50) ? between(1ms, 90ms) : between(90ms, 1s)));
            break;
        case 1:
        case 2:
            reload(at);
            break;
        default:
            loop_->run_until(at);
            forced_ = !forced_ && chance(50);
            stage_->engine->set_lines({.active = forced_ ? 1U : 0U, .known = 1}, at);
    }
}

void SlewingWorld::run_to_the_end() {
    Instant next_own = Instant(between(1s, 2s));
    while (!fault_) {
        const auto next = std::ranges::min_element(receivers_, {}, &Receiver::next);
        const Instant at = std::min(next->next, next_own);
        if (at >= kEnd) {
            return;
        }
        if (at == next_own) {
            own_trouble(at);
            next_own = loop_->now() + between(50ms, 1s);
        } else {
            send(static_cast<std::size_t>(next - receivers_.begin()), at);
        }
    }
}

std::optional<std::string> SlewingWorld::too_large_step() {
    run_to_the_end();
    return fault_ ? std::optional(*fault_ + "\n" + text()) : std::nullopt;
}

void SlewingWorld::wrote(Station station, Instant at, const Transmission& /*sent*/) {
    const Output& output = stage_->engine->outputs()[station.index];
    if (!output.sends()) {
        return;
    }
    const Step now{.at = at,
                   .frame = output.latest(),
                   .failsafe = output.latest().failsafe,
                   .failsafe_entries = output.counts().failsafe_entries,
                   .changeovers = output.counts().changeovers,
                   .map_slew = map_slew_};
    if (std::optional<Step>& before = latest_[station.index]) {
        judge(station.index, *before, now);
    }
    latest_[station.index] = now;
}

void SlewingWorld::judge(std::size_t output, const Step& before, const Step& now) {
    const double no_limit = INFINITY;
    const bool presets = action_ == "preset";
    const bool returns =
        !now.failsafe && (before.failsafe || now.failsafe_entries != before.failsafe_entries);
    const bool changes = now.changeovers != before.changeovers;
    const double of_presets = presets ? failsafe_slew_.value_or(no_limit) : no_limit;
    const double of_change = changeover_.value_or(no_limit);
    // Behind silence there is nothing from which a way back could lead.
    const double of_return = action_ == "silence" ? no_limit : failsafe_slew_.value_or(no_limit);
    // Only presets move a channel in failsafe.
    const double of_failsafe = action_ == "hold" ? 0 : of_presets;

    expect_within(output, 0, before, now,
                  now.failsafe ? of_failsafe : std::max(before.map_slew, now.map_slew));
    // A glide that is under way may catch up with the slew of the input.
    const double gliding =
        std::max({input_slew_, failsafe_slew_.value_or(0), changeover_.value_or(0)});
    expect_within(output, 1, before, now,
                  now.failsafe ? of_failsafe
                  : returns    ? std::max(of_return, gliding)
                  : changes    ? std::max(of_change, gliding)
                               : gliding);
    const bool one_stick = mode_ == "priority" || mode_ == "sticky";
    const double of_input = receivers_.size() == 1 ? 0 : of_change;
    if (one_stick && presets) {
        expect_within(output, 2, before, now, std::max(of_presets, of_input));
    }
}

void SlewingWorld::expect_within(std::size_t output, std::size_t channel, const Step& before,
                                 const Step& now, double us_per_second) {
    if (!before.frame.has(channel) || !now.frame.has(channel) || fault_) {
        return;
    }
    const double moved =
        now.frame.pulses()[channel].microseconds() - before.frame.pulses()[channel].microseconds();
    const double most = us_per_second * seconds(now.at - before.at) + kRoundedUs;
    if (std::abs(moved) > most) {
        fault_ = fmt::format(
            "output out{}, {:.3f} ms: channel {} moved by {:.3f} us within {:.3f} ms; {:.3f} us "
            "are allowed; changeovers {} to {}, failsafe {} to {}",
            output, 1e3 * seconds(now.at - Instant{}), channel + 1, moved,
            1e3 * seconds(now.at - before.at), most, before.changeovers, now.changeovers,
            before.failsafe, now.failsafe);
    }
}

}  // namespace tribus::test
