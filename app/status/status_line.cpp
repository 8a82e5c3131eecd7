#include "app/status/status_line.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"

namespace tribus {
namespace {

/// Upper limit in bytes; `systemctl status` shows one line, the log has everything.
constexpr std::size_t kLongestStatus = 400;

std::string for_how_long(Duration time) {
    struct Step {
        std::chrono::seconds from;
        std::string_view text;
    };
    using std::chrono::hours;
    using std::chrono::minutes;
    using std::chrono::seconds;
    constexpr std::array<Step, 8> kSteps{{{hours(24), "a day"},
                                          {hours(1), "an hour"},
                                          {minutes(10), "10 min"},
                                          {minutes(1), "1 min"},
                                          {seconds(30), "30 s"},
                                          {seconds(10), "10 s"},
                                          {seconds(3), "3 s"},
                                          {seconds(1), "1 s"}}};
    for (const Step& step : kSteps) {
        if (time >= step.from) {
            return fmt::format(" for more than {}", step.text);
        }
    }
    return "";
}

int urgency(OutputStage stage) {
    switch (stage) {
        case OutputStage::cannot_send:
        case OutputStage::failsafe:
            return 0;
        case OutputStage::holding:
            return 1;
        case OutputStage::control:
            break;
    }
    return 2;
}

/// Names come from the user and may contain anything; a line feed would end the line.
std::string one_line(std::string text) {
    std::ranges::replace_if(
        text, [](char byte) { return static_cast<unsigned char>(byte) < ' '; }, ' ');
    return text;
}

std::string joined(const std::vector<std::string>& parts) {
    std::string text;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (text.size() + parts[i].size() > kLongestStatus) {
            return text + fmt::format("; and {} more", parts.size() - i);
        }
        text += (text.empty() ? "" : "; ") + parts[i];
    }
    return text.empty() ? "running" : text;
}

/// A lost input has its own part of the line.
std::string said_of(const OutputStatus& output, std::span<const std::string> input_names,
                    Instant now) {
    if (output.state.stage == OutputStage::control) {
        return output_text(output.state, input_names);
    }
    const bool published = output.stage_since != Instant{};
    const std::string how_long =
        for_how_long(published ? now - output.stage_since : Duration::zero());
    const Awaited awaited = output.wait.awaited;
    if (awaited == Awaited::nothing || awaited == Awaited::link) {
        return output_text(output.state, input_names) + how_long;
    }
    return fmt::format("{}{}; waits for {}", stage_text(output.state, input_names), how_long,
                       wait_text(output.state, output.wait, input_names));
}

}  // namespace

std::string status_line(const Configuration& configuration, std::span<const InputStatus> inputs,
                        std::span<const OutputStatus> outputs, Instant figures_at, Instant now) {
    const std::vector<std::string> names = input_names(configuration);
    std::vector<std::pair<int, std::string>> parts;
    if (figures_at != Instant{} && now - figures_at > kFigureLife) {
        parts.emplace_back(-1, "the data thread stands still: what follows is old");
    }
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        parts.emplace_back(
            2 * urgency(outputs[i].state.stage),
            fmt::format("{}: {}", configuration.outputs[i].name, said_of(outputs[i], names, now)));
    }
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        const bool good = inputs[i].state.cause == LinkCause::good;
        parts.emplace_back(good ? 5 : 1,
                           fmt::format("{}: {}", names[i],
                                       cause_text(inputs[i].state, inputs[i].implausible,
                                                  inputs[i].fault.view())));
    }
    std::ranges::stable_sort(parts, {}, [](const auto& part) { return part.first; });
    std::vector<std::string> texts;
    texts.reserve(parts.size());
    for (auto& part : parts) {
        texts.push_back(one_line(std::move(part.second)));
    }
    return joined(texts);
}

}  // namespace tribus
