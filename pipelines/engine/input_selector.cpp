#include "pipelines/engine/input_selector.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

namespace tribus {
namespace {

/// Receivers pass on the same sticks some milliseconds apart, so they differ while a stick moves
/// fast.
constexpr Duration kDissentTime = std::chrono::milliseconds(500);
/// An input is outvoted only if at least this many inputs agree with the majority on every channel.
constexpr std::size_t kLeastAgreeing = 2;
/// Hysteresis of the handover channel at the boundary between two positions.
constexpr std::int32_t kHandoverSlackEighths = 25 * Pulse::kEighthsPerMicrosecond;

/// For this time an implausible frame is named beside what the input waits for.
constexpr Duration kImplausibleMemory = std::chrono::seconds(1);
/// For so long a loss says why the proof is not whole.
constexpr Duration kLossMemory = std::chrono::seconds(10);

/// Median of `values`, which it sorts. The mean of the middle two if their number is even.
Pulse middle_of(std::span<Pulse> values) {
    std::ranges::sort(values);
    const std::size_t half = values.size() / 2;
    if (values.size() % 2 == 1) {
        return values[half];
    }
    return Pulse::from_eighths((values[half - 1].eighths() + values[half].eighths()) / 2);
}

}  // namespace

InputSelector::InputSelector(SelectionSettings settings, Duration recover, Duration power_on)
    : settings_(std::move(settings)),
      recover_(recover),
      power_on_(power_on),
      only_one_(settings_.inputs.size() == 1 && settings_.mode != SelectionMode::median &&
                !settings_.handover),
      voters_(settings_.inputs.size()) {}

Duration InputSelector::proof(const Voter& voter, const LinkSupervisor& link) const {
    const Duration guard = voter.ever_served ? Duration::zero() : power_on_;
    return link.first_run() ? guard : std::max(guard, recover_);
}

bool InputSelector::is_trusted(const Voter& voter, const LinkSupervisor& link, Instant now,
                               bool bridging) const {
    const bool served = voter.served && voter.absences == link.absences();
    return (bridging && served) || link.has_proved(proof(voter, link), now);
}

/// Judges whether the input may be used, and notes that.
bool InputSelector::serves(Voter& voter, const LinkSupervisor& link, Instant now, Instant until,
                           bool bridging) const {
    voter.serves = is_trusted(voter, link, now, bridging) && link.alive(until);
    if (voter.serves) {
        voter.absences = link.absences();
        voter.ever_served = true;
    }
    return voter.serves;
}

bool InputSelector::could_use(std::size_t input, Instant now, Instant until,
                              std::span<const Input> inputs, bool bridging) const {
    const auto found = std::ranges::find(settings_.inputs, input);
    if (found == settings_.inputs.end()) {
        return false;
    }
    const Voter& voter = voters_[static_cast<std::size_t>(found - settings_.inputs.begin())];
    const LinkSupervisor& link = inputs[input].link();
    // Between two frames of the output, the latest selection counts.
    return (bridging && voter.serves && link.alive(now)) ||
           (is_trusted(voter, link, now, bridging) && link.alive(until));
}

bool InputSelector::take_only(Instant now, Instant until, const Input& input, bool bridging) {
    Voter& voter = voters_.front();
    if (!serves(voter, input.link(), now, until, bridging)) {
        return false;
    }
    voter.served = true;
    changed_over_ = follows_one() && std::exchange(control_removed_, false);
    place_ = 0;
    frame_ = input.control();
    alive_until_ = input.link().alive_until();
    return true;
}

void InputSelector::judge_service(Instant now, Instant until, std::span<const Input> inputs,
                                  bool bridging) {
    bool any = false;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        const LinkSupervisor& link = inputs[settings_.inputs[place]].link();
        any = serves(voters_[place], link, now, until, bridging) || any;
    }
    for (Voter& voter : voters_) {
        voter.served = any ? voter.serves : voter.served;
    }
}

void InputSelector::continue_from(const InputSelector& before, std::span<const InputCarry> carried,
                                  Instant latest_at) {
    selected_at_ = latest_at;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        const CarriedFrom from = carried[settings_.inputs[place]].from;
        const auto known = from ? std::ranges::find(before.settings_.inputs, *from)
                                : before.settings_.inputs.end();
        if (known == before.settings_.inputs.end()) {
            continue;
        }
        const auto place_before = static_cast<std::size_t>(known - before.settings_.inputs.begin());
        voters_[place] = before.voters_[place_before];
        // Only a vote could take it back.
        if (settings_.mode != SelectionMode::median) {
            voters_[place].outvoted = false;
            voters_[place].turning_since.reset();
        }
        place_ = before.place_ == place_before ? std::optional(place) : place_;
    }
    control_removed_ = before.place_ && !place_;
    const bool same_choice = settings_ == before.settings_;
    voted_ = before.voted_ && settings_.mode == SelectionMode::median;
    position_ = same_choice ? before.position_ : std::nullopt;
    frame_ = before.frame_;
    if (slew_limits_) {
        slew_limits_->start(frame_);
    }
    outvoted_count_ = before.outvoted_count_;
}

std::optional<std::size_t> InputSelector::chosen_by_a_person(std::span<const Input> inputs) {
    if (picked_) {
        return voters_[*picked_].serves ? picked_ : std::nullopt;
    }
    if (!settings_.handover) {
        return std::nullopt;
    }
    const auto [place, channel] = *settings_.handover;
    // In median mode, position 0 selects the median.
    const std::size_t unpicked = settings_.mode == SelectionMode::median ? 1 : 0;
    const auto pulse = control(place, inputs).channel(channel);
    if (!pulse || !voters_[place].serves) {
        position_.reset();
        return std::nullopt;
    }
    const auto position_at = [&](std::int32_t eighths) {
        const auto steps = static_cast<std::int32_t>(voters_.size() + unpicked);
        const std::int32_t travel = eighths - kSwitchOffPulse.eighths();
        const std::int32_t whole = kSwitchOnPulse.eighths() - kSwitchOffPulse.eighths();
        return static_cast<std::size_t>(std::clamp(travel * steps / whole, 0, steps - 1));
    };
    const std::int32_t eighths = pulse->eighths();
    const bool stays = position_ && position_at(eighths - kHandoverSlackEighths) <= *position_ &&
                       *position_ <= position_at(eighths + kHandoverSlackEighths);
    position_ = stays ? position_ : position_at(eighths);
    if (*position_ < unpicked || !voters_[*position_ - unpicked].serves) {
        return std::nullopt;
    }
    return *position_ - unpicked;
}

std::optional<std::size_t> InputSelector::first_serving() const {
    const auto first = std::ranges::find_if(
        voters_, [](const Voter& voter) { return voter.serves && !voter.outvoted; });
    return first == voters_.end()
               ? std::nullopt
               : std::optional(static_cast<std::size_t>(first - voters_.begin()));
}

std::optional<std::size_t> InputSelector::freshest(std::span<const Input> inputs) const {
    std::optional<std::size_t> best;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        if (voters_[place].serves &&
            (!best || control(place, inputs).received > control(*best, inputs).received)) {
            best = place;
        }
    }
    return best;
}

std::optional<std::size_t> InputSelector::choose(std::span<const Input> inputs) const {
    switch (settings_.mode) {
        case SelectionMode::sticky:
            return place_ && voters_[*place_].serves ? place_ : first_serving();
        case SelectionMode::freshest:
            return freshest(inputs);
        case SelectionMode::priority:
        case SelectionMode::median:
            break;
    }
    return first_serving();
}

[[gnu::noinline]] bool InputSelector::select_one(Instant now, Instant until,
                                                 std::span<const Input> inputs, bool bridging) {
    judge_service(now, until, inputs, bridging);
    const auto by_person = chosen_by_a_person(inputs);
    const auto place = by_person ? by_person : choose(inputs);
    if (!place) {
        selected_at_ = now;
        return false;
    }
    const bool voting = settings_.mode == SelectionMode::median && !by_person;
    const bool another = place_ && (voting != voted_ || (!voting && place != place_));
    changed_over_ = follows_one() && (another || std::exchange(control_removed_, false));
    place_ = place;
    voted_ = voting;
    alive_until_ = inputs[settings_.inputs[*place]].link().alive_until();
    if (voting) {
        vote(inputs);
        watch_dissent(now, inputs);
    } else {
        frame_ = control(*place, inputs);
    }
    if (slew_limits_) {
        keep_slews(!bridging, now);
    }
    return true;
}

bool InputSelector::votes(std::size_t place, bool any_fresh, std::span<const Input> inputs) const {
    const Voter& voter = voters_[place];
    return voter.serves && !voter.outvoted && !(any_fresh && control(place, inputs).frame_lost);
}

bool InputSelector::near(Pulse a, Pulse b) const {
    return std::abs(a.eighths() - b.eighths()) <= settings_.tolerance.eighths();
}

/// Decides each channel by the median. Frame-lost (old) values do not count while others are fresh.
void InputSelector::vote(std::span<const Input> inputs) {
    frame_ = control(*place_, inputs);
    bool any_fresh = false;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        const Instant until = inputs[settings_.inputs[place]].link().alive_until();
        alive_until_ = voters_[place].serves ? std::min(alive_until_, until) : alive_until_;
        any_fresh =
            any_fresh || (votes(place, false, inputs) && !control(place, inputs).frame_lost);
    }
    frame_.frame_lost = !any_fresh;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        std::array<Pulse, kMostPipelineInputs> values;
        std::size_t count = 0;
        for (std::size_t place = 0; place < voters_.size(); ++place) {
            const ChannelFrame& frame = control(place, inputs);
            if (votes(place, any_fresh, inputs) && frame.has(channel)) {
                values[count++] = frame.pulses()[channel];
            }
        }
        decide(channel, std::span(values).first(count));
    }
}

/// Decides one channel from the values of all inputs that vote, the preferred one first.
void InputSelector::decide(std::size_t channel, std::span<Pulse> values) {
    majority_[channel] = false;
    if (values.empty()) {
        frame_.remove(channel);
        return;
    }
    const bool undecided = values.size() == 2 && !near(values[0], values[1]);
    const Pulse decided = undecided ? values[0] : middle_of(values);
    frame_.set(channel, decided);
    const auto agree = static_cast<std::size_t>(
        std::ranges::count_if(values, [&](Pulse value) { return near(value, decided); }));
    majority_[channel] = values.size() > 2 && 2 * agree > values.size();
}

/// True if the frame differs from the majority on any channel. A channel without a majority does
/// not count: on a channel with each receiver's own signal strength no input is wrong.
bool InputSelector::dissents(const ChannelFrame& frame) const {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (majority_[channel] && frame.has(channel) &&
            !near(frame.pulses()[channel], frame_.pulses()[channel])) {
            return true;
        }
    }
    return false;
}

bool InputSelector::agrees(const ChannelFrame& frame) const {
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (frame.has(channel) && frame_.has(channel) &&
            !near(frame.pulses()[channel], frame_.pulses()[channel])) {
            return false;
        }
    }
    return true;
}

/// Whether any input may be outvoted. With fewer than two inputs that agree with the majority
/// everywhere (each agrees with another one on another channel), it is unknown which one is wrong,
/// and only the vote on each channel decides.
bool InputSelector::enough_inputs_agree(std::span<const Input> inputs) const {
    std::size_t agreeing = 0;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        const Voter& voter = voters_[place];
        const bool votes = voter.serves && !voter.outvoted;
        agreeing += votes && !dissents(control(place, inputs)) ? 1U : 0U;
    }
    return agreeing >= kLeastAgreeing;
}

void InputSelector::watch_dissent(Instant now, std::span<const Input> inputs) {
    const bool certain = enough_inputs_agree(inputs);
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        Voter& voter = voters_[place];
        const ChannelFrame& frame = control(place, inputs);
        const bool turning = voter.serves && (voter.outvoted ? agrees(frame) : dissents(frame));
        if (!turning) {
            voter.turning_since.reset();
            continue;
        }
        voter.turning_since = voter.turning_since.value_or(now);
        const Duration needed = voter.outvoted ? recover_ : kDissentTime;
        if (now - *voter.turning_since >= needed && (voter.outvoted || certain)) {
            voter.outvoted = !voter.outvoted;
            voter.turning_since.reset();
            outvoted_count_ += voter.outvoted ? 1U : 0U;
        }
    }
}

OutputWait InputSelector::wait_for(std::size_t place, Instant now, Instant until,
                                   const Input& input, bool bridging) const {
    const Voter& voter = voters_[place];
    const LinkSupervisor& link = input.link();
    OutputWait wait{
        .input = settings_.inputs[place],
        .link = link.state(now),
        .fault = input.fault(),
        .marked = link.marked_of_latest(),
        .latest = std::min<std::size_t>(input.counts().frames, LinkSupervisor::kRatioFrames)};
    if (link.implausible().frames > 0 && now - link.implausible().at < kImplausibleMemory) {
        wait.implausible = link.implausible();
    }
    if (now - input.latest_loss_at() < kLossMemory) {
        wait.loss = input.latest_loss();
        wait.loss_age = now - input.latest_loss_at();
    }
    const LinkRun run = link.run(now);
    const Duration needed = proof(voter, link);
    const bool trusted = is_trusted(voter, link, now, bridging);
    if (!link.alive(now)) {
        wait.awaited = Awaited::link;
    } else if (!trusted && run.good_frame_age > link.timeout()) {
        wait.awaited = Awaited::good_frame;
        wait.so_far = run.good_frame_age;
        wait.needed = link.timeout();
    } else if (!trusted && run.time < needed) {
        wait.awaited = Awaited::run_time;
        wait.so_far = run.time;
        wait.needed = needed;
    } else if (!trusted) {
        wait.awaited = Awaited::run_frames;
        wait.frames = run.frames;
        wait.needed_frames = LinkSupervisor::kProofFrames;
    } else if (!link.alive(until)) {
        wait.awaited = Awaited::good_frame;
        wait.so_far = run.good_frame_age;
        wait.needed = link.timeout() - (until - now);
    } else {
        wait.awaited = voter.outvoted ? Awaited::votes : Awaited::next_frame;
    }
    return wait;
}

OutputWait InputSelector::wait(Instant now, Instant until, std::span<const Input> inputs,
                               bool bridging) const {
    /// How far an input is from control: the less, the nearer.
    const auto distance = [](const OutputWait& wait) {
        const Duration left =
            wait.awaited == Awaited::run_time ? wait.needed - wait.so_far : Duration::zero();
        const int rank = wait.awaited == Awaited::link         ? 3
                         : wait.awaited == Awaited::good_frame ? 2
                         : wait.awaited == Awaited::votes      ? 1
                                                               : 0;
        return std::pair(rank, left);
    };
    std::optional<OutputWait> nearest;
    for (std::size_t place = 0; place < voters_.size(); ++place) {
        const OutputWait wait =
            wait_for(place, now, until, inputs[settings_.inputs[place]], bridging);
        if (!nearest || distance(wait) < distance(*nearest)) {
            nearest = wait;
        }
    }
    return nearest.value_or(OutputWait{});
}

}  // namespace tribus
