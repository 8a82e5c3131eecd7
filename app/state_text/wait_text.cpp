#include "app/state_text/wait_text.h"

#include <fmt/format.h>

#include "app/state_text/cause_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

using namespace std::chrono_literals;

double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// "0.2 of 0.5 s". What is not over is never told as whole.
std::string part_of(Duration so_far, Duration needed) {
    constexpr Duration kShort = std::chrono::milliseconds(300);
    constexpr std::int64_t kMsPerSecond = 1000;
    const double whole =
        static_cast<double>(std::chrono::round<std::chrono::milliseconds>(needed).count()) /
        kMsPerSecond;
    const Duration step = needed < kShort ? 10ms : 100ms;
    return fmt::format("{:.{}f} of {} s", seconds(so_far / step * step), needed < kShort ? 2 : 1,
                       whole);
}

std::string milliseconds(Duration duration) {
    return fmt::format("{} ms", std::chrono::round<std::chrono::milliseconds>(duration).count());
}

/// Names the frames of the input that brought no news, and its latest loss.
std::string trouble_text(const OutputWait& wait) {
    std::string text;
    if (wait.marked > 0) {
        text += fmt::format("; {} of its latest {} marked frame-lost", wait.marked,
                            counted(wait.latest, "frame"));
    }
    if (wait.implausible) {
        text += fmt::format("; implausible frames: {}", implausible_text(*wait.implausible));
    }
    if (wait.loss.cause != LinkCause::good) {
        text +=
            fmt::format("; lost {:.1f} s ago: {}", seconds(wait.loss_age), cause_text(wait.loss));
    }
    return text;
}

std::string release_text(const OutputWait& wait) {
    const ValueRule& rule = wait.release_when;
    std::string limits;
    const auto add = [&limits](const std::string& limit) {
        limits += (limits.empty() ? "" : " or ") + limit;
    };
    if (rule.below) {
        add(fmt::format("below {} us", rule.below->microseconds()));
    }
    if (rule.above) {
        add(fmt::format("above {} us", rule.above->microseconds()));
    }
    if (rule.between) {
        add(fmt::format("from {} to {} us", rule.between->low.microseconds(),
                        rule.between->high.microseconds()));
    }
    return fmt::format(
        "release_when: channel {} {}; it is {}", rule.channel + 1, limits,
        wait.pulse ? fmt::format("at {} us", wait.pulse->microseconds()) : std::string("absent"));
}

/// Tells why the input that the output waits for gives no control.
std::string lack_text(const OutputWait& wait) {
    switch (wait.awaited) {
        case Awaited::link:
            return cause_text(wait.link, wait.implausible.value_or(ImplausibleFrames{}),
                              wait.fault.view());
        case Awaited::good_frame:
            return fmt::format("a good frame, the latest is {} old of at most {}",
                               milliseconds(wait.so_far), milliseconds(wait.needed)) +
                   trouble_text(wait);
        case Awaited::run_time:
            return "good for " + part_of(wait.so_far, wait.needed) + trouble_text(wait);
        case Awaited::run_frames:
            return fmt::format("{} of {} good frames", wait.frames, wait.needed_frames) +
                   trouble_text(wait);
        case Awaited::votes:
            return "outvoted by the others";
        default:
            return "";
    }
}

}  // namespace

std::vector<std::string> input_names(const Configuration& configuration) {
    std::vector<std::string> names;
    for (const InputConfig& input : configuration.inputs) {
        names.push_back(input.name);
    }
    return names;
}

std::string wait_text(const OutputState& state, const OutputWait& wait,
                      std::span<const std::string> inputs) {
    if (state.stage == OutputStage::cannot_send) {
        return std::string(obstacle_text(state.obstacle).awaited);
    }
    switch (wait.awaited) {
        case Awaited::nothing:
            return "";
        case Awaited::next_frame:
            return "its next frame";
        case Awaited::release:
            return release_text(wait);
        case Awaited::line:
            return "the GPIO line that forces failsafe";
        case Awaited::other_node:
            return "another node to stop sending with its CAN ids";
        case Awaited::after_force:
            return part_of(wait.so_far, wait.needed) + " after failsafe was forced";
        case Awaited::end:
            return "the end of the program";
        default:
            return fmt::format("{}: {}", inputs[wait.input.value_or(0)], lack_text(wait));
    }
}

std::string stage_text(const OutputState& state, std::span<const std::string> inputs) {
    OutputState stage = state;
    stage.forced = false;
    stage.awaits_release = false;
    return output_text(stage, inputs);
}

std::string output_sentence(const OutputState& state, const OutputWait& wait,
                            std::span<const std::string> inputs) {
    if (state.stage == OutputStage::cannot_send || wait.awaited == Awaited::nothing) {
        return output_text(state, inputs);
    }
    return fmt::format("{}; waits for {}", stage_text(state, inputs),
                       wait_text(state, wait, inputs));
}

std::string duration_text(Duration duration) {
    using namespace std::chrono;
    if (duration < 1s) {
        return milliseconds(duration);
    }
    if (duration < 1min) {
        return fmt::format("{:.1f} s", seconds(duration));
    }
    const auto whole = floor<std::chrono::seconds>(duration).count();
    return duration < 1h ? fmt::format("{} min {} s", whole / 60, whole % 60)
                         : fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

std::string wait_key(const OutputWait& wait, std::span<const std::string> inputs) {
    if (wait.awaited == Awaited::nothing) {
        return "";
    }
    return fmt::format("{} {} {} {}", static_cast<int>(wait.awaited), name_of(wait.link.cause),
                       static_cast<int>(wait.link.sign),
                       wait.input ? inputs[*wait.input] : std::string());
}

const std::string& WaitWatch::look(const std::string& key, bool state_changed, Instant now) {
    if (key == told_) {
        differs_since_.reset();
        return told_;
    }
    differs_since_ = differs_since_.value_or(now);
    if (state_changed || now - *differs_since_ >= kPatience) {
        told_ = key;
        differs_since_.reset();
    }
    return told_;
}

}  // namespace tribus
