#pragma once

#include <nettle/sha2.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/setting.h"
#include "core/time.h"
#include "core/wall_clock.h"
#include "transports/codecs/mavlink/wire.h"

/// Signatures of MAVLink 2 (docs/protocols/mavlink.md, "Signatures"). No heap. Thread-bound.
namespace tribus {

/// The hash that a signature begins with, by a secret that two ends share. Its memory is cleared at
/// the end.
class MavlinkHash {
  public:
    explicit MavlinkHash(const SecretKey& secret);
    MavlinkHash(const MavlinkHash&) = default;
    MavlinkHash& operator=(const MavlinkHash&) = default;
    ~MavlinkHash();
    /// The six bytes behind `signed_part`: all of a frame up to its time stamp.
    std::array<std::uint8_t, mavlink_wire::kHashBytes> of(
        std::span<const std::uint8_t> signed_part) const;

  private:
    /// Has taken the secret.
    sha256_ctx begun_{};
};

/// Signs what one sender sends on one link. Its times follow a clock that is set forward at once.
/// Where the clock is slowed, or set back by less than kMostAhead, they go on at their own pace,
/// and return to it little by little.
class MavlinkSigner {
  public:
    /// Below the minute by which receivers let a stream begin ahead of their clocks.
    static constexpr Duration kMostAhead = std::chrono::seconds(30);
    /// One part in so many is half of what receivers allow (MavlinkVerifier::kDriftParts).
    static constexpr std::int64_t kReturnParts = 2000;

    MavlinkSigner(const SecretKey& secret, std::uint8_t link_id)
        : hash_(secret), link_id_(link_id) {}
    /// Without a clock, time stamps count instants, as if their zero were the year 2015.
    void use_clock(const WallClock& clock) { clock_ = &clock; }
    /// Writes the signature behind the first `length` bytes of `wire`, which are a frame.
    void sign(std::span<std::uint8_t> wire, std::size_t length, Instant now);
    /// No time stamp that `before` has used comes again.
    void continue_from(const MavlinkSigner& before);

  private:
    Duration time_at(Instant now);

    MavlinkHash hash_;
    std::uint8_t link_id_;
    const WallClock* clock_ = nullptr;
    std::uint64_t latest_ = 0;
    /// The time of the latest message, since 2015, and when that was.
    Duration latest_time_{};
    Instant latest_at_{};
};

/// Why a message does not count.
enum class SignatureFault : std::uint8_t {
    no_signature,
    wrong,     ///< another key, or not what was signed
    replayed,  ///< not newer than the one before of the same stream
    too_old,   ///< the first one of its stream, and more than a minute old
    no_room,   ///< the first one of more streams than are kept
    late,      ///< more than a second later, by its time, than the quickest of its stream
    ahead,     ///< its time leaps, or begins, more than a minute ahead of a clock that is set
};

/// Judges what many senders have signed. A stream is what one component of a system sends on one
/// link. Streams are never forgotten, or an old message would begin one again. It cannot know how
/// long the first message of a stream was on its way: it takes the quickest one since then as one
/// that was not, and tells by how much the others were later. Many programs only add one to the
/// time of each message; of these it tells no delay.
class MavlinkVerifier {
  public:
    static constexpr std::size_t kMostStreams = 16;
    /// So late a message may be.
    static constexpr Duration kMostDelay = std::chrono::seconds(1);
    /// Two clocks whose rates nobody adjusts drift apart by at most one part in so many, with what
    /// a sender's time returns to its clock (MavlinkSigner).
    static constexpr std::int64_t kDriftParts = 1000;
    /// Messages of which each has a time at most so far behind the one before: that many in a row
    /// come only from a sender that counts them.
    static constexpr Duration kCloseTimes = std::chrono::milliseconds(1);
    static constexpr int kCountedMessages = 8;

    explicit MavlinkVerifier(const SecretKey& secret) : hash_(secret) {}
    /// Without a clock, a stream may begin at any time that is not a minute before the latest one.
    void use_clock(const WallClock& clock) { clock_ = &clock; }
    /// Judges a whole frame whose CRC is right. Only a right signature changes what it keeps.
    std::optional<SignatureFault> fault_of(std::span<const std::uint8_t> frame, Instant received);
    /// How much later than the quickest one of its stream the latest message that counts came.
    Duration delay() const { return delay_; }

  private:
    struct Message {
        std::uint8_t system = 0;
        std::uint8_t component = 0;
        std::uint8_t link_id = 0;
        std::uint64_t stamp = 0;
        Instant received{};
        Instant unslewed{};  ///< the same, see WallClock
    };
    struct Stream {
        /// The one with the highest time, whether it was late or not.
        Message latest{};
        /// The quickest one, as far as clocks that drift can tell.
        Message quickest{};
        int close = 0;  ///< messages in a row, see kCloseTimes
    };
    std::optional<SignatureFault> take(const Message& message);
    std::optional<SignatureFault> begin(const Message& message);
    std::optional<SignatureFault> go_on(Stream& stream, const Message& message);
    bool is_ahead(std::uint64_t stamp, Instant received) const;
    static Duration delay_in(Stream& stream, const Message& message);

    MavlinkHash hash_;
    const WallClock* clock_ = nullptr;
    std::array<Stream, kMostStreams> streams_{};
    std::size_t known_ = 0;
    std::uint64_t newest_ = 0;  ///< of all streams
    Duration delay_{};
};

}  // namespace tribus
