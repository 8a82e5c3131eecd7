#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "transports/codecs/authenticated/broadcast_ends.h"

/// Both ends of an authenticated link on classic CAN (docs/protocols/authenticated.md, "On classic
/// CAN"): each message goes in frames of 8 bytes, whose ids follow each other and tell which part
/// of which message they are. Snapshots have the first ids, then come hellos, then challenges.
namespace tribus::authenticated {

inline constexpr std::size_t kSnapshotFrames = kSnapshotBytes / kMostClassicBytes;
inline constexpr std::size_t kHelloFrames = kHelloBytes / kMostClassicBytes;
inline constexpr std::size_t kChallengeFrames = kChallengeBytes / kMostClassicBytes;
/// Ids of a link.
inline constexpr std::size_t kClassicIds = kSnapshotFrames + kHelloFrames + kChallengeFrames;

struct ClassicLink {
    LinkWithKey keys;
    std::uint32_t first_id = 0;
    bool extended = false;
};

/// Puts messages of one length together from classic frames. A message with a lost or repeated
/// frame is dropped. Pure. No heap.
class MessageParts {
  public:
    /// `bytes`: length of a message, at most that of an FD frame.
    MessageParts(std::uint32_t first_id, bool extended, std::size_t bytes)
        : first_id_(first_id), extended_(extended), bytes_(bytes) {}

    bool is_part(const CanFrame& frame) const {
        return frame.extended == extended_ && frame.id - first_id_ < bytes_ / kMostClassicBytes;
    }
    /// Takes a part. Returns the message that it completes, valid until the next call; else
    /// nothing.
    std::span<const std::uint8_t> take(const CanFrame& part);
    /// Messages that were dropped.
    std::uint64_t incomplete() const { return incomplete_; }
    /// Writes the parts of a message of this length. Returns how many.
    std::size_t split(std::span<const std::uint8_t> message, std::span<CanFrame> frames) const;

  private:
    std::uint32_t first_id_;
    bool extended_;
    std::size_t bytes_;
    std::size_t taken_ = 0;  ///< parts of the present message
    bool drops_ = false;     ///< the present message; it is counted
    std::uint64_t incomplete_ = 0;
    std::array<std::uint8_t, kMostFdBytes> message_{};
};

/// The frames of a link, at either end.
class ClassicFrames {
  public:
    explicit ClassicFrames(const ClassicLink& link);

    std::span<const CanIdMatch> of_sender() const { return {ids_.data(), kSenderIds}; }
    std::span<const CanIdMatch> of_receiver() const { return std::span(ids_).subspan(kSenderIds); }

    MessageParts snapshots;
    MessageParts hellos;
    MessageParts challenges;

  private:
    static constexpr std::size_t kSenderIds = kSnapshotFrames + kHelloFrames;

    std::array<CanIdMatch, kClassicIds> ids_;
};

/// The end that receives snapshots.
class ClassicDecoder final : public CanDecoder {
  public:
    explicit ClassicDecoder(const ClassicLink& link);

    std::span<const CanIdMatch> wanted() const override { return frames_.of_sender(); }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    void use_seed(const RandomSeed& seed) override { messages_->use_seed(seed); }
    void use_random(RandomSource random) override { messages_->use_random(random); }
    void use_numbers(NumberReservation& numbers) override { messages_->use_numbers(numbers); }
    std::span<const CanIdMatch> answered() const override {
        return messages_->answered().empty() ? messages_->answered() : frames_.of_receiver();
    }
    std::span<const CanFrame> answer(Instant now) override;
    /// Those of the decoder of whole messages, and "incomplete": messages of which a frame was
    /// lost.
    std::span<const NamedCount> rejected() const override { return rejected_; }
    void use_keys_of(const DecoderReport& fresh) override;
    LinkCause why_garbled() const override { return messages_->why_garbled(); }
    std::size_t write_fault(std::span<char> text) const override {
        return messages_->write_fault(text);
    }

  private:
    void count_rejected();

    ClassicFrames frames_;
    std::unique_ptr<CanDecoder> messages_;
    std::array<CanFrame, kMostSnapshotFrames> answer_{};
    std::vector<NamedCount> rejected_;
};

/// The end that sends them.
class ClassicEncoder final : public CanEncoder {
  public:
    explicit ClassicEncoder(const ClassicLink& link);

    std::span<const CanIdMatch> sent() const override { return frames_.of_sender(); }
    std::span<const CanIdMatch> heard() const override {
        return messages_->heard().empty() ? messages_->heard() : frames_.of_receiver();
    }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return true; }
    bool may_withhold() const override { return messages_->may_withhold(); }
    Withheld withheld() const override { return messages_->withheld(); }
    void use_seed(const RandomSeed& seed) override { messages_->use_seed(seed); }
    void use_numbers(NumberReservation& numbers) override { messages_->use_numbers(numbers); }
    void continue_from(const Encoder& before) override;
    void hear(const CanFrame& frame, Instant received) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    ClassicFrames frames_;
    std::unique_ptr<CanEncoder> messages_;
    std::array<CanFrame, kMostSnapshotFrames> whole_{};
};

static_assert(kSnapshotFrames + kHelloFrames <= kMostSnapshotFrames);

}  // namespace tribus::authenticated
