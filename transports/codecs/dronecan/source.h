#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/counter_watch.h"
#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan {

/// Whom is listened to.
struct SourceChoice {
    std::optional<NodeId> node{};  ///< absent: the first one that is heard
    /// Which one of several on its node, such as a battery; absent: likewise.
    std::optional<std::uint32_t> instance{};

    bool operator==(const SourceChoice&) const = default;
};

/// Of each message, while it is open whom to listen to: a node that sends only what cannot be read
/// must not keep the others out.
inline constexpr std::size_t kMostCandidates = 8;

/// The transfer ids of a node's messages, for `CounterWatch`: losses are told from old messages by
/// the time that passed. The specification counts a message at once, and forgets after 2 s.
inline constexpr CounterWatch::Limits kTransferOrder{.values = kMostTransferId + 1U,
                                                     .most_step = kMostTransferId,
                                                     .silence = std::chrono::seconds(2),
                                                     .proof = 0};

/// Holds on to one source: two that send the same must not be mixed. The first one of which a good
/// message is heard stays the one until none has come for as long as a node is counted as gone.
/// Pure.
class SourceWatch {
  public:
    /// NodeStatus of a node that is there comes at least so often (docs/protocols/can.md,
    /// "DroneCAN: nodes").
    static constexpr Duration kGone = std::chrono::seconds(3);

    explicit SourceWatch(SourceChoice choice) : choice_(choice) {}

    /// Whether it is worth putting the frames of that node together.
    bool may_be(NodeId source) const {
        return source != kNobody && (!choice_.node || source == *choice_.node);
    }
    /// Whether a message of that source would be listened to. To its frames, for they may be
    /// broken.
    bool would_listen_to(NodeId source, Instant at) const {
        return may_be(source) &&
               (source == current_ || current_ == kNobody || at - heard_ >= kGone);
    }
    /// To a good message of that source.
    bool listens_to(NodeId source, Instant at, std::uint32_t instance = 0) {
        if (!may_be(source) || (choice_.instance && instance != *choice_.instance)) {
            return false;
        }
        const bool the_same = source == current_ && instance == current_instance_;
        if (!the_same && current_ != kNobody && at - heard_ < kGone) {
            return false;
        }
        current_ = source;
        current_instance_ = instance;
        heard_ = at;
        return true;
    }
    /// kNobody: none yet.
    NodeId current() const { return choice_.node.value_or(current_); }

  private:
    SourceChoice choice_;
    NodeId current_ = kNobody;
    std::uint32_t current_instance_ = 0;
    Instant heard_{};
};

/// What a decoder of transfers refused, by cause.
class TransferRejects {
  public:
    void count(const TransferReceiver::Taken& taken) {
        ++counts_[cause_of(taken.fate)].count;
        counts_[kIncomplete].count += taken.broke_off ? 1U : 0U;
    }
    /// Whole, but not as its type describes it.
    void count_layout() { ++counts_[kLayout].count; }
    void count_other_source() { ++counts_[kOtherSource].count; }
    /// Whole and right, but its transfer id says that it is an old one, or of a second sender.
    void count_counter_jump() { ++counts_[kCounterJump].count; }
    std::span<const NamedCount> counts() const { return std::span(counts_).first(kUncounted); }

  private:
    enum Cause : std::size_t {
        kCrc,
        kIncomplete,
        kOutOfTurn,
        kRepeated,
        kLayout,
        kOtherSource,
        kCounterJump,
        kUncounted,
    };
    static Cause cause_of(FrameFate fate) {
        switch (fate) {
            case FrameFate::bad_crc:
                return kCrc;
            case FrameFate::out_of_turn:
                return kOutOfTurn;
            case FrameFate::repeated:
                return kRepeated;
            case FrameFate::too_long:
                return kLayout;
            case FrameFate::foreign:
            case FrameFate::unwanted:
            case FrameFate::taken:
            case FrameFate::complete:
            case FrameFate::crowded_out:
                break;
        }
        return kUncounted;
    }

    std::array<NamedCount, kUncounted + 1> counts_{{{"crc"},
                                                    {"incomplete"},
                                                    {"out of turn"},
                                                    {"repeated"},
                                                    {"layout"},
                                                    {"other source"},
                                                    {"counter jump"},
                                                    {"none"}}};
};

}  // namespace tribus::dronecan
