#include "tests/sim/simulation.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdlib>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/language/mistakes.h"
#include "config/load.h"
#include "tests/sim/ibus_frames.h"
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
device   = "/dev/ttyAMA5"

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
        const bool can = output.port.medium->shape == WireShape::can_frames;
        const bool own_format = output.protocol->name == "can";
        readers_.push_back(can ? nullptr : make_byte_decoder(*output.protocol, output.settings));
        can_readers_.push_back(own_format ? make_can_decoder(*output.protocol, {}) : nullptr);
        written_.emplace_back().reserve(can && !own_format ? 0 : kMostFrames);
        written_to_can_.emplace_back().reserve(can ? kMostSnapshots : 0);
    }
    for (Sender& sender : senders) {
        const Protocol* protocol = find_protocol(sender.protocol);
        const bool can = protocol->shape == WireShape::can_frames;
        SettingValues eighteen_channels;
        eighteen_channels.set("channels", std::int64_t{18});
        Wire& wire = wires_.emplace_back(Wire{
            .sender = sender,
            .encoder =
                FrameEncoder(protocol->make_encoder(can ? SettingValues{} : eighteen_channels)),
            .can_witness = can ? make_can_decoder(*protocol, {}) : nullptr,
            .line = protocol->line,
            .faults = FaultInjector(sender.faults, ++seed),
            .latest_number = sender.first_number});
        wire.arrivals.reserve(kMostFrames);
        wire.whole_arrivals.assign(kMostFrames, kDropped);
        plan(wire);
    }
    loop_.emplace(*engine_, *this, Instant{});
}

/// Returns the next frame, or nothing while the sender is silent.
std::optional<Simulation::NextFrame> Simulation::next_frame(Wire& wire, Instant at) {
    const auto spell = std::ranges::find_if(wire.sender.spells, [at](const Spell& candidate) {
        return candidate.from <= at && at < candidate.until;
    });
    const auto fresh = [&] {
        wire.latest_number = wire.sender.first_number + wire.next_number;
        return numbered_frame(wire.latest_number);
    };
    if (spell == wire.sender.spells.end()) {
        return NextFrame{fresh()};
    }
    switch (spell->kind) {
        case SpellKind::silence:
            return std::nullopt;
        case SpellKind::unplugged:
            return NextFrame{fresh(), spell->kind};
        case SpellKind::fewer_channels: {
            if (wire.sender.protocol == "sbus") {
                return std::nullopt;
            }
            NextFrame next{fresh(), spell->kind};
            for (std::size_t channel = spell->channels; channel < kChannelCount; ++channel) {
                next.frame.remove(channel);
            }
            return next;
        }
        default:
            break;
    }
    NextFrame next{numbered_frame(wire.latest_number), spell->kind};
    next.frame.frame_lost = spell->kind == SpellKind::frame_lost;
    next.frame.failsafe = spell->kind == SpellKind::failsafe;
    return next;
}

/// Puts a frame on the line. Returns the time that it takes.
Duration Simulation::put_on_line(Wire& wire, const std::optional<NextFrame>& next, Instant at) {
    std::array<std::uint8_t, kLongestSerialFrame> bytes{};
    std::size_t length = 0;
    if (next) {
        const auto encoded = wire.encoder.encode(next->frame, at).bytes();
        std::ranges::copy(encoded, bytes.begin());
        length = encoded.size();
    }
    const Duration wire_time = wire.line.bytes_time(length);
    if (next && next->spell == SpellKind::garbage) {
        std::ranges::fill(bytes, std::uint8_t{0xA5});
    }
    if (next && next->spell == SpellKind::fewer_channels) {
        length = shorten_ibus(bytes, next->frame);
    }
    const std::size_t torn_at = length == 0 ? 0 : 1 + wire.latest_number % (length - 1);
    const bool unplugged = next && next->spell == SpellKind::unplugged;
    std::size_t begin = 0;
    if (unplugged) {
        wire.pulled = !wire.unplugged;
        length = wire.unplugged ? 0 : torn_at;
    } else if (wire.unplugged && length > 0) {
        begin = torn_at;
    }
    wire.unplugged = unplugged || (wire.unplugged && length == 0);
    wire.reception = Reception{};
    const auto sent = std::span(bytes).first(length).subspan(begin);
    if (at < wire.sender.faults_end) {
        wire.faults.apply(sent, wire.reception);
        wire.dropped = wire.faults.drop_frame() || length == 0;
    } else {
        FaultInjector({}, 0).apply(sent, wire.reception);
        wire.dropped = length == 0;
    }
    wire.hurt = wire.reception.damaged.any() || !std::ranges::equal(wire.reception.view(), sent);
    // No reader can tell such a frame from a good one. The line loses it instead.
    wire.dropped = wire.dropped || (wire.hurt && wire.sender.protocol == "ibus" &&
                                    damage_is_hidden(wire.reception.view(), sent));
    return wire_time;
}

Duration Simulation::put_on_bus(Wire& wire, const std::optional<NextFrame>& next, Instant at) {
    constexpr Duration kFrameTime = std::chrono::microseconds(250);
    std::array<CanFrame, kMostSnapshotFrames> parts{};
    std::size_t count = 0;
    if (next) {
        ChannelFrame frame = next->frame;
        frame.received = at;
        const auto encoded = wire.encoder.encode(frame, at).can_frames();
        std::ranges::copy(encoded, parts.begin());
        count = encoded.size();
    }
    const bool unplugged = next && next->spell == SpellKind::unplugged;
    if (unplugged) {
        wire.pulled = !wire.unplugged;
        count = wire.unplugged ? 0 : 1 + wire.latest_number % count;
    }
    wire.unplugged = unplugged;
    wire.can_count = 0;
    for (CanFrame& part : std::span(parts).first(count)) {
        if (next->spell == SpellKind::garbage) {
            std::ranges::fill(part.data, std::uint8_t{0xA5});
        }
        if (at >= wire.sender.faults_end || !wire.faults.drop_frame()) {
            wire.can_frames[wire.can_count++] = part;
        }
    }
    return kFrameTime * count;
}

/// Prepares the next frame on the wire. It neither overtakes the one before nor starts before that
/// one has ended, even if that is late.
void Simulation::plan(Wire& wire) {
    const Instant at = wire.sender.first + wire.next_number * wire.sender.period;
    if (at >= wire.sender.last) {
        wire.next_arrival = kNever;
        return;
    }
    const auto next = next_frame(wire, at);
    const Duration wire_time =
        wire.can_witness ? put_on_bus(wire, next, at) : put_on_line(wire, next, at);
    wire.frame_begins = std::max(at + wire.faults.next_delay(), wire.latest_arrival);
    wire.frame_ends = wire.frame_begins + wire_time;
    wire.handed_over = 0;
    plan_piece(wire);
}

/// Returns how many bytes the port delivers next.
std::size_t Simulation::next_piece(const Wire& wire) {
    constexpr std::size_t kLump = 8;
    const std::size_t left = wire.reception.count - wire.handed_over;
    switch (wire.sender.delivery) {
        case Delivery::frames:
            break;
        case Delivery::bytes:
            return std::min<std::size_t>(left, 1);
        case Delivery::lumps:
            return std::min(left, kLump);
    }
    return left;
}

void Simulation::plan_piece(Wire& wire) {
    const bool whole = wire.can_witness || wire.dropped || wire.sender.delivery == Delivery::frames;
    const Instant now = wire.latest_arrival;
    wire.next_arrival =
        whole ? wire.frame_ends
              : wire.frame_begins + wire.line.bytes_time(wire.handed_over + next_piece(wire));
    wire.next_arrival = std::max(wire.next_arrival, now);
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
    if (wire.can_witness) {
        deliver_frames(wire);
    } else if (!wire.dropped) {
        deliver_piece(wire);
        if (wire.handed_over < wire.reception.count) {
            wire.latest_arrival = wire.next_arrival;
            plan_piece(wire);
            return;
        }
    }
    if (!wire.can_witness) {
        const bool came = !wire.dropped && !discards(wire);
        wire.arrivals.push_back(came ? wire.next_arrival : kDropped);
        Instant& whole = wire.whole_arrivals[wire.latest_number - wire.sender.first_number];
        if (came && !wire.hurt && whole == kDropped) {
            whole = wire.next_arrival;
        }
    }
    if (std::exchange(wire.pulled, false)) {
        lose_device(wire);
    }
    wire.latest_arrival = std::max(wire.next_arrival, wire.frame_ends);
    ++wire.next_number;
    plan(wire);
}

void Simulation::deliver_frames(Wire& wire) {
    wire.arrivals.push_back(kDropped);
    for (const CanFrame& frame : std::span(wire.can_frames).first(wire.can_count)) {
        witness(wire, frame);
        if (away_since_) {
            // The frame keeps its time of arrival, as the kernel stamps it.
            engine_->receive(wire.sender.input, frame, wire.next_arrival);
        } else {
            loop_->receive(input_station(wire.sender.input), frame, wire.next_arrival);
        }
    }
}

void Simulation::deliver_piece(Wire& wire) {
    const std::size_t begin = wire.handed_over;
    const std::size_t count = next_piece(wire);
    const std::size_t input = wire.sender.input;
    const std::bitset<kBytesPerRead> damaged = wire.reception.damaged >> begin;
    const auto bytes = wire.reception.view().subspan(begin, count);
    if (!away_since_) {
        loop_->receive(input_station(input), bytes, damaged, wire.next_arrival);
    } else if (discards(wire)) {
        engine_->bytes_discarded(input);
    } else {
        engine_->receive(input, bytes, damaged, *away_since_);
    }
    wire.handed_over += count;
}

/// Returns whether bytes that waited longer than the timeout are thrown away.
bool Simulation::discards(const Wire& wire) const {
    return away_since_ && away_for_ >= engine_->inputs()[wire.sender.input].link().timeout();
}

void Simulation::lose_device(Wire& wire) {
    if (away_since_) {
        engine_->device_lost(wire.sender.input);
    } else {
        loop_->device_lost(input_station(wire.sender.input), wire.next_arrival);
    }
}

Simulation::Wire* Simulation::next_wire() {
    const auto next = std::min_element(
        wires_.begin(), wires_.end(),
        [](const Wire& a, const Wire& b) { return a.next_arrival < b.next_arrival; });
    return next == wires_.end() ? nullptr : &*next;
}

void Simulation::deliver_until(Instant until) {
    for (Wire* wire = next_wire(); wire != nullptr && wire->next_arrival < until;
         wire = next_wire()) {
        deliver(*wire);
    }
}

void Simulation::run_until(Instant until) {
    HeapTrap trap;
    deliver_until(until);
    loop_->run_until(until);
    allocations_ += trap.allocations();
}

void Simulation::stall(Instant since, Instant until) {
    run_until(since);
    absences_.push_back({since, until});
    HeapTrap trap;
    away_since_ = since;
    away_for_ = until - since;
    deliver_until(until);
    away_since_.reset();
    loop_->come_back(since, until);
    allocations_ += trap.allocations();
}

bool Simulation::stalled_between(Instant from, Instant until) const {
    return std::ranges::any_of(absences_, [&](const Absence& absence) {
        return absence.since < until && from < absence.until;
    });
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
    loop_->receive(input_station(input), frame, at);
    allocations_ += trap.allocations();
}

std::optional<Instant> Simulation::arrived_at(std::size_t sender, std::uint32_t number) const {
    const std::vector<Instant>& arrivals = wires_[sender].arrivals;
    const Instant at = number < arrivals.size() ? arrivals[number] : kDropped;
    return at == kDropped ? std::nullopt : std::optional(at);
}

std::optional<Instant> Simulation::arrived_whole_at(std::size_t sender,
                                                    std::uint32_t number) const {
    const std::vector<Instant>& arrivals = wires_[sender].whole_arrivals;
    const Instant at = number < arrivals.size() ? arrivals[number] : kDropped;
    return at == kDropped ? std::nullopt : std::optional(at);
}

/// Returns the frame that a reader of the output finds in these bytes.
std::optional<ChannelFrame> Simulation::heard(std::size_t output, Instant at,
                                              const Transmission& sent) {
    if (!sent.can_frames().empty()) {
        std::optional<ChannelFrame> snapshot;
        for (const CanFrame& part : sent.can_frames()) {
            snapshot = can_readers_[output] ? can_readers_[output]->next(part, at) : std::nullopt;
        }
        return snapshot;
    }
    std::span<const std::uint8_t> rest = sent.bytes();
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

void Simulation::wrote(Station station, Instant at, const Transmission& sent) {
    if (station.kind != StationKind::output) {
        return;
    }
    const std::size_t output = station.index;
    if (!sent.can_frames().empty()) {
        WrittenToCan& snapshot = written_to_can_[output].emplace_back();
        snapshot.at = at;
        snapshot.count = sent.can_frames().size();
        std::ranges::copy(sent.can_frames(), snapshot.frames.begin());
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
