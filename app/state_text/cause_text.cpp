#include "app/state_text/cause_text.h"

#include <algorithm>
#include <bit>
#include <vector>

#include <fmt/format.h>

namespace tribus {
namespace {

std::string_view sign_text(RadioLossSign sign) {
    switch (sign) {
        case RadioLossSign::none:
            break;
        case RadioLossSign::failsafe_flag:
            return "the receiver says failsafe";
        case RadioLossSign::value_rule:
            return "a failsafe_when rule says so";
        case RadioLossSign::frame_lost_run:
            return "only frames marked frame-lost";
        case RadioLossSign::frame_lost_ratio:
            return "too many frames marked frame-lost";
    }
    return "";
}

std::string_view how_it_shows(const LinkState& state) {
    switch (state.cause) {
        case LinkCause::good:
        case LinkCause::never_seen:
            break;
        case LinkCause::wire_silent:
            return "no bytes any more";
        case LinkCause::garbled:
            return "bytes, but no frames";
        case LinkCause::radio_lost:
            return sign_text(state.sign);
        case LinkCause::stale:
            return "frames that do not change";
        case LinkCause::implausible:
            return "values that no transmitter sends";
        case LinkCause::channels_missing:
            return "channels that were there are missing";
        case LinkCause::no_key:
            return "messages without a key";
        case LinkCause::forged:
            return "messages that nobody with the key has made";
        case LinkCause::replayed:
            return "messages of the key's holder that are not new";
        case LinkCause::late:
            return "values that are too old when they come";
        case LinkCause::unproved:
            return "good frames that no output can use yet";
    }
    return "";
}

std::string text_without_hearing(const OutputState& state, std::span<const std::string> inputs) {
    switch (state.stage) {
        case OutputStage::failsafe:
            return state.forced           ? "in failsafe, forced"
                   : state.awaits_release ? "in failsafe until release_when is true"
                                          : "in failsafe";
        case OutputStage::holding:
            return state.marks_frame_lost
                       ? "holding the last values, marked frame-lost"
                       : "holding the last values, unmarked: its protocol has no frame-lost mark";
        case OutputStage::cannot_send:
            return fmt::format("cannot send: {}", obstacle_text(state.obstacle).fault);
        case OutputStage::control:
            break;
    }
    return state.input == kNoInput ? "under control"
                                   : fmt::format("under control of {}", inputs[state.input]);
}

std::string_view hearing_text(Hearing hearing) {
    switch (hearing) {
        case Hearing::not_awaited:
            break;
        case Hearing::heard:
            return "; hears its module";
        case Hearing::silent:
            return "; hears nothing of its module: check that it has power, and the wire from it "
                   "to the port's receiving pin";
        case Hearing::unreadable:
            return "; what comes back is no frame of a module: check \"baud\" here and in the "
                   "module, and whether the line is inverted";
    }
    return "";
}

}  // namespace

std::string as_word(std::string_view name) {
    std::string word(name);
    std::ranges::replace(word, ' ', '_');
    return word;
}

std::string in_words(std::string_view word) {
    std::string words(word);
    std::ranges::replace(words, '_', ' ');
    return words;
}

std::string_view output_state_word(OutputStage stage, bool sends) {
    switch (stage) {
        case OutputStage::control:
            return "control";
        case OutputStage::holding:
            return "hold";
        case OutputStage::cannot_send:
            return "cannot_send";
        case OutputStage::failsafe:
            break;
    }
    return sends ? "failsafe" : "silent";
}

ObstacleText obstacle_text(SendObstacle obstacle) {
    switch (obstacle) {
        case SendObstacle::none:
            break;
        case SendObstacle::device:
            return {"its device is gone", "its device, which is gone"};
        case SendObstacle::bus:
            return {"the bus takes nothing", "the bus, which takes nothing"};
        case SendObstacle::busy:
            return {"the port still has earlier frames",
                    "the port, which still has earlier frames"};
        case SendObstacle::receiver:
            return {"no receiver with the same key answers",
                    "an answer of a receiver with the same key"};
        case SendObstacle::epoch:
            return {"its epoch file could not be written",
                    "its epoch file, which could not be written"};
    }
    return {};
}

std::string output_text(const OutputState& state, std::span<const std::string> inputs) {
    const bool gone = state.stage == OutputStage::cannot_send;
    return text_without_hearing(state, inputs) +
           std::string(gone ? "" : hearing_text(state.hearing));
}

std::string by_preset_text(std::uint32_t channels) {
    const bool one = std::popcount(channels) == 1;
    std::vector<int> numbers;
    for (; channels != 0; channels &= channels - 1) {
        numbers.push_back(std::countr_zero(channels) + 1);
    }
    return fmt::format(
        "channel{} {} {}", one ? "" : "s", fmt::join(numbers, ", "),
        one ? "sends its preset: the channel that it is mapped from is absent"
            : "send their presets: the channels that they are mapped from are absent");
}

std::string implausible_text(const ImplausibleFrames& implausible) {
    const std::size_t channel = implausible.channel + 1;
    if (!implausible.plausible) {
        return fmt::format("channel {} has the raw value 0, which means \"no value\"", channel);
    }
    return fmt::format("channel {} is at {} us, plausible are {} to {} us", channel,
                       implausible.pulse.microseconds(), implausible.plausible->low.microseconds(),
                       implausible.plausible->high.microseconds());
}

std::string cause_text(const LinkState& state, const ImplausibleFrames& implausible,
                       std::string_view fault) {
    const bool named = state.cause == LinkCause::implausible && implausible.frames > 0;
    const std::string shown = named           ? implausible_text(implausible)
                              : fault.empty() ? std::string(how_it_shows(state))
                                              : std::string(fault);
    return shown.empty() ? std::string(name_of(state.cause))
                         : fmt::format("{} ({})", name_of(state.cause), shown);
}

}  // namespace tribus
