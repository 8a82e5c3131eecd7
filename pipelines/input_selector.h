#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/carry_over.h"
#include "pipelines/input.h"
#include "pipelines/settings.h"

namespace tribus {

/// Chooses which of several inputs controls an output, or makes one of all. Thread-bound; no
/// allocation after construction.
///
/// An input that was lost must have shown an unbroken run of good frames before it serves again,
/// except where the output has bridged the loss; so must one that was never good, for as long as
/// the guard at power-on asks. One that was outvoted serves no median, not even alone.
class InputSelector {
  public:
    /// `recover`: an unbroken run of good frames this long before an input that was lost serves
    /// again; `power_on`: the same for one that was never good before.
    InputSelector(SelectionSettings settings, Duration recover, Duration power_on);

    /// Decides at `now` for a frame that speaks until `until`. `bridging`: the output has not been
    /// in failsafe since the latest choice. False if no input serves.
    bool select(Instant now, Instant until, std::span<const Input> inputs, bool bridging);

    /// Goes on as `before`, whose inputs `carried` gives for each input of the engine: an input
    /// that was trusted stays so. One that is new must earn that, and one that is not there any
    /// more has lost control.
    void continue_from(const InputSelector& before, std::span<const InputCarry> carried);

    /// Indices of all inputs that may be chosen, the preferred first.
    std::span<const std::size_t> inputs() const { return settings_.inputs; }
    /// The input that the latest choice follows: of several that are joined, the preferred one.
    std::optional<std::size_t> current() const {
        return place_ ? std::optional(settings_.inputs[*place_]) : std::nullopt;
    }
    /// It keeps to an input for a while.
    bool follows_one() const { return settings_.mode != SelectionMode::freshest; }
    /// The values of the latest choice.
    const ChannelFrame& frame() const { return frame_; }
    /// The latest choice follows another input than the one before, and not by a vote both times.
    bool changed_over() const { return changed_over_; }
    /// Whether the others have outvoted the input at that place of `inputs()` for so long that it
    /// is no accident. Only of medians.
    bool outvoted(std::size_t place) const { return voters_[place].outvoted; }
    /// How often that began.
    std::uint64_t outvoted_count() const { return outvoted_count_; }

    /// A person has chosen the input at that place by other means than a channel; nothing: nobody.
    void pick(std::optional<std::size_t> place) { picked_ = place; }

  private:
    struct Voter {
        bool serves = false;
        /// It did when last any did.
        bool served = false;
        bool ever_served = false;
        /// Of its link, when it last served.
        std::uint64_t absences = 0;
        bool outvoted = false;
        /// Since when it disagrees with the vote, or agrees again.
        std::optional<Instant> turning_since{};
    };

    /// The unbroken run that it must have shown.
    Duration proof(const Voter& voter, const LinkSupervisor& link) const;
    void judge_service(Instant now, Instant until, std::span<const Input> inputs, bool bridging);
    std::optional<std::size_t> chosen_by_a_person(std::span<const Input> inputs);
    std::optional<std::size_t> choose(std::span<const Input> inputs) const;
    std::optional<std::size_t> freshest(std::span<const Input> inputs) const;
    std::optional<std::size_t> first_serving() const;
    bool votes(std::size_t place, bool any_fresh, std::span<const Input> inputs) const;
    bool near(Pulse a, Pulse b) const;
    void vote(std::span<const Input> inputs);
    void decide(std::size_t channel, std::span<Pulse> values);
    void watch_dissent(Instant now, std::span<const Input> inputs);
    bool has_witnesses(std::span<const Input> inputs) const;
    bool dissents(const ChannelFrame& frame) const;
    bool agrees(const ChannelFrame& frame) const;
    const ChannelFrame& control(std::size_t place, std::span<const Input> inputs) const {
        return inputs[settings_.inputs[place]].control();
    }

    SelectionSettings settings_;
    Duration recover_;
    Duration power_on_;
    std::vector<Voter> voters_;
    std::optional<std::size_t> place_;
    bool voted_ = false;
    std::optional<std::size_t> picked_;
    std::optional<std::size_t> position_;  ///< of the handover channel, latest
    bool changed_over_ = false;
    /// The input that was in control is not among the inputs any more.
    bool bereft_ = false;
    ChannelFrame frame_;
    /// Channels on which most voters of three or more agree.
    std::bitset<kChannelCount> majority_;
    std::uint64_t outvoted_count_ = 0;
};

}  // namespace tribus
