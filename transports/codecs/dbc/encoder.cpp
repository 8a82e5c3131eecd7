#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "transports/codecs/dbc/channel.h"
#include "transports/codecs/dbc/checksum.h"
#include "transports/codecs/dbc/dbc.h"

namespace tribus {

DbcEncoder::DbcEncoder(DbcMap map)
    : map_(std::move(map)), counters_(map_.messages.size()), sent_parts_(map_.parts.size()) {
    std::ranges::transform(map_.messages, std::back_inserter(sent_), &DbcMappedMessage::id);
}

bool DbcEncoder::uses_fd() const {
    return std::ranges::any_of(map_.messages, &DbcMappedMessage::fd);
}

bool DbcEncoder::due(std::size_t index, const ChannelFrame& snapshot, Instant now) const {
    const DbcPart& part = map_.parts[index];
    const SentPart& sent = sent_parts_[index];
    if (!sent.ever || !map_.messages[part.message].cycle) {
        return true;
    }
    const bool changed =
        sent.failsafe != snapshot.failsafe || sent.frame_lost != snapshot.frame_lost;
    const bool tells = !part.channels.empty() || !part.flags.empty();
    // The snapshot that is nearest to the cycle's end.
    return (changed && tells) || now + (now - encoded_) / 2 >= sent.next;
}

void DbcEncoder::note_sent(std::size_t index, const ChannelFrame& snapshot, Instant now) {
    SentPart& sent = sent_parts_[index];
    const Duration cycle =
        map_.messages[map_.parts[index].message].cycle.value_or(Duration::zero());
    const bool in_time = sent.ever && std::chrono::abs(now - sent.next) < cycle / 2;
    sent = {true, (in_time ? sent.next : now) + cycle, snapshot.failsafe, snapshot.frame_lost};
}

CanFrame DbcEncoder::make_frame(const DbcPart& part, const ChannelFrame& snapshot) {
    const DbcMappedMessage& message = map_.messages[part.message];
    CanFrame frame{.id = message.sent_id,
                   .extended = message.id.extended,
                   .fd = message.fd,
                   .bit_rate_switch = message.bit_rate_switch,
                   .length = message.length};
    const auto data = frame.bytes();
    std::ranges::fill(data, message.fill);
    for (const DbcSelector& selector : part.selectors) {
        selector.layout.set_raw_bits(data, selector.sent);
    }
    for (const DbcFixed& field : part.fixed) {
        field.layout.set_raw_bits(data, field.bits);
    }
    for (const DbcFlag& flag : part.flags) {
        const bool set = flag.meaning == DbcFlagMeaning::failsafe     ? snapshot.failsafe
                         : flag.meaning == DbcFlagMeaning::frame_lost ? snapshot.frame_lost
                                                                      : snapshot.good();
        flag.layout.set_raw_bits(data, set ? 1 : 0);
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

std::size_t DbcEncoder::encode(const ChannelFrame& snapshot, Instant now,
                               std::span<CanFrame, kMostSnapshotFrames> frames) {
    std::size_t count = 0;
    for (std::size_t part = 0; part < map_.parts.size(); ++part) {
        if (due(part, snapshot, now)) {
            note_sent(part, snapshot, now);
            frames[count++] = make_frame(map_.parts[part], snapshot);
        }
    }
    encoded_ = now;
    return count;
}

}  // namespace tribus
