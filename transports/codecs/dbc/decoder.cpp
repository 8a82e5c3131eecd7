#include "transports/codecs/dbc/dbc.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "transports/codecs/dbc/channel.h"
#include "transports/codecs/dbc/checksum.h"

namespace tribus {
namespace {

/// Two lost frames in a row still count as an advance (docs/protocols/can.md, "Native format").
constexpr std::uint64_t kMostCounterStep = 3;
/// Cycles that a part that is not awaited may miss.
constexpr int kMostMissedCycles = 3;
/// Limit for such a part without a cycle time: as long as drive units wait for commands
/// (docs/protocols/can.md, "Drive units and robots").
constexpr Duration kGuardWithoutCycle = std::chrono::milliseconds(500);
/// After this pause a counter may have repeated, and the next frames may come from a sender's queue
/// that waited for the bus (docs/protocols/can.md, "SocketCAN: transmit queue").
constexpr Duration kSilence = std::chrono::milliseconds(250);
/// Longer than the period of any J1939 message with channels.
constexpr Duration kSenderMemory = std::chrono::seconds(1);
constexpr std::uint32_t kSourceAddress = 0xFF;

/// A step back by one must not count as an advance, because two alternating senders would cause it.
std::uint64_t most_step(std::uint64_t values) {
    return std::clamp<std::uint64_t>((values - 1) / 2, 1, kMostCounterStep);
}

/// Whether a message is so much slower than the fastest that it is not awaited.
bool slow(Duration cycle, Duration quickest) {
    return cycle * 2 > quickest * 3;
}

}  // namespace

DbcDecoder::DbcDecoder(DbcMap map)
    : map_(std::move(map)), messages_(map_.messages.size()), parts_(map_.parts.size()) {
    std::ranges::transform(map_.messages, std::back_inserter(wanted_), &DbcMappedMessage::id);
    watch_counters();
    watch_senders();
    describe_parts();
}

void DbcDecoder::watch_counters() {
    for (std::size_t i = 0; i < messages_.size(); ++i) {
        const DbcMappedMessage& mapped = map_.messages[i];
        if (mapped.counter) {
            const std::uint64_t values = mapped.counter->most + 1;
            const Duration cycle = mapped.cycle.value_or(Duration::zero());
            messages_[i].watch.emplace(
                CounterWatch::Limits{.values = values,
                                     .most_step = most_step(values),
                                     .silence = std::max(kSilence, cycle * kMostMissedCycles)});
        }
    }
}

void DbcDecoder::watch_senders() {
    for (MessageState& message : messages_) {
        if (!message.watch) {
            message.senders.emplace();
        }
    }
    for (const DbcPart& part : map_.parts) {
        if (!part.selectors.empty()) {
            // Pages may come in any order.
            messages_[part.message].senders.reset();
        }
    }
}

bool DbcDecoder::two_senders() const {
    return std::ranges::any_of(messages_, [](const MessageState& message) {
        return message.senders && message.senders->two_senders();
    });
}

void DbcDecoder::describe_parts() {
    const auto quickest = map_.shortest_cycle();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        const DbcPart& part = map_.parts[i];
        const auto cycle = map_.messages[part.message].cycle;
        parts_[i].awaited =
            !part.channels.empty() && !(cycle && quickest && slow(*cycle, *quickest));
        parts_[i].may_be_absent = part.flags.empty() && part.fixed.empty() &&
                                  !part.channels.empty() &&
                                  std::ranges::all_of(part.channels, &DbcChannel::optional);
        parts_[i].longest_absence = kGuardWithoutCycle;
        if (cycle) {
            // A sender may send one page in each cycle.
            const auto pages = part.selectors.empty() ? 1
                                                      : std::ranges::count(map_.parts, part.message,
                                                                           &DbcPart::message);
            parts_[i].longest_absence = *cycle * kMostMissedCycles * pages;
        }
    }
    // Channels that may be absent hold up no others.
    const bool others_come = std::ranges::any_of(
        parts_, [](const PartState& part) { return part.awaited && !part.may_be_absent; });
    for (PartState& part : parts_) {
        part.awaited = part.awaited && !(part.may_be_absent && others_come);
    }
}

bool DbcDecoder::uses_fd() const {
    return std::ranges::any_of(map_.messages, &DbcMappedMessage::fd);
}

bool DbcDecoder::refuse(RejectCause cause) {
    ++rejected_[cause].count;
    return false;
}

bool DbcDecoder::valid(std::size_t message, const CanFrame& frame, Instant received) {
    const DbcMappedMessage& mapped = map_.messages[message];
    messages_[message].wrong_length.reset();
    if (frame.remote || frame.length < mapped.length || frame.fd != mapped.fd) {
        if (!frame.remote && frame.length < mapped.length) {
            messages_[message].wrong_length = frame.length;
        }
        return refuse(kLength);
    }
    const auto data = frame.bytes().first(mapped.length);
    if (mapped.checksum &&
        dbc_checksum(*mapped.checksum, frame.id, data) != mapped.checksum->layout.raw_bits(data)) {
        return refuse(kChecksum);
    }
    return same_sender(message, frame, received) && counter_holds(message, data, received);
}

/// A map may allow any J1939 source, but two alternating joysticks are not one.
bool DbcDecoder::same_sender(std::size_t message, const CanFrame& frame, Instant received) {
    MessageState& state = messages_[message];
    if (state.received && ((state.id ^ frame.id) & kSourceAddress) != 0 &&
        received - *state.received <= kSenderMemory) {
        return refuse(kOtherSender);
    }
    state.id = frame.id;
    state.received = received;
    return true;
}

bool DbcDecoder::counter_holds(std::size_t message, std::span<const std::uint8_t> data,
                               Instant received) {
    MessageState& state = messages_[message];
    if (state.senders) {
        state.senders->arrived(received);
    }
    if (!state.watch) {
        return true;
    }
    const bool same = std::ranges::equal(data, std::span(state.data).first(data.size()));
    std::ranges::copy(data, state.data.begin());
    const std::uint64_t count = map_.messages[message].counter->layout.raw_bits(data);
    switch (state.watch->take(count, same, received)) {
        case CounterWatch::Verdict::good:
            return true;
        case CounterWatch::Verdict::unconfirmed:
            return refuse(kUnconfirmed);
        case CounterWatch::Verdict::repeated:
        case CounterWatch::Verdict::conflict:
            return refuse(kRepeated);
        case CounterWatch::Verdict::jump:
            break;
    }
    return refuse(kCounterJump);
}

bool DbcDecoder::holds(const DbcPart& part, std::span<const std::uint8_t> data) const {
    return std::ranges::all_of(part.selectors, [&](const DbcSelector& selector) {
        const std::uint64_t value = selector.layout.raw_bits(data);
        return std::ranges::any_of(selector.selected_by, [&](const DbcSelectorRange& range) {
            return range.first <= value && value <= range.last;
        });
    });
}

void DbcDecoder::take(std::size_t index, std::span<const std::uint8_t> data, Instant received) {
    const DbcPart& part = map_.parts[index];
    PartState& state = parts_[index];
    state.interval = state.received ? received - *state.received : Duration::zero();
    state.received = received;
    state.fresh = true;
    state.frame_lost = false;
    state.failsafe = false;
    state.without_value = nullptr;
    judge_fixed(part, data, state);
    for (const DbcFlag& flag : part.flags) {
        const std::uint64_t bits = flag.layout.raw_bits(data);
        if (flag.meaning == DbcFlagMeaning::cause) {
            continue;
        }
        const bool bad = flag.meaning == DbcFlagMeaning::good ? bits != 1 : bits != 0;
        bool& said = flag.meaning == DbcFlagMeaning::frame_lost ? state.frame_lost : state.failsafe;
        said = said || bad;
    }
    take_channels(part, data, state);
}

void DbcDecoder::judge_fixed(const DbcPart& part, std::span<const std::uint8_t> data,
                             PartState& state) {
    const auto wrong = std::ranges::find_if(part.fixed, [&](const DbcFixed& fixed) {
        return fixed.layout.raw_bits(data) != fixed.bits;
    });
    state.wrong_fixed = wrong == part.fixed.end() ? nullptr : &*wrong;
    if (state.wrong_fixed != nullptr) {
        state.bits = wrong->layout.raw_bits(data);
        state.failsafe = !refuse(kWrongFixed);
    }
}

/// A sender that says failsafe itself may send anything in its channels.
void DbcDecoder::take_channels(const DbcPart& part, std::span<const std::uint8_t> data,
                               PartState& state) {
    const bool said = state.failsafe;
    bool whole = true;
    for (const DbcChannel& channel : part.channels) {
        const auto pulse = read_dbc_channel(channel, data);
        values_[channel.channel] = pulse;
        if (!pulse && !channel.optional && std::exchange(whole, false) && !said) {
            state.without_value = &channel;
            state.bits = channel.layout.raw_bits(data);
        }
    }
    state.failsafe = said || (!whole && !refuse(kNoValue));
}

/// If all awaited parts come in one burst per cycle, the pause before a burst separates it from the
/// one before. Otherwise a decoder that began within a burst would mix two bursts for ever. Each
/// part comes within the longest interval, so a pause above half of that cannot separate parts that
/// belong together for ever either.
void DbcDecoder::start_round_after_pause(Instant received) {
    Duration longest{};
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        const auto cycle = map_.messages[map_.parts[i].message].cycle.value_or(Duration::zero());
        const Duration interval = std::max(parts_[i].interval, cycle);
        if (parts_[i].awaited && interval == Duration::zero()) {
            return;
        }
        longest = parts_[i].awaited ? std::max(longest, interval) : longest;
    }
    if (awaited_received_ && (received - *awaited_received_) * 5 > longest * 3) {
        for (PartState& part : parts_) {
            part.fresh = part.fresh && part.received == received;
        }
    }
}

bool DbcDecoder::complete() const {
    return std::ranges::all_of(parts_,
                               [](const PartState& part) { return part.fresh || !part.awaited; });
}

bool DbcDecoder::overdue(const PartState& part, Instant now) const {
    return !part.received || now - *part.received > part.longest_absence;
}

ChannelFrame DbcDecoder::snapshot(Instant now) {
    ChannelFrame snapshot;
    snapshot.received = now;
    snapshot.origin = Origin::dbc;
    snapshot.frame_lost = snapshot.failsafe = false;
    absent_part_.reset();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        PartState& part = parts_[i];
        const bool missing = !part.awaited && overdue(part, now);
        if (missing && part.may_be_absent) {
            for (const DbcChannel& channel : map_.parts[i].channels) {
                values_[channel.channel].reset();
            }
        } else if (missing) {
            absent_part_ = i;
        }
        snapshot.failsafe = snapshot.failsafe || part.failsafe || absent_part_.has_value();
        snapshot.frame_lost = snapshot.frame_lost || part.frame_lost;
        if (part.awaited && part.received) {
            snapshot.received = std::min(snapshot.received, *part.received);
        }
    }
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        snapshot.set(channel, values_[channel]);
    }
    reported_failsafe_ = snapshot.failsafe;
    return snapshot;
}

/// A message whose frames are refused is at fault for that, not for the values that it had before.
void DbcDecoder::forget_old_faults(std::size_t message, Instant now) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        if (map_.parts[i].message == message && overdue(parts_[i], now)) {
            parts_[i].without_value = nullptr;
            parts_[i].wrong_fixed = nullptr;
            absent_part_.reset();
        }
    }
}

std::optional<ChannelFrame> DbcDecoder::next(const CanFrame& frame, Instant received) {
    const auto match =
        std::ranges::find_if(wanted_, [&](const CanIdMatch& id) { return id.matches(frame); });
    if (match == wanted_.end()) {
        return std::nullopt;
    }
    const auto message = static_cast<std::size_t>(match - wanted_.begin());
    if (!valid(message, frame, received)) {
        forget_old_faults(message, received);
        return std::nullopt;
    }
    const auto data = frame.bytes().first(map_.messages[message].length);
    bool awaited = false;
    bool failsafe = false;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        if (map_.parts[i].message == message && holds(map_.parts[i], data)) {
            take(i, data, received);
            awaited = awaited || parts_[i].awaited;
            failsafe = failsafe || parts_[i].failsafe;
        }
    }
    if (awaited) {
        start_round_after_pause(received);
        awaited_received_ = received;
    }
    if (awaited && complete()) {
        for (PartState& part : parts_) {
            part.fresh = false;
        }
        return snapshot(received);
    }
    return failsafe && !reported_failsafe_ ? std::optional(snapshot(received)) : std::nullopt;
}

}  // namespace tribus
