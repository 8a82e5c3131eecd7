#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/time.h"
#include "transports/codecs/authenticated/broadcast.h"
#include "transports/codecs/authenticated/fd_ends.h"
#include "transports/codecs/can_codec.h"

/// Both ends of an authenticated link whose messages are CAN FD frames, and whose receivers do not
/// answer.
namespace tribus::authenticated {

/// An end that receives snapshots.
class BroadcastDecoder final : public CanDecoder {
  public:
    explicit BroadcastDecoder(const FdLink& link);

    bool uses_fd() const override { return true; }
    std::span<const CanIdMatch> wanted() const override { return {&sender_id_, 1}; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    void use_numbers(NumberReservation& numbers) override { receiver_.use_numbers(numbers); }
    /// See BroadcastReceiver::rejected.
    std::span<const NamedCount> rejected() const override { return receiver_.rejected(); }
    void use_keys_of(const DecoderReport& fresh) override;
    LinkCause why_garbled() const override { return receiver_.why_refused(); }
    std::size_t write_fault(std::span<char> text) const override {
        return receiver_.write_fault(text);
    }

  private:
    CanIdMatch sender_id_;
    BroadcastReceiver receiver_;
};

/// The end that sends them.
class BroadcastEncoder final : public CanEncoder {
  public:
    explicit BroadcastEncoder(const FdLink& link);

    bool uses_fd() const override { return true; }
    std::span<const CanIdMatch> sent() const override { return {&sender_id_, 1}; }
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override { return 0; }
    bool marks_frame_lost() const override { return true; }
    bool may_withhold() const override { return true; }
    Withheld withheld() const override { return withheld_; }
    void use_numbers(NumberReservation& numbers) override { sender_.use_numbers(numbers); }
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    CanIdMatch sender_id_;
    BroadcastSender sender_;
    Withheld withheld_ = Withheld::nothing;
};

/// An end of the link on FD frames: one that answers or hears answers, or, with an epoch, one that
/// does not.
std::unique_ptr<CanDecoder> make_fd_decoder(const FdLink& link);
std::unique_ptr<CanEncoder> make_fd_encoder(const FdLink& link);

}  // namespace tribus::authenticated
