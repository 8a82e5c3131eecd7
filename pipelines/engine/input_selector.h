#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/input.h"
#include "pipelines/engine/output_wait.h"
#include "pipelines/rules/settings.h"
#include "pipelines/rules/slew_limits.h"

namespace tribus {

/// Selects the input that controls an output, or combines all inputs. Thread-bound. No allocation
/// after construction.
///
/// An input that was lost gets control again after a run of good frames (LinkSupervisor) for
/// `recover`, unless the output is still holding values. An input that was never good needs
/// `power_on` instead. An outvoted input is not used in median mode, not even as the only one.
class InputSelector {
  public:
    /// `recover`: length of the run of good frames before a lost input is used again. `power_on`:
    /// the same for an input that was never good before.
    InputSelector(SelectionSettings settings, Duration recover, Duration power_on);

    /// Selects at `now` for a frame that is valid until `until`. `bridging`: the output has not
    /// been in failsafe since the latest selection. Returns false if no input can be used.
    bool select(Instant now, Instant until, std::span<const Input> inputs, bool bridging) {
        return only_one_ ? take_only(now, until, inputs[settings_.inputs.front()], bridging)
                         : select_one(now, until, inputs, bridging);
    }

    /// What the input that is nearest to control lacks at `now`, for a selection as above.
    OutputWait wait(Instant now, Instant until, std::span<const Input> inputs, bool bridging) const;
    /// Whether a selection at `now` could use the input with that index of the engine, if nobody
    /// has outvoted it. True for an input that is not one of `inputs()`.
    bool could_use(std::size_t input, Instant now, Instant until, std::span<const Input> inputs,
                   bool bridging) const;

    /// Takes the slews in the maps of its inputs, of the engine's `inputs`. Call once, at the
    /// start.
    void take_slews(std::span<const Input> inputs);

    /// Takes over the state of `before`. `carried` gives, for each input of the engine, the input
    /// before from which it continues. Such an input stays trusted; a new one has to earn trust. An
    /// input in control that was removed counts as lost. `latest_at`: of the output's latest frame.
    void continue_from(const InputSelector& before, std::span<const InputCarry> carried,
                       Instant latest_at);

    /// Indices of all inputs that may be selected, the preferred one first.
    std::span<const std::size_t> inputs() const { return settings_.inputs; }
    /// Index of the input that the latest selection follows. In median mode: the preferred input
    /// that is used.
    std::optional<std::size_t> current() const {
        return place_ ? std::optional(settings_.inputs[*place_]) : std::nullopt;
    }
    /// True if the mode keeps one input in control for longer than a frame.
    bool follows_one() const { return settings_.mode != SelectionMode::freshest; }
    /// The values of the latest selection.
    const ChannelFrame& frame() const { return frame_; }
    /// Calls `visit` with what the sticks say, a frame without the slews of inputs: of the selected
    /// input or, in a vote, of each that votes. Without slews it is `frame()`. For the latest
    /// selection, of `inputs` of the engine.
    template <class Visitor>
    void for_each_aim(std::span<const Input> inputs, Visitor visit) const {
        if (!slew_limits_) {
            visit(frame_);
            return;
        }
        for (std::size_t place = 0; place < voters_.size(); ++place) {
            if (voted_ ? votes(place, !frame_.frame_lost, inputs) : place == place_) {
                visit(inputs[settings_.inputs[place]].aim());
            }
        }
    }
    /// Until when that frame counts, and each that it is made from, if no other frame comes.
    Instant alive_until() const { return alive_until_; }
    /// True if the latest selection took control from one input to another. A change inside a
    /// median does not count.
    bool changed_over() const { return changed_over_; }
    /// Whether the input at that index of `inputs()` has been outvoted. Median mode only.
    bool outvoted(std::size_t place) const { return voters_[place].outvoted; }
    /// How often an input became outvoted.
    std::uint64_t outvoted_count() const { return outvoted_count_; }

    /// Selects the input at that index of `inputs()` by other means than a channel (a GPIO line).
    /// `nullopt`: none.
    void pick(std::optional<std::size_t> place) { picked_ = place; }

  private:
    struct Voter {
        bool serves = false;
        /// It could be used at the latest selection at which any input could.
        bool served = false;
        bool ever_served = false;
        /// `LinkSupervisor::absences()` when it was last used.
        std::uint64_t absences = 0;
        bool outvoted = false;
        /// Since when it has disagreed with the median or, if outvoted, agreed with it again.
        std::optional<Instant> turning_since{};
    };

    bool select_one(Instant now, Instant until, std::span<const Input> inputs, bool bridging);
    void keep_slews(bool anew, Instant now);
    bool take_only(Instant now, Instant until, const Input& input, bool bridging);
    /// Required length of the run of good frames.
    Duration proof(const Voter& voter, const LinkSupervisor& link) const;
    bool is_trusted(const Voter& voter, const LinkSupervisor& link, Instant now,
                    bool bridging) const;
    bool serves(Voter& voter, const LinkSupervisor& link, Instant now, Instant until,
                bool bridging) const;
    OutputWait wait_for(std::size_t place, Instant now, Instant until, const Input& input,
                        bool bridging) const;
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
    bool enough_inputs_agree(std::span<const Input> inputs) const;
    bool dissents(const ChannelFrame& frame) const;
    bool agrees(const ChannelFrame& frame) const;
    const ChannelFrame& control(std::size_t place, std::span<const Input> inputs) const {
        return inputs[settings_.inputs[place]].control();
    }

    SelectionSettings settings_;
    Duration recover_;
    Duration power_on_;
    /// There is nothing to choose: one input, whose values are used as they are. With slews it
    /// takes the way of several inputs, so that the usual way costs nothing more.
    bool only_one_;
    std::vector<Voter> voters_;
    std::optional<std::size_t> place_;
    bool voted_ = false;
    std::optional<std::size_t> picked_;
    std::optional<std::size_t> position_;  ///< latest position of the handover channel
    bool changed_over_ = false;
    /// The input in control was removed from the configuration.
    bool control_removed_ = false;
    ChannelFrame frame_;
    Instant alive_until_{};
    /// Channels on which a majority of three or more inputs agrees.
    std::bitset<kChannelCount> majority_;
    std::uint64_t outvoted_count_ = 0;
    /// Null if no map of an input has a slew.
    std::unique_ptr<SlewLimits> slew_limits_;
    /// Of the latest selection. Only known while there are slews.
    Instant selected_at_{};
};

}  // namespace tribus
