#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>
#include <utility>

#include "transports/codecs/dbc/channel.h"
#include "transports/codecs/dbc/checksum.h"
#include "transports/codecs/dbc/dbc.h"

namespace tribus {
namespace {

std::uint64_t raw_flag(DbcFlagMeaning meaning, const ChannelFrame& snapshot) {
    switch (meaning) {
        case DbcFlagMeaning::failsafe:
            return snapshot.failsafe ? 1 : 0;
        case DbcFlagMeaning::frame_lost:
            return snapshot.frame_lost ? 1 : 0;
        case DbcFlagMeaning::good:
            return snapshot.good() ? 1 : 0;
        case DbcFlagMeaning::cause:
            break;
    }
    // Signals of 3 bits have no room for the causes behind these.
    switch (snapshot.cause) {
        case LinkCause::no_key:
        case LinkCause::forged:
        case LinkCause::replayed:
            return static_cast<std::uint64_t>(LinkCause::garbled);
        case LinkCause::late:
        case LinkCause::unproved:
            return static_cast<std::uint64_t>(LinkCause::stale);
        default:
            return static_cast<std::uint64_t>(snapshot.cause);
    }
}

}  // namespace

DbcEncoder::DbcEncoder(DbcMap map)
    : map_(std::move(map)),
      counters_(map_.messages.size()),
      sent_parts_(map_.parts.size()),
      sources_(map_.parts.size()) {
    std::ranges::transform(map_.messages, std::back_inserter(sent_), &DbcMappedMessage::id);
    for (std::size_t part = 0; part < sources_.size(); ++part) {
        sources_[part].resize(map_.parts[part].values.size());
        for (const DbcChannel& channel : map_.parts[part].channels) {
            if (!channel.not_available && !channel.error) {
                needed_channels_ |= 1U << channel.channel;
            }
        }
    }
}

void DbcEncoder::use(const ValueBoard& board) {
    board_ = &board;
    for (std::size_t part = 0; part < sources_.size(); ++part) {
        for (std::size_t i = 0; i < sources_[part].size(); ++i) {
            const DbcValue& value = map_.parts[part].values[i];
            const auto index = board.find(value.from);
            if (index && may_be_sent(board.value(*index).unit, value.unit)) {
                const auto conversion = unit_conversion(board.value(*index).unit, value.unit);
                sources_[part][i] = Source{*index, conversion.value_or(UnitConversion{})};
            }
        }
    }
}

bool DbcEncoder::uses_fd() const {
    return std::ranges::any_of(map_.messages, &DbcMappedMessage::fd);
}

bool DbcEncoder::marks_frame_lost() const {
    const auto marks = [](const DbcPart& part) {
        return std::ranges::any_of(part.flags, [](const DbcFlag& flag) {
            return flag.meaning != DbcFlagMeaning::failsafe;
        });
    };
    // Held values in one unmarked frame are unmarked.
    return std::ranges::any_of(map_.parts, marks) &&
           std::ranges::all_of(map_.parts, [marks](const DbcPart& part) {
               return part.channels.empty() || marks(part);
           });
}

bool DbcEncoder::due(std::size_t index, const ChannelFrame& snapshot, Instant now) const {
    const DbcPart& part = map_.parts[index];
    const SentPart& sent = sent_parts_[index];
    if (!sent.ever || !map_.messages[part.message].cycle) {
        return true;
    }
    const bool changed = sent.failsafe != snapshot.failsafe ||
                         sent.frame_lost != snapshot.frame_lost || sent.cause != snapshot.cause;
    const bool tells = !part.channels.empty() || !part.flags.empty();
    // Sent with the snapshot that is nearest to the end of the cycle.
    return (changed && tells) || now + (now - encoded_) / 2 >= sent.next;
}

void DbcEncoder::note_sent(std::size_t index, const ChannelFrame& snapshot, Instant now) {
    SentPart& sent = sent_parts_[index];
    const Duration cycle =
        map_.messages[map_.parts[index].message].cycle.value_or(Duration::zero());
    const bool in_time = sent.ever && std::chrono::abs(now - sent.next) < cycle / 2;
    sent = {true, (in_time ? sent.next : now) + cycle, snapshot.failsafe, snapshot.frame_lost,
            snapshot.cause};
}

bool DbcEncoder::write_values(std::size_t index, Instant now, std::span<std::uint8_t> data) const {
    const auto& values = map_.parts[index].values;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::optional<Source>& source = sources_[index][i];
        auto number = source ? board_->fresh(source->index, now) : std::nullopt;
        if (number) {
            number = source->conversion.apply(*number);
        }
        if (!write_dbc_value(values[i], number, data)) {
            return false;
        }
    }
    return true;
}

std::optional<CanFrame> DbcEncoder::make_frame(std::size_t index, const ChannelFrame& snapshot,
                                               Instant now) {
    const DbcPart& part = map_.parts[index];
    const DbcMappedMessage& message = map_.messages[part.message];
    CanFrame frame{.id = message.sent_id,
                   .extended = message.id.extended,
                   .fd = message.fd,
                   .bit_rate_switch = message.bit_rate_switch,
                   .length = message.length};
    const auto data = frame.bytes();
    std::ranges::fill(data, message.fill);
    if (!write_values(index, now, data)) {
        return std::nullopt;
    }
    for (const DbcSelector& selector : part.selectors) {
        selector.layout.set_raw_bits(data, selector.sent);
    }
    for (const DbcFixed& field : part.fixed) {
        field.layout.set_raw_bits(data, field.bits);
    }
    for (const DbcFlag& flag : part.flags) {
        flag.layout.set_raw_bits(data, raw_flag(flag.meaning, snapshot));
    }
    for (const DbcChannel& channel : part.channels) {
        write_dbc_channel(channel, snapshot.channel(channel.channel), snapshot.failsafe, data);
    }
    if (message.counter) {
        std::uint64_t& counter = counters_[part.message];
        message.counter->layout.set_raw_bits(data, counter);
        counter = counter == message.counter->most ? 0 : counter + 1;
    }
    if (message.checksum) {
        message.checksum->layout.set_raw_bits(data,
                                              dbc_checksum(*message.checksum, frame.id, data));
    }
    return frame;
}

void DbcEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const DbcEncoder*>(&before);
    if (same != nullptr && same->counters_.size() == counters_.size() &&
        same->sent_parts_.size() == sent_parts_.size()) {
        std::ranges::copy(same->counters_, counters_.begin());
        std::ranges::copy(same->sent_parts_, sent_parts_.begin());
        encoded_ = same->encoded_;
    }
}

std::size_t DbcEncoder::write(const ChannelFrame& snapshot,
                              std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    std::size_t count = 0;
    for (std::size_t part = 0; part < map_.parts.size(); ++part) {
        const auto frame =
            due(part, snapshot, now) ? make_frame(part, snapshot, now) : std::nullopt;
        if (frame) {
            note_sent(part, snapshot, now);
            frames[count++] = *frame;
        }
    }
    encoded_ = now;
    return count;
}

}  // namespace tribus
