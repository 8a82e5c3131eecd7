#include "transports/codecs/authenticated/fd_ends.h"

namespace tribus::authenticated {
namespace {

std::optional<LinkMacs> macs_of(const std::optional<SecretKey>& secret, const std::string& link) {
    return secret ? std::optional(LinkMacs(*secret, link)) : std::nullopt;
}

}  // namespace

std::span<const std::uint8_t> message_in(const CanFrame& frame) {
    return frame.fd && !frame.remote ? frame.bytes() : std::span<const std::uint8_t>{};
}

FdDecoder::FdDecoder(const FdLink& link)
    : sender_id_{.id = link.sender_id, .extended = link.extended},
      receiver_id_{.id = link.receiver_id, .extended = link.extended},
      receiver_(LinkMacs(link.keys.secret, link.keys.name),
                macs_of(link.keys.old_secret, link.keys.name), {}),
      most_answers_(link.answers) {}

void FdDecoder::use_keys_of(const DecoderReport& fresh) {
    if (const auto* same = dynamic_cast<const FdDecoder*>(&fresh)) {
        receiver_.use_keys_of(same->receiver_);
    }
}

std::optional<ChannelFrame> FdDecoder::next(const CanFrame& frame, Instant received) {
    return sender_id_.matches(frame) ? receiver_.next(message_in(frame), received) : std::nullopt;
}

std::span<const CanFrame> FdDecoder::answer(Instant now) {
    std::size_t count = 0;
    ChallengeMessage message{};
    while (count < most_answers_ && receiver_.answer(message, now)) {
        answers_[count++] = fd_frame(receiver_id_.id, receiver_id_.extended, message);
    }
    if (most_answers_ == 1) {
        receiver_.forget_askers();
    }
    return std::span(answers_).first(count);
}

FdEncoder::FdEncoder(const FdLink& link)
    : sender_id_{.id = link.sender_id, .extended = link.extended},
      receiver_id_{.id = link.receiver_id, .extended = link.extended},
      sender_(LinkMacs(link.keys.secret, link.keys.name), {}),
      proof_(LinkMacs(link.keys.secret, link.keys.name).hello.of({})) {}

void FdEncoder::continue_from(const Encoder& before) {
    const auto* same = dynamic_cast<const FdEncoder*>(&before);
    if (same != nullptr && same->proof_ == proof_) {
        sender_ = same->sender_;
        has_receiver_ = same->has_receiver_;
    }
}

void FdEncoder::hear(const CanFrame& frame, Instant received) {
    if (receiver_id_.matches(frame)) {
        sender_.hear(message_in(frame), received);
    }
}

std::size_t FdEncoder::write(const ChannelFrame& snapshot,
                             std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    std::size_t count = 0;
    HelloMessage hello{};
    if (sender_.write_hello(hello, now)) {
        frames[count++] = fd_frame(sender_id_.id, sender_id_.extended, hello);
    }
    SnapshotMessage message{};
    has_receiver_ = sender_.write(snapshot, message, now);
    if (has_receiver_) {
        frames[count++] = fd_frame(sender_id_.id, sender_id_.extended, message);
    }
    return count;
}

}  // namespace tribus::authenticated
