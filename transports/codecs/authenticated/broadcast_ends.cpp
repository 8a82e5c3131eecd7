#include "transports/codecs/authenticated/broadcast_ends.h"

namespace tribus::authenticated {
namespace {

Mac broadcast_keys(const SecretKey& secret, const FdLink& link) {
    return Mac(link_key(secret, Purpose::broadcast, link.keys.name));
}

std::optional<Mac> old_broadcast_keys(const FdLink& link) {
    return link.keys.old_secret ? std::optional(broadcast_keys(*link.keys.old_secret, link))
                                : std::nullopt;
}

}  // namespace

BroadcastDecoder::BroadcastDecoder(const FdLink& link)
    : sender_id_{.id = link.sender_id, .extended = link.extended},
      receiver_(broadcast_keys(link.keys.secret, link), old_broadcast_keys(link)) {}

void BroadcastDecoder::use_keys_of(const DecoderReport& fresh) {
    if (const auto* same = dynamic_cast<const BroadcastDecoder*>(&fresh)) {
        receiver_.use_keys_of(same->receiver_);
    }
}

std::optional<ChannelFrame> BroadcastDecoder::next(const CanFrame& frame, Instant received) {
    return sender_id_.matches(frame) ? receiver_.next(message_in(frame), received) : std::nullopt;
}

BroadcastEncoder::BroadcastEncoder(const FdLink& link)
    : sender_id_{.id = link.sender_id, .extended = link.extended},
      sender_(broadcast_keys(link.keys.secret, link)) {}

void BroadcastEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const BroadcastEncoder*>(&before)) {
        withheld_ = same->withheld_;
    }
}

std::size_t BroadcastEncoder::write(const ChannelFrame& snapshot,
                                    std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    SnapshotMessage message{};
    if (!sender_.write(snapshot, message, now)) {
        withheld_ = Withheld::no_numbers;
        return 0;
    }
    withheld_ = Withheld::nothing;
    frames.front() = fd_frame(sender_id_.id, sender_id_.extended, message);
    return 1;
}

std::unique_ptr<CanDecoder> make_fd_decoder(const FdLink& link) {
    if (link.keys.epoch) {
        return std::make_unique<BroadcastDecoder>(link);
    }
    return std::make_unique<FdDecoder>(link);
}

std::unique_ptr<CanEncoder> make_fd_encoder(const FdLink& link) {
    if (link.keys.epoch) {
        return std::make_unique<BroadcastEncoder>(link);
    }
    return std::make_unique<FdEncoder>(link);
}

}  // namespace tribus::authenticated
