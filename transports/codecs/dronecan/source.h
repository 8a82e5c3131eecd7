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

/// The source whose messages are accepted.
struct SourceChoice {
    std::optional<NodeId> node{};  ///< nothing: the first node that is received
    /// One of several on its node, such as a battery; nothing: the first one that is received.
    std::optional<std::uint32_t> instance{};

    bool operator==(const SourceChoice&) const = default;
};

/// Number of nodes whose messages are collected while no source is selected: a node that sends
/// unreadable messages must not exclude the others.
inline constexpr std::size_t kMostCandidates = 8;

/// Checks the transfer ids of a node. The time that passed distinguishes lost messages from old
/// ones. As in the specification, the first message is accepted at once, and ids are forgotten
/// after 2 s.
inline constexpr CounterWatch::Limits kTransferOrder{.values = kMostTransferId + 1U,
                                                     .most_step = kMostTransferId,
                                                     .silence = std::chrono::seconds(2),
                                                     .proof = 0};

/// Keeps one source, because messages of two sources must not be mixed. The first source with a
/// good message is kept until it has sent none for the time after which a node is gone. Pure;
/// thread-bound.
class SourceWatch {
  public:
    /// Longest silence of a node that is present (docs/protocols/can.md, "DroneCAN: nodes").
    static constexpr Duration kGone = std::chrono::seconds(3);

    explicit SourceWatch(SourceChoice choice) : choice_(choice) {}

    /// Whether frames of that node need to be collected.
    bool may_be(NodeId source) const {
        return source != kNobody && (!choice_.node || source == *choice_.node);
    }
    /// Whether a message of that source would be accepted. For single frames, which may be part of
    /// a broken message.
    bool would_accept(NodeId source, Instant at) const {
        return may_be(source) &&
               (source == current_ || current_ == kNobody || at - accepted_ >= kGone);
    }
    /// Whether a good message of that source is accepted. If so, that is the source from now on.
    bool accepts(NodeId source, Instant at, std::uint32_t instance = 0) {
        if (!may_be(source) || (choice_.instance && instance != *choice_.instance)) {
            return false;
        }
        const bool the_same = source == current_ && instance == current_instance_;
        if (!the_same && current_ != kNobody && at - accepted_ < kGone) {
            return false;
        }
        current_ = source;
        current_instance_ = instance;
        accepted_ = at;
        return true;
    }
    /// kNobody: none yet.
    NodeId current() const { return choice_.node.value_or(current_); }

  private:
    SourceChoice choice_;
    NodeId current_ = kNobody;
    std::uint32_t current_instance_ = 0;
    Instant accepted_{};
};

/// Counts the refused frames and messages of a decoder, by cause.
class TransferRejects {
  public:
    void count(const TransferReceiver::Taken& taken) {
        ++counts_[cause_of(taken.result)].count;
        counts_[kIncomplete].count += taken.broke_off ? 1U : 0U;
    }
    /// Complete, but not as its type describes it.
    void count_layout() { ++counts_[kLayout].count; }
    void count_other_source() { ++counts_[kOtherSource].count; }
    /// Complete and readable, but by its transfer id an old message, or one of a second sender.
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
    static Cause cause_of(FrameResult result) {
        switch (result) {
            case FrameResult::bad_crc:
                return kCrc;
            case FrameResult::out_of_turn:
                return kOutOfTurn;
            case FrameResult::repeated:
                return kRepeated;
            case FrameResult::too_long:
                return kLayout;
            case FrameResult::foreign:
            case FrameResult::unwanted:
            case FrameResult::taken:
            case FrameResult::complete:
            case FrameResult::crowded_out:
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
