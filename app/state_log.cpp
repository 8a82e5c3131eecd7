#include "app/state_log.h"

#include <string_view>

#include <spdlog/spdlog.h>

#include "app/log_limit.h"

namespace tribus {
namespace {

/// A receiver that is on has sent hundreds of frames by then.
constexpr Duration kFirstFrameWait = std::chrono::seconds(3);

std::string_view stage_text(OutputStage stage) {
    switch (stage) {
        case OutputStage::failsafe:
            return "in failsafe";
        case OutputStage::holding:
            return "holding the last values, marked frame-lost";
        case OutputStage::control:
            return "under control";
    }
    return "";
}

}  // namespace

StateLog::StateLog(const Appliance& appliance, Instant start) : start_(start), can_(appliance) {
    const Configuration& configuration = appliance.configuration();
    can_.start(appliance);
    for (const InputConfig& input : configuration.inputs) {
        const bool on_can = input.port.link == LinkKind::can;
        inputs_.push_back({on_can, false, false, log_limit()});
    }
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        outputs_.push_back({OutputStage::failsafe, 0, 0, log_limit()});
    }
}

void StateLog::look_at_input(const std::string& name, const InputStatus& status,
                             InputMemory& memory, Instant now) {
    if (status.alive == memory.alive) {
        return;
    }
    memory.alive = status.alive;
    const auto swallowed = memory.limit.pass(now);
    if (!swallowed) {
        return;
    }
    if (status.alive) {
        spdlog::info("input {}: good{}", name, swallowed_note(*swallowed));
    } else {
        const bool said_so = status.latest.failsafe;
        spdlog::warn("input {}: lost, {}{}", name,
                     said_so ? "the receiver or a failsafe_when rule says failsafe"
                             : "no good frame within its timeout",
                     swallowed_note(*swallowed));
    }
}

/// Silence at the start is the commonest trouble of all, and its cause shows in the bytes.
void StateLog::say_never_good(const std::string& name, const InputStatus& status,
                              InputMemory& memory, Instant now) {
    if (memory.silence_said || status.ever_good || now - start_ < kFirstFrameWait) {
        return;
    }
    memory.silence_said = true;
    if (status.counts.bytes == 0 && memory.on_can) {
        spdlog::warn(
            "input {}: not one frame with its ids yet; check the ids, the bit rate and that the "
            "sender is on (candump shows what is on the bus)",
            name);
    } else if (status.counts.frames == 0 && memory.on_can) {
        spdlog::warn(
            "input {}: {} frames with its ids were refused; sender and receiver must agree on "
            "format, id, fd and checksum (tribus decode tells why)",
            name, status.rejected);
    } else if (status.counts.bytes == 0) {
        spdlog::warn("input {}: not one byte yet; check wire, ground and power of the receiver",
                     name);
    } else if (status.counts.frames == 0) {
        spdlog::warn(
            "input {}: {} bytes but no frame yet; another protocol or rate, or a line "
            "that needs an inverter (SBUS) or must not have one (i.Bus)",
            name, status.counts.bytes);
    } else {
        spdlog::warn(
            "input {}: frames arrive, but the receiver or a failsafe_when rule says that "
            "the link is down; is the transmitter on?",
            name);
    }
}

void StateLog::look_at_output(const std::string& name, const OutputStatus& status,
                              OutputMemory& memory, Instant now) {
    if (status.stage != memory.stage) {
        memory.stage = status.stage;
        if (const auto swallowed = memory.limit.pass(now)) {
            const bool fine = status.stage == OutputStage::control;
            spdlog::log(fine ? spdlog::level::info : spdlog::level::warn, "output {}: {}{}", name,
                        stage_text(status.stage), swallowed_note(*swallowed));
        }
    }
    look_at_drops(name, status, memory, now);
}

void StateLog::look_at_drops(const std::string& name, const OutputStatus& status,
                             OutputMemory& memory, Instant now) {
    if (status.counts.foreign_frames != memory.foreign_frames) {
        const std::uint64_t foreign = status.counts.foreign_frames - memory.foreign_frames;
        if (const auto swallowed = memory.limit.pass(now)) {
            spdlog::warn(
                "output {}: another node sends frames with its ids ({} since the last look); give "
                "one of the two other ids{}",
                name, foreign, swallowed_note(*swallowed));
            memory.foreign_frames = status.counts.foreign_frames;
        }
    }
    if (status.counts.busy_drops != memory.busy_drops) {
        const std::uint64_t dropped = status.counts.busy_drops - memory.busy_drops;
        if (const auto swallowed = memory.limit.pass(now)) {
            spdlog::warn("output {}: {} frames dropped because the port still had the one before{}",
                         name, dropped, swallowed_note(*swallowed));
            memory.busy_drops = status.counts.busy_drops;
        }
    }
}

void StateLog::look(Appliance& appliance, Instant now) {
    for (const Appliance::DeviceEvent& event : appliance.tend()) {
        RateLimit& device_limit =
            devices_.try_emplace(event.port->device, log_limit()).first->second;
        if (const auto swallowed = device_limit.pass(now)) {
            spdlog::log(event.back ? spdlog::level::info : spdlog::level::warn, "{} {}: {}{}",
                        event.port->link == LinkKind::can ? "interface" : "device",
                        event.port->device, event.back ? "is back" : "is gone; waiting for it",
                        swallowed_note(*swallowed));
        }
    }
    can_.look(appliance, now);
    const Configuration& configuration = appliance.configuration();
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        const InputStatus status = appliance.input_status(i);
        look_at_input(configuration.inputs[i].name, status, inputs_[i], now);
        say_never_good(configuration.inputs[i].name, status, inputs_[i], now);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        look_at_output(configuration.outputs[i].name, appliance.output_status(i), outputs_[i], now);
    }
}

}  // namespace tribus
