#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/time.h"
#include "transports/codecs/framed_decoder.h"
#include "transports/codecs/mavlink/signature.h"
#include "transports/codecs/mavlink/wire.h"

namespace tribus {

/// A message of a known kind whose check was right.
struct MavlinkMessage {
    std::uint32_t id = 0;
    std::uint8_t system = 0;
    std::uint8_t component = 0;
    /// All fields; those that were not sent are 0.
    std::array<std::uint8_t, mavlink_wire::kMostPayload> payload{};
};

/// Finds the messages of MAVLink 1 and 2 that tribus knows. Messages of other kinds are passed over
/// by their length, because their check cannot be verified; so nothing inside of them counts. They
/// may be longer than LineBuffer::kCapacity. With a key, a message without a right signature never
/// counts.
class MavlinkMessages : public FramedDecoder {
  public:
    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    void reset() override;
    void use_clock(const WallClock& clock) final;

  protected:
    explicit MavlinkMessages(const std::optional<SecretKey>& key);
    void refuse_sender() { refuse(0); }
    /// Returns whether the message has channels, then `channels` has them.
    virtual bool take(const MavlinkMessage& message, ChannelFrame& channels) = 0;

  private:
    Taken decode(std::span<const std::uint8_t> bytes, Instant received, DecodedFrame& frame) final;
    std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const final;
    bool check_holds(std::span<const std::uint8_t> frame) const final;
    bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) final;
    void pass_over(std::size_t count);
    bool is_genuine(std::span<const std::uint8_t> frame, std::uint32_t id, Instant received);
    /// Whether messages of this kind count without a signature.
    virtual bool takes_unsigned(std::uint32_t id) const = 0;

    std::optional<MavlinkVerifier> verifier_;
    /// Bytes of a long message that are still to come.
    std::size_t passed_over_ = 0;
};

/// Keeps to one sender on a line that many share: the first one heard, until it was silent for a
/// second. So two senders never alternate. Two components of a system are two senders.
class MavlinkSender {
  public:
    static constexpr Duration kGone = std::chrono::seconds(1);

    /// `system`: only this one counts; absent: any.
    explicit MavlinkSender(std::optional<std::uint8_t> system = std::nullopt) : system_(system) {}
    /// Whether a message, received at `at`, is from the sender. `id`: its messages of this kind are
    /// told apart from others; 0: they are not.
    bool sent(const MavlinkMessage& message, std::uint32_t id, Instant at) {
        const Heard heard{message.system, message.component, id, at};
        const bool free = !heard_ || at - heard_->at >= kGone;
        const bool allowed = !system_ || *system_ == message.system;
        if (!allowed || (!free && !heard_->is_same(heard))) {
            return false;
        }
        heard_ = heard;
        return true;
    }
    void forget() { heard_.reset(); }

  private:
    struct Heard {
        std::uint8_t system = 0;
        std::uint8_t component = 0;
        std::uint32_t id = 0;
        Instant at{};

        bool is_same(const Heard& other) const {
            return system == other.system && component == other.component && id == other.id;
        }
    };
    std::optional<std::uint8_t> system_;
    std::optional<Heard> heard_;
};

}  // namespace tribus
