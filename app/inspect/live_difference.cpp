#include "app/inspect/live_difference.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/protocol_use.h"
#include "app/client/status_fields.h"
#include "app/state_text/cause_text.h"
#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/schema/configured_names.h"
#include "core/can_frame.h"
#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {
namespace {

/// Longer than the slowest slew of real configurations takes.
constexpr Duration kSettled = std::chrono::seconds(30);
constexpr Instant kBegin{std::chrono::seconds(1)};

struct NullObserver final : StationObserver {
    void wrote(Station /*station*/, Instant /*at*/, const Transmission& /*sent*/) override {}
};

/// Settings for an encoder that sends to `input`. If an output has the setting "channels" and an
/// input does not, uses the number of channels that came.
SettingValues sender_settings(const InputConfig& input, const ChannelFrame& came) {
    SettingValues settings = input.settings;
    std::size_t count = kChannelCount;
    while (count > 1 && !came.has(count - 1)) {
        --count;
    }
    for (const Setting& setting : input.protocol->settings) {
        if (setting.key != "channels" || setting.scope != SettingScope::output) {
            continue;
        }
        for (; count <= kChannelCount; ++count) {
            if (const auto value = setting_from_text(setting, std::to_string(count))) {
                settings.set(setting.key, *value);
                break;
            }
        }
    }
    return settings;
}

/// Sends one frame again and again, like the transmitter of an input.
class Sender {
  public:
    /// If the protocol cannot encode these settings, sends nothing.
    Sender(const InputConfig& as, const LiveInput& live, std::size_t to)
        : frame_(live.frame), interval_(live.interval), to_(to) {
        const Protocol& protocol = *as.protocol;
        const SettingValues settings = sender_settings(as, live.frame);
        const bool means_something =
            protocol.check == nullptr || protocol.check(settings, SettingScope::output).empty();
        if (means_something && protocol.make_encoder != nullptr) {
            encoder_.emplace(protocol.make_encoder(settings));
        }
        if (interval_ <= Duration::zero()) {
            interval_ = usual_period({as.protocol, as.settings, as.port.line});
        }
    }

    Instant due() const { return due_; }
    void send(VirtualLoop& loop) {
        if (encoder_) {
            frame_.received = due_;
            const Transmission sent = encoder_->encode(frame_, due_);
            if (!sent.bytes().empty()) {
                loop.receive(input_station(to_), sent.bytes(), due_);
            }
            for (const CanFrame& frame : sent.can_frames()) {
                loop.receive(input_station(to_), frame, due_);
            }
        }
        due_ = later(due_, interval_);
    }

  private:
    std::optional<FrameEncoder> encoder_;
    ChannelFrame frame_;
    Duration interval_;
    std::size_t to_;
    Instant due_ = kBegin;
};

struct Settled {
    std::vector<bool> inputs_good;
    std::vector<OutputState> states;
    std::vector<ChannelFrame> frames;
};

/// Removes the rules for frozen sticks and for release: here sticks stand still on purpose, and
/// nobody can move the throttle.
Configuration without_guards(Configuration configuration) {
    for (InputConfig& input : configuration.inputs) {
        input.supervision.frozen = Duration::zero();
    }
    for (PipelineConfig& pipeline : configuration.pipelines) {
        for (FailsafeSettings& failsafe : pipeline.failsafe) {
            failsafe.release_when.reset();
        }
    }
    return configuration;
}

Settled settle(const Configuration& configuration, std::vector<Sender> senders) {
    const Configuration open = without_guards(configuration);
    const auto engine = build_engine(open);
    const auto values = build_value_engine(open, *engine);
    NullObserver observer;
    VirtualLoop loop(*engine, observer, kBegin, values.get());
    const Instant end = later(kBegin, kSettled);
    const auto sooner = [](const Sender& a, const Sender& b) { return a.due() < b.due(); };
    while (!senders.empty()) {
        const auto next = std::ranges::min_element(senders, sooner);
        if (next->due() >= end) {
            break;
        }
        next->send(loop);
    }
    loop.run_until(end);
    Settled settled;
    for (const Input& input : engine->inputs()) {
        settled.inputs_good.push_back(input.link().alive(end));
    }
    for (const Output& output : engine->outputs()) {
        settled.states.push_back(output.state(end));
        // No module answers here.
        settled.states.back().hearing = Hearing::not_awaited;
        settled.frames.push_back(output.latest());
    }
    return settled;
}

std::string pulse_text(const std::optional<Pulse>& pulse) {
    return pulse ? fmt::format("{} us", pulse->microseconds()) : "none";
}

std::string differing_channels(const ChannelFrame& before, const ChannelFrame& after) {
    std::string text;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (before.channel(channel) != after.channel(channel)) {
            text += fmt::format("  channel {}: {} now, then {}\n", channel + 1,
                                pulse_text(before.channel(channel)),
                                pulse_text(after.channel(channel)));
        }
    }
    return text;
}

std::string all_channels(const ChannelFrame& frame) {
    std::string text;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (frame.has(channel)) {
            text +=
                fmt::format("  channel {}: {}\n", channel + 1, pulse_text(frame.channel(channel)));
        }
    }
    return text;
}

/// True if `input` receives what the sender of the other input sends.
bool receives_from(const InputConfig& input, const InputConfig& sender) {
    return same_device(input.port, sender.port) && input.port.line == sender.port.line;
}

std::string heading(const Configuration& running,
                    const std::vector<std::optional<LiveInput>>& inputs, const Settled& before) {
    std::string text = "with the inputs as they are now";
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        text += fmt::format("{}{} {}", i == 0 ? " (" : ", ", running.inputs[i].name,
                            !inputs[i]              ? "not good"
                            : before.inputs_good[i] ? "good"
                                                    : "good, but cannot be reproduced here");
    }
    return text + (inputs.empty() ? ":\n" : "):\n");
}

}  // namespace

std::vector<std::optional<LiveInput>> live_inputs(const Configuration& running,
                                                  const nlohmann::json& status) {
    std::vector<std::optional<LiveInput>> inputs(running.inputs.size());
    for (const nlohmann::json& one : status_fields::list(status, "inputs")) {
        const auto place =
            std::ranges::find(running.inputs, status_fields::text(one, "name"), &InputConfig::name);
        if (place == running.inputs.end() || status_fields::text(one, "state") != "good") {
            continue;
        }
        LiveInput live;
        live.frame.frame_lost = false;
        live.frame.failsafe = false;
        live.interval = std::chrono::microseconds(status_fields::count(one, "interval_us"));
        const nlohmann::json& channels = status_fields::list(one, "channels");
        for (std::size_t channel = 0; channel < std::min(channels.size(), kChannelCount);
             ++channel) {
            if (channels[channel].is_number()) {
                live.frame.set(
                    channel, Pulse::from_fractional_microseconds(channels[channel].get<double>()));
            }
        }
        inputs[static_cast<std::size_t>(place - running.inputs.begin())] = live;
    }
    return inputs;
}

std::string live_difference(const Configuration& running, const Configuration& fresh,
                            const std::vector<std::optional<LiveInput>>& inputs) {
    const EngineCarry carry = plan_carry_over(running, fresh).engine;
    std::vector<Sender> to_running;
    std::vector<Sender> to_fresh;
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        if (inputs[i]) {
            to_running.emplace_back(running.inputs[i], *inputs[i], i);
        }
    }
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        for (std::size_t to = 0; inputs[i] && to < fresh.inputs.size(); ++to) {
            if (receives_from(fresh.inputs[to], running.inputs[i])) {
                to_fresh.emplace_back(running.inputs[i], *inputs[i], to);
            }
        }
    }
    const Settled before = settle(running, std::move(to_running));
    const Settled after = settle(fresh, std::move(to_fresh));
    std::string text = heading(running, inputs, before);
    const std::vector<std::string> names_before = configured_names(running.inputs);
    const std::vector<std::string> names_after = configured_names(fresh.inputs);
    const std::size_t heading_length = text.size();
    for (std::size_t i = 0; i < fresh.outputs.size(); ++i) {
        const std::string state_after = output_text(after.states[i], names_after);
        const auto from = carry.outputs[i].from;
        if (!from) {
            text += fmt::format("output {}: new, {}\n{}", fresh.outputs[i].name, state_after,
                                all_channels(after.frames[i]));
            continue;
        }
        const std::string state_before = output_text(before.states[*from], names_before);
        const std::string channels = differing_channels(before.frames[*from], after.frames[i]);
        if (state_before != state_after) {
            text += fmt::format("output {}: {} now, then {}\n{}", fresh.outputs[i].name,
                                state_before, state_after, channels);
        } else if (!channels.empty()) {
            text += fmt::format("output {}:\n{}", fresh.outputs[i].name, channels);
        }
    }
    return text.size() == heading_length ? text + "no output changes\n" : text;
}

}  // namespace tribus
