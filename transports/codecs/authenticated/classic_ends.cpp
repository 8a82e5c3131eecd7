#include "transports/codecs/authenticated/classic_ends.h"

#include <algorithm>

namespace tribus::authenticated {
namespace {

constexpr auto kFirstHello = static_cast<std::uint32_t>(kSnapshotFrames);
constexpr auto kFirstChallenge = static_cast<std::uint32_t>(kSnapshotFrames + kHelloFrames);

std::array<CanIdMatch, kClassicIds> ids_of(const ClassicLink& link) {
    std::array<CanIdMatch, kClassicIds> ids{};
    for (std::size_t i = 0; i < ids.size(); ++i) {
        ids[i] = {.id = link.first_id + static_cast<std::uint32_t>(i), .extended = link.extended};
    }
    return ids;
}

/// The ids of whole messages are those of no frame.
FdLink messages_of(const ClassicLink& link) {
    return {.keys = link.keys,
            .sender_id = 1,
            .receiver_id = 0,
            .answers = kMostSnapshotFrames / kChallengeFrames};
}

CanFrame whole(const CanIdMatch& id, std::span<const std::uint8_t> message) {
    return fd_frame(id.id, id.extended, message);
}

}  // namespace

std::span<const std::uint8_t> MessageParts::take(const CanFrame& part) {
    const std::size_t place = part.id - first_id_;
    const bool sound = !part.fd && !part.remote && part.length == kMostClassicBytes;
    if (!sound || place != taken_) {
        // A message counts once, whatever else of it comes.
        incomplete_ += drops_ ? 0 : 1;
        taken_ = 0;
        drops_ = !sound || place > 0;
        if (drops_) {
            return {};
        }
    }
    drops_ = false;
    std::ranges::copy(part.bytes(), message_.begin() + place * kMostClassicBytes);
    if (++taken_ < bytes_ / kMostClassicBytes) {
        return {};
    }
    taken_ = 0;
    return std::span(message_).first(bytes_);
}

std::size_t MessageParts::split(std::span<const std::uint8_t> message,
                                std::span<CanFrame> frames) const {
    const std::size_t parts = bytes_ / kMostClassicBytes;
    for (std::size_t i = 0; i < parts; ++i) {
        CanFrame& frame = frames[i];
        frame = {.id = first_id_ + static_cast<std::uint32_t>(i),
                 .extended = extended_,
                 .length = kMostClassicBytes};
        std::ranges::copy(message.subspan(i * kMostClassicBytes, kMostClassicBytes),
                          frame.data.begin());
    }
    return parts;
}

ClassicFrames::ClassicFrames(const ClassicLink& link)
    : snapshots(link.first_id, link.extended, kSnapshotBytes),
      hellos(link.first_id + kFirstHello, link.extended, kHelloBytes),
      challenges(link.first_id + kFirstChallenge, link.extended, kChallengeBytes),
      ids_(ids_of(link)) {}

ClassicDecoder::ClassicDecoder(const ClassicLink& link)
    : frames_(link), messages_(make_fd_decoder(messages_of(link))) {
    const auto of_messages = messages_->rejected();
    rejected_.assign(of_messages.begin(), of_messages.end());
    rejected_.push_back({"incomplete"});
}

void ClassicDecoder::use_keys_of(const DecoderReport& fresh) {
    if (const auto* same = dynamic_cast<const ClassicDecoder*>(&fresh)) {
        messages_->use_keys_of(*same->messages_);
    }
}

void ClassicDecoder::count_rejected() {
    std::ranges::copy(messages_->rejected(), rejected_.begin());
    rejected_.back().count = frames_.snapshots.incomplete() + frames_.hellos.incomplete();
}

std::optional<ChannelFrame> ClassicDecoder::next(const CanFrame& frame, Instant received) {
    MessageParts* const parts = frames_.snapshots.is_part(frame) ? &frames_.snapshots
                                : frames_.hellos.is_part(frame)  ? &frames_.hellos
                                                                 : nullptr;
    if (parts == nullptr) {
        return std::nullopt;
    }
    const auto message = parts->take(frame);
    const auto snapshot =
        message.empty() ? std::nullopt
                        : messages_->next(whole(messages_->wanted().front(), message), received);
    count_rejected();
    return snapshot;
}

std::span<const CanFrame> ClassicDecoder::answer(Instant now) {
    std::size_t written = 0;
    for (const CanFrame& challenge : messages_->answer(now)) {
        written += frames_.challenges.split(challenge.bytes(), std::span(answer_).subspan(written));
    }
    return std::span(answer_).first(written);
}

ClassicEncoder::ClassicEncoder(const ClassicLink& link)
    : frames_(link), messages_(make_fd_encoder(messages_of(link))) {}

void ClassicEncoder::continue_from(const Encoder& before) {
    if (const auto* same = dynamic_cast<const ClassicEncoder*>(&before)) {
        messages_->continue_from(*same->messages_);
    }
}

void ClassicEncoder::hear(const CanFrame& frame, Instant received) {
    if (frames_.challenges.is_part(frame)) {
        if (const auto message = frames_.challenges.take(frame); !message.empty()) {
            messages_->hear(whole(messages_->heard().front(), message), received);
        }
    }
}

std::size_t ClassicEncoder::write(const ChannelFrame& snapshot,
                                  std::span<CanFrame, kMostSnapshotFrames> frames, Instant now) {
    const std::size_t count = messages_->write(snapshot, whole_, now);
    std::size_t written = 0;
    for (const CanFrame& message : std::span<const CanFrame>(whole_).first(count)) {
        const MessageParts& parts =
            message.length == kHelloBytes ? frames_.hellos : frames_.snapshots;
        written += parts.split(message.bytes(), frames.subspan(written));
    }
    return written;
}

}  // namespace tribus::authenticated
