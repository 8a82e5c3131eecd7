#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "core/unit.h"
#include "core/value_board.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/counter_watch.h"
#include "transports/codecs/dbc/map.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/rhythm_watch.h"

/// RC channels in the messages of the user's own DBC file, both ways (docs/protocols/can.md, "DBC
/// files").
namespace tribus {

extern const Protocol kDbcProtocol;

/// Puts the latest frames of all mapped messages together.
///
/// A snapshot is complete when each awaited part has arrived since the snapshot before: the parts
/// with channels whose message is about as quick as the quickest of them, or whose cycle nobody
/// knows. `received` is the arrival of the oldest of them. Where senders send in bursts, the parts
/// of one snapshot are those of one burst.
/// The other parts (a heartbeat, a status, slow channels) are not waited for, but while one of them
/// is missing for three of its cycles, or 500 ms without a cycle, the snapshot says failsafe. So it
/// does while a fixed signal has another value, or a channel that is not optional has none: a code,
/// or beyond the range of the file. The first such frame is told at once, without the others.
///
/// Refused are frames with a wrong length or checksum; with a J1939 source other than that of the
/// second before, where the source is open; whose counter stands still or goes on by more than 3;
/// and, where there is a counter, until it has gone on rightly twice in a row: after the start, a
/// jump, or silence. After a jump for which there was no time it must go through its whole range
/// (`CounterWatch`). So neither a sender that hangs, nor two senders, nor old frames in a ring are
/// believed. Two senders of a message without a counter cannot be kept apart: `two_senders` tells
/// of them.
class DbcDecoder final : public CanDecoder {
  public:
    explicit DbcDecoder(DbcMap map);

    bool uses_fd() const override;
    std::span<const CanIdMatch> wanted() const override { return wanted_; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    std::span<const NamedCount> rejected() const override { return rejected_; }
    bool two_senders() const override;

  private:
    enum RejectCause : std::size_t {
        kLength,
        kChecksum,
        kRepeated,
        kCounterJump,
        kUnconfirmed,
        kOtherSender,
        kNoValue,     ///< a frame that counts, but a channel that must has no value
        kWrongFixed,  ///< likewise, a fixed signal has another value
    };

    struct MessageState {
        std::optional<Instant> received;
        std::uint32_t id = 0;
        std::optional<CounterWatch> watch;              ///< of a message with a counter
        std::optional<RhythmWatch> rhythm;              ///< of one without, and without pages
        std::array<std::uint8_t, kMostFdBytes> data{};  ///< of its last frame
    };
    struct PartState {
        bool awaited = true;
        Duration longest_absence{};  ///< of a part that is not awaited
        bool fresh = false;          ///< arrived since the last snapshot
        std::optional<Instant> received{};
        Duration interval{};  ///< between its last two arrivals; zero: not known
        bool failsafe = false;
        bool frame_lost = false;
    };

    void watch_counters();
    void watch_rhythms();
    void describe_parts();
    bool sound(std::size_t message, const CanFrame& frame, Instant received);
    bool same_sender(std::size_t message, const CanFrame& frame, Instant received);
    bool counter_holds(std::size_t message, std::span<const std::uint8_t> data, Instant received);
    bool refuse(RejectCause cause);
    bool holds(const DbcPart& part, std::span<const std::uint8_t> data) const;
    void take(std::size_t part, std::span<const std::uint8_t> data, Instant received);
    void start_round_after_pause(Instant received);
    bool complete() const;
    bool overdue(const PartState& part, Instant now) const;
    ChannelFrame snapshot(Instant now);

    DbcMap map_;
    std::vector<CanIdMatch> wanted_;
    std::vector<MessageState> messages_;
    std::vector<PartState> parts_;
    std::optional<Instant> awaited_received_;  ///< the latest arrival of any awaited part
    bool told_failsafe_ = false;               ///< the last snapshot said it
    std::array<std::optional<Pulse>, kChannelCount> values_{};
    std::array<NamedCount, 8> rejected_{{{"length"},
                                         {"checksum"},
                                         {"repeated"},
                                         {"counter jump"},
                                         {"unconfirmed"},
                                         {"other sender"},
                                         {"no value"},
                                         {"wrong fixed"}}};
};

/// Writes all messages whose cycle has passed; one without a cycle time with every snapshot, and
/// one that tells of failsafe or lost frames as soon as that changes. In failsafe a channel with a
/// code for an error, or else for "not available", is sent as that; an absent channel as "not
/// available", else as an error, else as 1500 us.
/// Named values are converted to the unit of their signal where both units are known. While one of
/// a frame is missing or stale, it is sent as "not available"; without such a code the whole frame
/// is not sent.
class DbcEncoder final : public CanEncoder {
  public:
    explicit DbcEncoder(DbcMap map);

    bool uses_fd() const override;
    std::span<const CanIdMatch> sent() const override { return sent_; }
    void use(const ValueBoard& board) override;
    /// Those that have a signal without a code for absent ones.
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override {
        return needed_channels_;
    }
    bool marks_frame_lost() const override;
    void continue_from(const CanEncoder& before) override;
    std::size_t encode(const ChannelFrame& snapshot, Instant now,
                       std::span<CanFrame, kMostSnapshotFrames> frames) override;

  private:
    struct SentPart {
        bool ever = false;
        Instant next{};  ///< the end of its cycle
        bool failsafe = false;
        bool frame_lost = false;
        LinkCause cause = LinkCause::never_seen;
    };

    /// Where the number of a value comes from.
    struct Source {
        std::size_t index = 0;  ///< on the board
        UnitConversion conversion{};
    };

    bool due(std::size_t part, const ChannelFrame& snapshot, Instant now) const;
    void note_sent(std::size_t part, const ChannelFrame& snapshot, Instant now);
    bool write_values(std::size_t part, Instant now, std::span<std::uint8_t> data) const;
    /// Nothing while a value is missing that has no code for it.
    std::optional<CanFrame> make_frame(std::size_t part, const ChannelFrame& snapshot, Instant now);

    DbcMap map_;
    std::vector<CanIdMatch> sent_;
    std::vector<std::uint64_t> counters_;  ///< of each message
    std::vector<SentPart> sent_parts_;
    const ValueBoard* board_ = nullptr;
    /// Of each value of each part; nothing for a name that the board has not.
    std::vector<std::vector<std::optional<Source>>> sources_;
    Instant encoded_{};  ///< the last snapshot
    std::uint32_t needed_channels_ = 0;
};

}  // namespace tribus
