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
#include "transports/codecs/two_sender_watch.h"

/// RC channels in the messages of the user's own DBC file, both directions (docs/protocols/can.md,
/// "DBC files").
namespace tribus {

extern const Protocol kDbcProtocol;

/// Combines the latest frames of all mapped messages into snapshots. Thread-bound.
///
/// A snapshot is complete when each awaited part has arrived since the snapshot before. The awaited
/// parts are those with channels whose message is about as fast as the fastest of them, or has no
/// known cycle time. `received` is the arrival of the oldest awaited part. If senders send in
/// bursts, the parts of one snapshot are those of one burst.
/// Other parts (a heartbeat, a status, slow channels) are not awaited, but if one of them is
/// missing for three of its cycles, or for 500 ms without a known cycle, the snapshot is marked
/// failsafe. It is also marked failsafe if a fixed signal has another value, or a channel that is
/// not optional has no value: a code, or outside the range of the file. The first such frame gives
/// a snapshot at once, without the other parts.
///
/// Refuses frames with a wrong length or checksum; frames of another J1939 source than within the
/// second before, if the map allows any source; frames whose counter does not change or advances by
/// more than 3; and, with a counter, the frames until it has advanced correctly twice in a row:
/// after the start, a jump, or silence. After a jump that came too soon it must go through its
/// whole range (`CounterWatch`). This excludes a sender that hangs, a second sender, and old frames
/// in a ring. Two senders of a message without a counter cannot be told apart; `two_senders`
/// reports them.
class DbcDecoder final : public CanDecoder {
  public:
    explicit DbcDecoder(DbcMap map);

    bool uses_fd() const override;
    std::span<const CanIdMatch> wanted() const override { return wanted_; }
    std::optional<ChannelFrame> next(const CanFrame& frame, Instant received) override;
    std::span<const NamedCount> rejected() const override { return rejected_; }
    bool two_senders() const override;
    std::size_t write_fault(std::span<char> text) const override;

  private:
    enum RejectCause : std::size_t {
        kLength,
        kChecksum,
        kRepeated,
        kCounterJump,
        kUnconfirmed,
        kOtherSender,
        kNoValue,     ///< an accepted frame, but a channel that is not optional has no value
        kWrongFixed,  ///< an accepted frame, but a fixed signal has another value
    };

    struct MessageState {
        std::optional<Instant> received;
        std::uint32_t id = 0;
        std::optional<std::uint8_t> wrong_length;       ///< of its latest frame
        std::optional<CounterWatch> watch;              ///< only for a message with a counter
        std::optional<TwoSenderWatch> senders;          ///< only for a message without counter and
                                                        ///< without pages
        std::array<std::uint8_t, kMostFdBytes> data{};  ///< of its latest frame
    };
    struct PartState {
        bool awaited = true;
        Duration longest_absence{};  ///< limit for a part that is not awaited
        bool fresh = false;          ///< arrived since the latest snapshot
        std::optional<Instant> received{};
        Duration interval{};  ///< between its latest two arrivals; zero: unknown
        bool failsafe = false;
        bool frame_lost = false;
        bool may_be_absent = false;                 ///< it has nothing but optional channels
        const DbcChannel* without_value = nullptr;  ///< that made its latest frame failsafe
        const DbcFixed* wrong_fixed = nullptr;      ///< the same
        std::uint64_t bits = 0;                     ///< of that signal
    };

    void watch_counters();
    void watch_senders();
    void describe_parts();
    bool valid(std::size_t message, const CanFrame& frame, Instant received);
    bool same_sender(std::size_t message, const CanFrame& frame, Instant received);
    bool counter_holds(std::size_t message, std::span<const std::uint8_t> data, Instant received);
    bool refuse(RejectCause cause);
    bool holds(const DbcPart& part, std::span<const std::uint8_t> data) const;
    void take(std::size_t part, std::span<const std::uint8_t> data, Instant received);
    void start_round_after_pause(Instant received);
    bool complete() const;
    bool overdue(const PartState& part, Instant now) const;
    void forget_old_faults(std::size_t message, Instant now);
    void judge_fixed(const DbcPart& part, std::span<const std::uint8_t> data, PartState& state);
    void take_channels(const DbcPart& part, std::span<const std::uint8_t> data, PartState& state);
    ChannelFrame snapshot(Instant now);

    DbcMap map_;
    std::vector<CanIdMatch> wanted_;
    std::vector<MessageState> messages_;
    std::vector<PartState> parts_;
    std::optional<Instant> awaited_received_;  ///< the latest arrival of any awaited part
    std::optional<std::size_t> absent_part_;   ///< overdue when the latest snapshot was made
    bool reported_failsafe_ = false;           ///< whether the latest snapshot was marked failsafe
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

/// Writes all messages whose cycle has passed. A message without a cycle time is written with every
/// snapshot, and a message with a failsafe or frame-lost flag as soon as that changes. In failsafe,
/// a channel is sent as the code for an error, else as that for "not available", if it has one. An
/// absent channel is sent as "not available", else as an error, else as 1500 us.
/// Named values are converted to the unit of their signal if both units are known. While a value is
/// missing or stale, it is sent as "not available"; without such a code, the frame is not sent.
/// Thread-bound.
class DbcEncoder final : public CanEncoder {
  public:
    explicit DbcEncoder(DbcMap map);

    bool uses_fd() const override;
    std::span<const CanIdMatch> sent() const override { return sent_; }
    void use(const ValueBoard& board) override;
    /// The channels with a signal that has no code for an absent channel.
    std::uint32_t needed_channels(const ChannelFrame& /*snapshot*/) const override {
        return needed_channels_;
    }
    bool marks_frame_lost() const override;
    void continue_from(const Encoder& before) override;
    std::size_t write(const ChannelFrame& snapshot, std::span<CanFrame, kMostSnapshotFrames> frames,
                      Instant now) override;

  private:
    struct SentPart {
        bool ever = false;
        Instant next{};  ///< the end of its cycle
        bool failsafe = false;
        bool frame_lost = false;
        LinkCause cause = LinkCause::never_seen;
    };

    /// Source of the number of a value.
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
    std::vector<std::uint64_t> counters_;  ///< one for each message
    std::vector<SentPart> sent_parts_;
    const ValueBoard* board_ = nullptr;
    /// For each value of each part; nothing for a name that is not on the board.
    std::vector<std::vector<std::optional<Source>>> sources_;
    Instant encoded_{};  ///< when the latest snapshot was encoded
    std::uint32_t needed_channels_ = 0;
};

}  // namespace tribus
