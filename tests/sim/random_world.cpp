#include "tests/sim/random_world.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

/// Troubles end here. The time after that shows that everything recovers.
constexpr Instant kTroublesEnd = Instant(20s);
/// Distance between the first frame numbers of two senders, so that no number occurs twice.
constexpr std::uint32_t kNumbersApart = 200'000;

/// SBUS has no checksum: of 200 frames that lost bytes, got extra bytes or were cut, up to 5 may be
/// taken for good frames (the best of other readers take 3 to 174).
std::size_t most_invented_by(const Sender& sender) {
    constexpr double kFrameBytes = 25;
    constexpr double kWrongOfHit = 5.0 / 200;
    const auto frames = static_cast<double>((sender.last - sender.first) / sender.period);
    const double hit =
        kFrameBytes * (sender.faults.lose_byte + sender.faults.add_byte) + sender.faults.cut_frame;
    return static_cast<std::size_t>(frames * hit * kWrongOfHit);
}

/// Presets of channels 4 to 6, which no map rule changes. The presets of other channels can be
/// equal to a reader's guess.
constexpr std::array kPresetMicroseconds{1104, 1112, 1120};
constexpr std::size_t kFirstPreset = 3;

int microseconds(const ChannelFrame& frame, std::size_t channel) {
    return frame.channel_or(channel, Pulse{}).whole_microseconds();
}

bool is_preset(const ChannelFrame& frame) {
    bool preset = microseconds(frame, 0) == 1500 && microseconds(frame, 2) == 988;
    for (std::size_t i = 0; i < kPresetMicroseconds.size(); ++i) {
        preset = preset && microseconds(frame, kFirstPreset + i) == kPresetMicroseconds[i];
    }
    return preset;
}

std::string told(std::size_t output, const Written& written, std::string_view what) {
    return fmt::format(
        "output out{}, {:.3f} ms: {}", output,
        std::chrono::duration<double, std::milli>(written.at.time_since_epoch()).count(), what);
}

using Verdict = std::optional<std::string>;

/// Reports an output that repeats old values. Every sender changes its values with each frame, so
/// values that stay the same are old.
Verdict repeats_old_values(std::size_t output, const RandomWorld& world,
                           const Simulation& simulation) {
    const std::vector<Written>& written = simulation.written(output);
    const Duration longest = world.longest_unmarked(output);
    Instant since = written.front().at;
    for (std::size_t i = 1; i < written.size(); ++i) {
        const ChannelFrame& frame = written[i].frame;
        since = frame.same_content(written[i - 1].frame) ? since : written[i].at;
        // The first step of a slew into the presets does not move yet, and a stall may delay it.
        const bool late_step =
            world.blends() &&
            simulation.stalled_between(written[i].at - world.period(output), written[i].at);
        if (frame.good() && !is_preset(frame) && !late_step && written[i].at - since > longest) {
            return told(output, written[i], "the same values for too long, as good");
        }
    }
    return std::nullopt;
}

/// Returns whether channels 4 to 6 are those of the numbered frame, or presets where that frame
/// lacks them. A format that can mark a channel as absent does so.
bool says_what_was_sent(const Written& written) {
    const ChannelFrame sent = numbered_frame(*written.number);
    for (std::size_t i = 0; i < kPresetMicroseconds.size(); ++i) {
        const std::size_t channel = kFirstPreset + i;
        const int said = microseconds(written.frame, channel);
        if (written.frame.has(channel) && said != microseconds(sent, channel) &&
            said != kPresetMicroseconds[i]) {
            return false;
        }
    }
    return true;
}

/// Reports a good frame with values that no sender sent, or sent too long ago. A loss begins with
/// the first frame that is missing or unchanged, one interval after the last fresh one.
Verdict writes_what_nobody_says(std::size_t output, const RandomWorld& world,
                                const Simulation& simulation) {
    const Duration longest = world.longest_unmarked(output) + world.longest_interval();
    std::size_t invented = 0;
    ChannelFrame latest;
    for (const Written& written : simulation.written(output)) {
        // A frame that is repeated while it is held counts once.
        const bool another = !written.frame.same_content(std::exchange(latest, written.frame));
        if (!written.frame.good() || is_preset(written.frame)) {
            continue;
        }
        const std::size_t sender = written.number.value_or(~0U) / kNumbersApart;
        if (sender >= world.senders().size() || !says_what_was_sent(written)) {
            invented += another ? 1 : 0;
            if (invented > world.most_invented()) {
                return told(output, written, "values that nobody sent, as good");
            }
            continue;
        }
        // Extra bytes push the last bytes of a frame past the point where its reader is done.
        constexpr Duration kAddedBytes = 1200us;
        const auto arrived = simulation.arrived_at(sender, *written.number % kNumbersApart);
        // A damaged copy of the frame may have been read, or not.
        const auto whole = simulation.arrived_whole_at(sender, *written.number % kNumbersApart);
        const Instant read_at =
            std::max(arrived.value_or(Instant{}), std::min(whole.value_or(Instant{}), written.at));
        if (arrived && (*arrived > written.at + kAddedBytes || written.at - read_at > longest)) {
            return told(output, written,
                        fmt::format("values that in{} said {} us ago, as good", sender,
                                    (written.at - *arrived) / 1us));
        }
    }
    return std::nullopt;
}

/// Reports two frames that are too close, three of them within a period, or a missing frame of an
/// output that is not silent. A locked grid steps in whole input intervals and adapts to a sender
/// whose clock is fast by one percent. A repeat waits for one tick of the kernel.
Verdict loses_its_period(std::size_t output, const RandomWorld& world,
                         const Simulation& simulation) {
    const std::vector<Written>& written = simulation.written(output);
    const Duration period = world.period(output);
    const Duration interval = world.longest_interval();
    const bool locked = world.locked(output);
    const Duration least = world.least_spacing(output);
    const Duration least_of_two = std::max(2 * least, locked ? Duration::zero() : period);
    const Duration most = 2 * (locked ? period + std::min(interval, 2 * period) : period) + 4500us;
    for (std::size_t i = 1; i < written.size(); ++i) {
        const Duration gap = written[i].at - written[i - 1].at;
        // A grid turn that is late does not move the next one. After a stall the lock starts
        // anew.
        if (simulation.stalled_between(written[i - 1].at - 2 * period, written[i].at)) {
            continue;
        }
        const Duration of_two = i > 1 ? written[i].at - written[i - 2].at : least_of_two;
        if (gap < least || of_two < least_of_two || (gap > most && !world.falls_silent(output))) {
            return told(output, written[i],
                        fmt::format("{} us behind the frame before", gap / 1us));
        }
    }
    return std::nullopt;
}

}  // namespace

RandomWorld::RandomWorld(std::uint64_t seed, WorldKind kind) : random_(seed), kind_(kind) {
    inputs_ = one_to(4);
    for (std::size_t i = 0; i < inputs_; ++i) {
        add_input(i);
    }
    outputs_ = one_to(3);
    for (std::size_t i = 0; i < outputs_; ++i) {
        add_output(i);
    }
    add_pipeline();
}

Duration RandomWorld::longest_unmarked(std::size_t output) const {
    const Duration longest =
        longest_unnoticed_ + (marks_[output] ? 0ms : hold_) + 2 * periods_[output];
    // One frame with wrong flags among those marked failsafe starts all these timers again.
    return most_invented_ > 0 ? 2 * longest : longest;
}

Duration RandomWorld::between(Duration low, Duration high) {
    return low + std::chrono::milliseconds(below(static_cast<std::size_t>((high - low) / 1ms)));
}

void RandomWorld::duration(std::string_view key, Duration value) {
    line(fmt::format("{} = \"{}ms\"", key, value / 1ms));
}

/// Adds a port and returns its protocol. Each CAN port has its own bus, because all use the same
/// ids.
std::string RandomWorld::add_port(std::string_view end, std::size_t index, unsigned sbus_percent) {
    const bool can = kind_ == WorldKind::with_can && chance(50);
    const std::string protocol = can ? "can" : chance(sbus_percent) ? "sbus" : "ibus";
    line(fmt::format("[{}put.{}{}]\nprotocol = \"{}\"\n{} = \"{}{}{}\"", end, end, index, protocol,
                     can ? "interface" : "device", can ? "" : "/dev/", end, index));
    return protocol;
}

void RandomWorld::add_input(std::size_t index) {
    const std::string protocol = add_port("in", index, 50);
    const bool watches_for_frozen = chance(50);
    longest_unnoticed_ =
        std::max(longest_unnoticed_, add_detectors(protocol != "ibus", watches_for_frozen));
    add_sender(index, protocol, watches_for_frozen);
}

/// Adds detectors to an input. Returns how long a loss may go unnoticed with them.
Duration RandomWorld::add_detectors(bool has_flags, bool watches_for_frozen) {
    const Duration timeout = between(150ms, 400ms);
    duration("timeout", timeout);
    Duration unnoticed = timeout;
    if (has_flags && chance(40)) {
        const Duration run = between(50ms, 900ms);
        duration("frame_lost_run", run);
        unnoticed = std::max(unnoticed, run);
    }
    if (has_flags && chance(30)) {
        line(fmt::format("frame_lost_ratio = {}", chance(50) ? "1.0" : "0.5"));
    }
    if (watches_for_frozen) {
        const Duration frozen = between(300ms, 900ms);
        duration("frozen", frozen);
        unnoticed = std::max(unnoticed, frozen);
    }
    return unnoticed;
}

void RandomWorld::add_sender(std::size_t index, const std::string& protocol, bool may_freeze) {
    constexpr std::array kPeriods{Duration(4ms), Duration(7ms), Duration(7700us), Duration(9ms),
                                  Duration(14ms)};
    Sender sender{.input = index,
                  .protocol = protocol,
                  .period = kPeriods[below(kPeriods.size())],
                  .first = Instant(between(0ms, 3s)),
                  .last = kEnd,
                  .faults_end = kTroublesEnd,
                  .first_number = static_cast<std::uint32_t>(kNumbersApart * index)};
    // A snapshot on CAN needs all five of its frames, so fewer may be lost.
    sender.faults.drop_frame = !chance(30) ? 0 : protocol == "can" ? 0.05 : 0.2;
    sender.faults.lose_byte = chance(30) ? 0.005 : 0;
    sender.faults.add_byte = chance(20) ? 0.003 : 0;
    sender.faults.cut_frame = chance(20) ? 0.05 : 0;
    sender.faults.most_in_a_row = static_cast<unsigned>(one_to(3));
    sender.delivery = static_cast<Delivery>(below(3));
    // A wrong frame among frozen ones looks like a change, so freezing cannot be detected.
    const bool wrong_frames = protocol == "sbus" && most_invented_by(sender) > 0;
    for (Instant at = Instant(between(1s, 6s)); at < kTroublesEnd - 4s;) {
        const auto kind = static_cast<SpellKind>(below(7));
        // Without a flag and without `frozen` this cannot be told from a pilot who holds still.
        const bool invisible =
            kind == SpellKind::frozen ||
            (protocol == "ibus" && (kind == SpellKind::frame_lost || kind == SpellKind::failsafe));
        const Instant until = at + between(20ms, 4s);
        sender.spells.push_back(
            {at, until, invisible && (!may_freeze || wrong_frames) ? SpellKind::silence : kind,
             3 + below(4)});
        at = until + between(10ms, 3s);
    }
    longest_interval_ = std::max(longest_interval_, sender.period);
    if (protocol == "sbus") {
        most_invented_ += most_invented_by(sender);
    }
    senders_.push_back(sender);
}

void RandomWorld::add_output(std::size_t index) {
    const std::string protocol = add_port("out", index, 60);
    const Duration period = protocol == "sbus" ? between(7ms, 20ms) : between(5ms, 20ms);
    if (protocol == "ibus") {
        line("channels = 18");
    }
    duration("period", period);
    bool locked = false;
    const bool follows = !chance(50);
    if (!follows) {
        line("schedule = \"grid\"");
        locked = chance(50);
        line(locked ? "phase = \"locked\"" : "phase = \"free\"");
    }
    marks_.push_back(protocol != "ibus");
    if (!marks_.back()) {
        // `hold` may be long, and nothing marks it there.
        line("force = true");
    }
    periods_.push_back(period);
    const Duration by_readers = protocol == "sbus" ? 6ms : protocol == "ibus" ? 4ms : 2ms;
    least_spacings_.push_back(follows  ? std::min(by_readers, period)
                              : locked ? period - period / 100
                                       : period);
    locked_.push_back(locked);
}

void RandomWorld::add_pipeline() {
    std::string from;
    std::string to;
    for (std::size_t i = 0; i < inputs_; ++i) {
        from += fmt::format("{}\"in{}\"", i == 0 ? "" : ", ", i);
    }
    for (std::size_t i = 0; i < outputs_; ++i) {
        to += fmt::format("{}\"out{}\"", i == 0 ? "" : ", ", i);
    }
    constexpr std::array kModes{"priority", "sticky", "freshest", "median"};
    const std::string mode = kModes[below(inputs_ > 2 ? 4 : 3)];
    blends_ = mode == "median";
    line(fmt::format("[pipeline.main]\nfrom = [{}]\nto = [{}]\nmode = \"{}\"", from, to, mode));
    if (inputs_ > 1 && mode != "freshest" && chance(30)) {
        line("changeover = \"4000us/s\"");
        blends_ = true;
    }
    if (inputs_ > 1 && chance(20)) {
        line(fmt::format("handover = {{ input = \"in0\", channel = {} }}", one_to(16)));
    }
    add_failsafe();
    add_channels();
}

void RandomWorld::add_failsafe() {
    line("[pipeline.main.failsafe]");
    hold_ = between(0ms, 900ms);
    duration("hold", hold_);
    duration("recover", between(0ms, 900ms));
    duration("power_on", between(0ms, 900ms));
    line(fmt::format("preset = {{ 3 = 988, 4 = {}, 5 = {}, 6 = {}, other = 1500 }}",
                     kPresetMicroseconds[0], kPresetMicroseconds[1], kPresetMicroseconds[2]));
    if (chance(30)) {
        line("slew = \"3000us/s\"");
        blends_ = true;
    }
    if (chance(30)) {
        line("release_when = { channel = 3, below = 1200 }");
    }
    for (std::size_t i = 0; i < outputs_; ++i) {
        const std::string_view action = marks_[i]
                                            ? std::array{"preset", "hold", "silence"}[below(3)]
                                            : std::array{"preset", "silence"}[below(2)];
        falls_silent_.push_back(action == "silence");
        line(fmt::format("[pipeline.main.failsafe.output.out{}]\naction = \"{}\"", i, action));
    }
}

/// Adds map rules for channels that carry neither the frame number nor a checked preset.
void RandomWorld::add_channels() {
    constexpr std::array kRules{"{ from = 4, reverse = true }", "{ from = 7, expo = 0.4 }",
                                "{ from = 9, trim = 25 }", "{ fixed = 1200 }", "14"};
    if (!chance(50)) {
        return;
    }
    line("[pipeline.main.channels]");
    for (std::size_t channel = 7; channel <= 16; ++channel) {
        if (chance(40)) {
            line(fmt::format("{} = {}", channel, kRules[below(kRules.size())]));
        }
    }
}

std::optional<std::string> broken_promise(const RandomWorld& world, const Simulation& simulation) {
    if (simulation.allocations() > 0) {
        return fmt::format("the engine allocated {} times", simulation.allocations());
    }
    const auto outputs = simulation.engine().outputs();
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const std::vector<Written>& written = simulation.written(i);
        if (written.empty()) {
            return fmt::format("output out{}: wrote nothing", i);
        }
        if (auto broken = repeats_old_values(i, world, simulation)) {
            return broken;
        }
        if (!world.blends()) {
            if (auto broken = writes_what_nobody_says(i, world, simulation)) {
                return broken;
            }
        }
        if (auto broken = loses_its_period(i, world, simulation)) {
            return broken;
        }
        // The median of several throttles may never come down.
        const bool may_wait = world.blends() && outputs[i].state(RandomWorld::kEnd).awaits_release;
        if (outputs[i].stage() != OutputStage::control && !may_wait) {
            return fmt::format("output out{}: not in control again after the troubles", i);
        }
    }
    return std::nullopt;
}

}  // namespace tribus::test
