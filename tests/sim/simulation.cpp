#include "tests/sim/simulation.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "config/build.h"
#include "config/carry_over.h"
#include "config/load.h"
#include "config/mistakes.h"
#include "tests/support/heap_trap.h"
#include "transports/registry/registry.h"

namespace tribus::test {
namespace {

constexpr std::uint32_t kDigit = 1000;
constexpr std::size_t kMostFrames = 200'000;
constexpr std::size_t kMostSnapshots = 10'000;
constexpr Instant kDropped = kNever;

}  // namespace

Configuration configuration_of(const std::string& text) {
    auto configuration = load_configuration(text, "test.toml");
    if (!configuration) {
        for (const Mistake& mistake : configuration.error()) {
            ADD_FAILURE() << format_mistake(mistake);
        }
        std::abort();
    }
    return std::move(*configuration);
}

std::string main_job(const std::string& output_lines) {
    return R"([input.receiver]
protocol = "ibus"
device   = "/dev/ttyAMA2"

[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"
)" + output_lines +
           R"(

[pipeline.main]
from = "receiver"
to   = "servos"
)";
}

ChannelFrame numbered_frame(std::uint32_t number) {
    const std::uint32_t low = number % kDigit;
    const std::uint32_t high = number / kDigit % kDigit;
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    frame.set(0, Pulse::from_microseconds(1000 + low));
    frame.set(1, Pulse::from_microseconds(1000 + high));
    frame.set(2, Pulse::from_microseconds(1000 + (7 * low + 3 * high) % kDigit));
    for (std::size_t channel = 3; channel < 16; ++channel) {
        const auto place = static_cast<std::uint32_t>(channel);
        frame.set(channel, Pulse::from_microseconds(1000 + (low + 61 * place + high) % kDigit));
    }
    frame.set(16, number % 2 == 0 ? kSwitchOffPulse : kSwitchOnPulse);
    frame.set(17, number / 2 % 2 == 0 ? kSwitchOffPulse : kSwitchOnPulse);
    return frame;
}

std::optional<std::uint32_t> number_of(const ChannelFrame& frame) {
    std::array<std::int32_t, 3> digits{};
    for (std::size_t channel = 0; channel < digits.size(); ++channel) {
        digits[channel] = frame.channel_or(channel, Pulse{}).whole_microseconds() - 1000;
        if (digits[channel] < 0 || digits[channel] >= static_cast<std::int32_t>(kDigit)) {
            return std::nullopt;
        }
    }
    const std::int32_t check = (7 * digits[0] + 3 * digits[1]) % static_cast<std::int32_t>(kDigit);
    if (check != digits[2]) {
        return std::nullopt;
    }
    return static_cast<std::uint32_t>(digits[0]) + kDigit * static_cast<std::uint32_t>(digits[1]);
}

Simulation::Simulation(const Configuration& configuration, std::vector<Sender> senders,
                       std::uint64_t seed)
    : engine_(build_engine(configuration)) {
    for (const OutputConfig& output : configuration.outputs) {
        const bool can = output.port.link == LinkKind::can;
        const bool own_format = output.protocol->name == "can";
        readers_.push_back(can ? nullptr : output.protocol->make_decoder(output.settings));
        can_readers_.push_back(own_format ? output.protocol->make_can_decoder({}) : nullptr);
        written_.emplace_back().reserve(can && !own_format ? 0 : kMostFrames);
        written_to_can_.emplace_back().reserve(can ? kMostSnapshots : 0);
    }
    for (Sender& sender : senders) {
        const Protocol* protocol = find_protocol(sender.protocol);
        const bool can = protocol->link == LinkKind::can;
        SettingValues eighteen_channels;
        eighteen_channels.set("channels", std::int64_t{18});
        Wire& wire = wires_.emplace_back(
            Wire{.sender = sender,
                 .encoder = can ? nullptr : protocol->make_encoder(eighteen_channels),
                 .can_encoder = can ? protocol->make_can_encoder({}) : nullptr,
                 .can_witness = can ? protocol->make_can_decoder({}) : nullptr,
                 .line = protocol->line,
                 .faults = FaultInjector(sender.faults, ++seed),
                 .latest_number = sender.first_number});
        wire.arrivals.reserve(kMostFrames);
        plan(wire);
    }
    loop_.emplace(*engine_, *this, Instant{});
}

/// Nothing where the sender is silent.
std::optional<Simulation::NextFrame> Simulation::next_frame(Wire& wire, Instant at) {
    const auto spell = std::ranges::find_if(wire.sender.spells, [at](const Spell& candidate) {
        return candidate.from <= at && at < candidate.until;
    });
    if (spell == wire.sender.spells.end()) {
        wire.latest_number = wire.sender.first_number + wire.next_number;
        return NextFrame{numbered_frame(wire.latest_number)};
    }
    if (spell->kind == SpellKind::silence) {
        return std::nullopt;
    }
    NextFrame next{numbered_frame(wire.latest_number), spell->kind == SpellKind::garbage};
    next.frame.frame_lost = spell->kind == SpellKind::frame_lost;
    next.frame.failsafe = spell->kind == SpellKind::failsafe;
    return next;
}

/// Returns the time that it takes.
Duration Simulation::put_on_line(Wire& wire, const std::optional<NextFrame>& next) {
    std::array<std::uint8_t, kLongestSerialFrame> bytes{};
    const std::size_t length = next ? wire.encoder->encode(next->frame, bytes) : 0;
    if (next && next->garbage) {
        std::ranges::fill(bytes, std::uint8_t{0xA5});
    }
    wire.reception = Reception{};
    wire.faults.apply(std::span(bytes).first(length), wire.reception);
    wire.dropped = wire.faults.drop_frame() || length == 0;
    return wire.line.bytes_time(length);
}

Duration Simulation::put_on_bus(Wire& wire, const std::optional<NextFrame>& next, Instant at) {
    constexpr Duration kFrameTime = std::chrono::microseconds(250);
    std::array<CanFrame, kMostSnapshotFrames> parts{};
    std::size_t count = 0;
    if (next) {
        ChannelFrame frame = next->frame;
        frame.received = at;
        count = wire.can_encoder->encode(frame, at, parts);
    }
    wire.can_count = 0;
    for (CanFrame& part : std::span(parts).first(count)) {
        if (next->garbage) {
            std::ranges::fill(part.data, std::uint8_t{0xA5});
        }
        if (!wire.faults.drop_frame()) {
            wire.can_frames[wire.can_count++] = part;
        }
    }
    return kFrameTime * count;
}

/// Prepares the next frame on the wire. A late one does not overtake, nor does it start before the
/// one ahead has ended.
void Simulation::plan(Wire& wire) {
    const Instant at = wire.sender.first + wire.next_number * wire.sender.period;
    if (at >= wire.sender.last) {
        wire.next_arrival = kNever;
        return;
    }
    const auto next = next_frame(wire, at);
    const Duration wire_time =
        wire.can_encoder ? put_on_bus(wire, next, at) : put_on_line(wire, next);
    wire.next_arrival = std::max(at + wire.faults.next_delay(), wire.latest_arrival) + wire_time;
}

void Simulation::witness(Wire& wire, const CanFrame& frame) {
    const auto snapshot = wire.can_witness->next(frame, wire.next_arrival);
    const auto number = snapshot ? number_of(*snapshot) : std::nullopt;
    const std::size_t place = number.value_or(0) - wire.sender.first_number;
    if (number && place < wire.arrivals.size() && wire.arrivals[place] == kDropped) {
        wire.arrivals[place] = wire.next_arrival;
    }
}

void Simulation::deliver(Wire& wire) {
    if (wire.can_encoder) {
        wire.arrivals.push_back(kDropped);
        for (const CanFrame& frame : std::span(wire.can_frames).first(wire.can_count)) {
            witness(wire, frame);
            loop_->receive(wire.sender.input, frame, wire.next_arrival);
        }
        return;
    }
    if (!wire.dropped) {
        loop_->receive(wire.sender.input, wire.reception.view(), wire.reception.damaged,
                       wire.next_arrival);
    }
    wire.arrivals.push_back(wire.dropped ? kDropped : wire.next_arrival);
}

Simulation::Wire* Simulation::next_wire() {
    const auto next = std::min_element(
        wires_.begin(), wires_.end(),
        [](const Wire& a, const Wire& b) { return a.next_arrival < b.next_arrival; });
    return next == wires_.end() ? nullptr : &*next;
}

void Simulation::run_until(Instant until) {
    HeapTrap trap;
    for (Wire* wire = next_wire(); wire != nullptr && wire->next_arrival < until;
         wire = next_wire()) {
        deliver(*wire);
        wire->latest_arrival = wire->next_arrival;
        ++wire->next_number;
        plan(*wire);
    }
    loop_->run_until(until);
    allocations_ += trap.allocations();
}

void Simulation::reload(const Configuration& unchanged, Instant at) {
    run_until(at);
    std::unique_ptr<Engine> next = build_engine(unchanged);
    const CarryOver plan = plan_carry_over(unchanged, unchanged);
    {
        const HeapTrap trap;
        next->start(at);
        next->continue_from(*engine_, plan.engine, at);
        allocations_ += trap.allocations();
    }
    std::swap(engine_, next);
    loop_->go_on_with(*engine_, nullptr, at);
}

void Simulation::receive(std::size_t input, const CanFrame& frame, Instant at) {
    HeapTrap trap;
    loop_->receive(input, frame, at);
    allocations_ += trap.allocations();
}

std::optional<Instant> Simulation::arrived_at(std::size_t sender, std::uint32_t number) const {
    const std::vector<Instant>& arrivals = wires_[sender].arrivals;
    if (number >= arrivals.size() || arrivals[number] == kDropped) {
        return std::nullopt;
    }
    return arrivals[number];
}

/// A frame that a reader of the output finds in what it sent.
std::optional<ChannelFrame> Simulation::heard(std::size_t output, Instant at,
                                              const Transmission& sent) {
    if (!sent.can_frames.empty()) {
        std::optional<ChannelFrame> snapshot;
        for (const CanFrame& part : sent.can_frames) {
            snapshot = can_readers_[output] ? can_readers_[output]->next(part, at) : std::nullopt;
        }
        return snapshot;
    }
    std::span<const std::uint8_t> rest = sent.bytes;
    std::optional<DecodedFrame> found = DecodedFrame{};
    if (!readers_[output]->next(rest, at, *found)) {
        found = readers_[output]->finish();
    }
    if (!found || !rest.empty()) {
        ADD_FAILURE() << "an output wrote something that is not exactly one frame";
        return std::nullopt;
    }
    return found->channels;
}

void Simulation::wrote(std::size_t output, Instant at, const Transmission& sent) {
    if (!sent.can_frames.empty()) {
        WrittenToCan& snapshot = written_to_can_[output].emplace_back();
        snapshot.at = at;
        snapshot.count = sent.can_frames.size();
        std::ranges::copy(sent.can_frames, snapshot.frames.begin());
    }
    if (const auto frame = heard(output, at, sent)) {
        written_[output].push_back({at, *frame, number_of(*frame)});
    }
}

Seeds seeds_or(std::uint64_t usual) {
    const char* text = std::getenv("TRIBUS_SEED");
    if (text == nullptr) {
        return {.first = 1, .last = usual};
    }
    char* end = nullptr;
    const std::uint64_t first = std::strtoull(text, &end, 10);
    return {.first = first, .last = *end == '-' ? std::strtoull(end + 1, nullptr, 10) : first};
}

std::string replay_command(std::uint64_t seed) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    return "replay: TRIBUS_SEED=" + std::to_string(seed) +
           " build/tests/sim_tests --gtest_filter=" + test->test_suite_name() + "." + test->name();
}

}  // namespace tribus::test
