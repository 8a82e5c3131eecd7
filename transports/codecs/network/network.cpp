#include "transports/codecs/network/network.h"

#include <algorithm>

#include "transports/codecs/native_can/channels.h"

namespace tribus {
namespace {

constexpr CanChannelsFormat kPlainFormat{.fd = true};

bool is_message_length(std::size_t length) {
    return length == network::kPlainBytes || length == authenticated::kHelloBytes ||
           length == authenticated::kChallengeBytes || length == authenticated::kSnapshotBytes;
}

/// As a frame with the only id that the codec of the messages reads or hears.
CanFrame as_can_frame(const CanIdMatch& id, std::span<const std::uint8_t> message) {
    return fd_frame(id.id, id.extended, message);
}

/// Writes all of them, each with its head. Returns the length.
std::size_t put_frames(std::span<const CanFrame> frames, std::span<std::uint8_t> wire) {
    std::size_t length = 0;
    for (const CanFrame& frame : frames) {
        const std::array<std::uint8_t, network::kHeadBytes> head{
            network::kFirstByte, network::kSecondByte, network::kVersion, frame.length};
        std::ranges::copy(head, wire.subspan(length).begin());
        std::ranges::copy(frame.bytes(), wire.subspan(length + network::kHeadBytes).begin());
        length += network::kHeadBytes + frame.length;
    }
    return length;
}

/// In a datagram a message is whole, and not out of order with itself.
bool can_happen(std::string_view cause) {
    return cause != "checksum" && cause != "incomplete" && cause != "stray";
}

std::vector<std::string_view> causes_of(const CanDecoder& messages) {
    std::vector<std::string_view> names;
    for (const NamedCount& count : messages.rejected()) {
        if (can_happen(count.name)) {
            names.push_back(count.name);
        }
    }
    return names;
}

}  // namespace

NetworkDecoder::NetworkDecoder(std::unique_ptr<CanDecoder> messages)
    : FramedDecoder(causes_of(*messages)), messages_(std::move(messages)) {
    const auto all = messages_->rejected();
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (can_happen(all[i].name)) {
            causes_.push_back(i);
        }
    }
    counted_.resize(causes_.size());
}

void NetworkDecoder::use_keys_of(const DecoderReport& fresh) {
    if (const auto* same = dynamic_cast<const NetworkDecoder*>(&fresh)) {
        messages_->use_keys_of(*same->messages_);
    }
}

std::size_t NetworkDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    const std::size_t known = std::min(bytes.size(), network::kBeginning.size());
    if (!std::ranges::equal(bytes.first(known), std::span(network::kBeginning).first(known))) {
        return 0;
    }
    if (bytes.size() < network::kHeadBytes) {
        return bytes.size() + 1;
    }
    const std::size_t length = bytes[network::kLengthAt];
    return is_message_length(length) ? network::kHeadBytes + length : 0;
}

/// Messages with a key are proved when they are read.
bool NetworkDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    const auto message = frame.subspan(network::kHeadBytes);
    return message.size() != network::kPlainBytes ||
           can_channels_crc(kPlainFormat, can_channels::kFdIndex, message) ==
               can_channels::get(message, can_channels::kFdCrc);
}

bool NetworkDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    const Instant arrival = channels.received;
    const auto snapshot = messages_->next(
        as_can_frame(messages_->wanted().front(), frame.subspan(network::kHeadBytes)), arrival);
    count_refusals();
    if (!snapshot) {
        return false;
    }
    channels = *snapshot;
    age_ = arrival - snapshot->received;
    return true;
}

void NetworkDecoder::count_refusals() {
    const auto all = messages_->rejected();
    for (std::size_t i = 0; i < causes_.size(); ++i) {
        if (all[causes_[i]].count != counted_[i]) {
            counted_[i] = all[causes_[i]].count;
            refuse(i);
        }
    }
}

std::span<const std::uint8_t> NetworkDecoder::answer(Instant now) {
    return std::span(answer_).first(put_frames(messages_->answer(now), answer_));
}

void NetworkEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const NetworkEncoder*>(&before)) {
        messages_->continue_from(*same->messages_);
    }
}

std::size_t NetworkEncoder::write(const ChannelFrame& frame,
                                  std::span<std::uint8_t, kLongestSerialFrame> wire, Instant now) {
    const std::span<CanFrame, kMostSnapshotFrames> room(frames_);
    return put_frames(std::span<const CanFrame>(room).first(messages_->write(frame, room, now)),
                      wire);
}

/// An answer is a datagram of its own.
std::optional<AskedTiming> NetworkEncoder::hear(std::span<const std::uint8_t> bytes, Instant now) {
    const auto heard = messages_->heard();
    if (!heard.empty() && bytes.size() > network::kHeadBytes &&
        bytes.size() <= network::kHeadBytes + kMostFdBytes &&
        std::ranges::equal(bytes.first(network::kLengthAt), network::kBeginning) &&
        bytes.size() == network::kHeadBytes + bytes[network::kLengthAt]) {
        messages_->hear(as_can_frame(heard.front(), bytes.subspan(network::kHeadBytes)), now);
    }
    return std::nullopt;
}

}  // namespace tribus
