#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/random_seed.h"
#include "core/time.h"
#include "transports/codecs/authenticated/receiver.h"
#include "transports/codecs/authenticated/sender.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/link_with_key.h"

/// Both ends of an authenticated link whose messages are CAN FD frames, and whose receiver answers.
namespace tribus::authenticated {

struct FdLink {
    LinkWithKey keys;
    std::uint32_t sender_id = 0;    ///< of hellos and snapshots
    std::uint32_t receiver_id = 0;  ///< of challenges
    bool extended = false;
    /// Senders that are answered at once, at most kMostAnswers. With more than one, everybody hears
    /// all answers, so others are answered later.
    std::size_t answers = kMostAnswers;
    static constexpr std::size_t kMostAnswers = 8;
};

/// The message in a frame. Frames of another kind have none.
std::span<const std::uint8_t> message_in(const CanFrame& frame);

/// The end that receives snapshots.
class FdDecoder final : public CanDecoder {
  public:
    explicit FdDecoder(const FdLink& link);

    bool uses_fd() const override { return true; }
    std::span<const CanIdMatch> wanted() const override { return {&sender_id_, 1}; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    void use_seed(const RandomSeed& seed) override { receiver_.use_seed(seed); }
    void use_random(RandomSource random) override { receiver_.use_random(random); }
    std::span<const CanIdMatch> answered() const override { return {&receiver_id_, 1}; }
    std::span<const CanFrame> answer(Instant now) override;
    /// See Receiver::rejected.
    std::span<const NamedCount> rejected() const override { return receiver_.rejected(); }
    void use_keys_of(const DecoderReport& fresh) override;
    LinkCause why_garbled() const override { return receiver_.why_refused(); }

  private:
    CanIdMatch sender_id_;
    CanIdMatch receiver_id_;
    Receiver receiver_;
    std::size_t most_answers_;
    std::array<CanFrame, FdLink::kMostAnswers> answers_{};
};

/// The end that sends them.
class FdEncoder final : public CanEncoder {
  public:
    explicit FdEncoder(const FdLink& link);

    bool uses_fd() const override { return true; }
    std::span<const CanIdMatch> sent() const override { return {&sender_id_, 1}; }
    std::span<const CanIdMatch> heard() const override { return {&receiver_id_, 1}; }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return true; }
    bool may_withhold() const override { return true; }
    Withheld withheld() const override {
        return has_receiver_ ? Withheld::nothing : Withheld::no_receiver;
    }
    void use_seed(const RandomSeed& seed) override { sender_.use_seed(seed); }
    void continue_from(const Encoder& before) override;
    void hear(const CanFrame& frame, Instant received) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    CanIdMatch sender_id_;
    CanIdMatch receiver_id_;
    Sender sender_;
    /// The same for the same secret and link.
    MacBytes proof_;
    bool has_receiver_ = false;
};

}  // namespace tribus::authenticated
