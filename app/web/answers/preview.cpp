#include "app/web/answers/preview.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/client/status_fields.h"
#include "app/web/answers/answers.h"
#include "core/channel_frame.h"
#include "pipelines/rules/channel_map.h"

namespace tribus::web {
namespace {

using NewestFrames = std::map<std::string, ChannelFrame>;
using StatusJson = nlohmann::json;

/// Frames of the inputs that are good.
NewestFrames newest_frames(const StatusJson& status) {
    NewestFrames frames;
    for (const StatusJson& input : status_fields::list(status, "inputs")) {
        if (status_fields::raw_text(input, "state") != "good") {
            continue;
        }
        ChannelFrame& frame = frames[status_fields::raw_text(input, "name")];
        std::size_t channel = 0;
        for (const StatusJson& pulse : status_fields::list(input, "channels")) {
            if (channel < kChannelCount && pulse.is_number()) {
                frame.set(channel, Pulse::from_fractional_microseconds(pulse.get<double>()));
            }
            ++channel;
        }
    }
    return frames;
}

/// The frame that the output sends; nothing if no pipeline of it has a good input.
std::optional<ChannelFrame> sent_by(const Configuration& configuration, const std::string& output,
                                    const NewestFrames& frames) {
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        const bool feeds = std::ranges::any_of(pipeline.outputs, [&](std::size_t index) {
            return configuration.outputs[index].name == output;
        });
        for (const std::size_t index : pipeline.selection.inputs) {
            const InputConfig& input = configuration.inputs[index];
            const auto newest = frames.find(input.name);
            if (feeds && newest != frames.end()) {
                return ChannelMap(pipeline.channels)
                    .apply(ChannelMap(input.channels).apply(newest->second, Instant()), Instant());
            }
        }
    }
    return std::nullopt;
}

Json pulse_json(const std::optional<Pulse>& pulse) {
    return pulse ? Json(pulse->whole_microseconds()) : Json(nullptr);
}

}  // namespace

Json channels_changed_by(const Configuration& running, const Configuration& draft,
                         const StatusJson& status) {
    const NewestFrames frames = newest_frames(status);
    Json outputs = Json::array();
    for (const OutputConfig& output : draft.outputs) {
        const auto now = sent_by(running, output.name, frames);
        const auto then = sent_by(draft, output.name, frames);
        Json channels = Json::array();
        for (std::size_t channel = 0; channel < kChannelCount && now && then; ++channel) {
            const auto before = now->channel(channel);
            const auto after = then->channel(channel);
            if (before != after) {
                channels.push_back({{"channel", channel + 1},
                                    {"now_us", pulse_json(before)},
                                    {"then_us", pulse_json(after)}});
            }
        }
        if (!channels.empty()) {
            outputs.push_back({{"output", output.name}, {"channels", std::move(channels)}});
        }
    }
    return outputs;
}

}  // namespace tribus::web
