#include "app/log/state_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "app/log/doctor_hint.h"
#include "app/log/port_of.h"
#include "app/state_text/cause_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

/// A receiver that is on has sent hundreds of frames by then.
constexpr Duration kFirstFrameWait = std::chrono::seconds(3);

/// Places of the counters of messages that the key does not prove.
std::vector<std::size_t> unproved_causes(const Appliance& appliance, std::size_t input) {
    constexpr std::array<std::string_view, 3> kUnproved{"forged", "no_key", "no_challenge"};
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < appliance.reject_cause_count(input); ++i) {
        if (std::ranges::find(kUnproved, appliance.reject_cause(input, i)) != kUnproved.end()) {
            places.push_back(i);
        }
    }
    return places;
}

}  // namespace

StateLog::StateLog(const Appliance& appliance, Instant start)
    : can_(appliance), sensor_buses_(appliance, start) {
    const Configuration& configuration = appliance.configuration();
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        inputs_.push_back({.start = start, .unproved_causes = unproved_causes(appliance, i)});
    }
    outputs_.resize(configuration.outputs.size());
}

void StateLog::go_on_from(const StateLog& before, const Appliance& appliance,
                          const CarryOver& carry_over) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        if (const CarriedFrom from = carry_over.engine.inputs[i].from) {
            inputs_[i] = before.inputs_[*from];
        }
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        if (const CarriedFrom from = carry_over.engine.outputs[i].from) {
            outputs_[i] = before.outputs_[*from];
        }
    }
    absences_ = before.absences_;
    absence_limit_ = before.absence_limit_;
    can_.go_on_from(before.can_, appliance);
    sensor_buses_.go_on_from(before.sensor_buses_, carry_over.values.buses);
}

void StateLog::look_for_two_senders(const std::string& name, const InputStatus& status,
                                    InputMemory& memory) {
    if (status.two_senders && !std::exchange(memory.two_senders_logged, true)) {
        const LogFields fields({"TRIBUS_INPUT", name});
        log_warning("input {}: {}", name, kTwoSendersText);
    }
}

/// Frames among good ones. If none is good, the cause says it.
void StateLog::look_at_implausible(const std::string& name, const InputStatus& status,
                                   InputMemory& memory, Instant now) {
    const ImplausibleFrames& implausible = status.implausible;
    if (status.state.cause == LinkCause::implausible || implausible.frames < memory.implausible) {
        memory.implausible = implausible.frames;
    }
    if (implausible.frames == memory.implausible || !memory.implausible_limit.pass(now)) {
        return;
    }
    const LogFields fields({"TRIBUS_INPUT", name});
    log_warning("input {}: {} not plausible and ignored: {}", name,
                counted(implausible.frames - memory.implausible, "frame"),
                implausible_text(implausible));
    memory.implausible = implausible.frames;
}

/// While the input is good: else its cause says it.
void StateLog::look_at_unproved(const std::string& name, const InputStatus& status,
                                InputMemory& memory, Instant now) {
    std::uint64_t unproved = 0;
    for (const std::size_t cause : memory.unproved_causes) {
        unproved += status.rejected_by[cause];
    }
    if (status.state.cause != LinkCause::good || unproved < memory.unproved) {
        memory.unproved = unproved;
    }
    if (unproved == memory.unproved || !memory.unproved_limit.pass(now)) {
        return;
    }
    const LogFields fields({"TRIBUS_INPUT", name});
    log_warning(
        "input {}: refused {} that its key does not prove, while its own sender is heard; somebody "
        "else sends on this link",
        name, counted(unproved - memory.unproved, "message"));
    memory.unproved = unproved;
}

bool StateLog::knows_the_reason(const InputStatus& status) {
    switch (status.state.cause) {
        case LinkCause::no_key:
        case LinkCause::forged:
        case LinkCause::replayed:
            return true;
        default:
            return status.fault.length > 0;
    }
}

/// No signal at the start is the most frequent problem; the received bytes show its cause.
void StateLog::log_missing_signal(const std::string& name, const InputStatus& status,
                                  const PortPlan& port, InputMemory& memory, Instant now) {
    if (memory.missing_signal_logged || status.ever_good || now - memory.start < kFirstFrameWait) {
        return;
    }
    memory.missing_signal_logged = true;
    const std::string_view cause = word_of(status.state.cause);
    const LogFields fields({"TRIBUS_INPUT", name}, {"TRIBUS_CAUSE", cause});
    const Medium& medium = *port.config.medium;
    const SilenceAdvice& advice = medium.silence;
    const std::string doctor = doctor_hint(port.config);
    if (status.counts.bytes == 0) {
        log_warning("input {}: {}{}", name, advice.nothing, doctor);
    } else if (status.counts.frames == 0) {
        const bool on_can = medium.shape == WireShape::can_frames;
        const std::uint64_t count = on_can ? status.rejected : status.counts.bytes;
        const std::string came = advice.counts.empty() ? "" : counted(count, advice.counts) + " ";
        // The usual reasons mislead where the decoder knows the right one.
        if (knows_the_reason(status)) {
            log_warning("input {}: {}but no frame that counts: {}", name, came,
                        cause_text(status.state, status.implausible, status.fault.view()));
        } else {
            log_warning("input {}: {}{}{}", name, came, advice.no_frame, doctor);
        }
    } else {
        log_warning("input {}: frames arrive, but {}; {}", name,
                    cause_text(status.state, status.implausible, status.fault.view()),
                    status.state.cause == LinkCause::implausible
                        ? "\"plausible\" and the scale of the input say what counts"
                        : advice.not_good);
    }
}

void StateLog::look_at_presets(const std::string& name, const OutputStatus& status,
                               OutputMemory& memory) {
    if ((status.state.by_preset & ~memory.presets_logged) != 0) {
        const LogFields fields({"TRIBUS_OUTPUT", name});
        log_warning("output {}: {}", name, by_preset_text(status.state.by_preset));
        memory.presets_logged |= status.state.by_preset;
    }
}

/// A receiver that does not listen says nothing of it, as it says nothing when all is well.
void StateLog::look_at_answers(const OutputConfig& output, const OutputStatus& status,
                               OutputMemory& memory) const {
    if (!hears_answers(output)) {
        return;
    }
    Answers answers = status.answers;
    if (answers.heard < memory.before.heard || answers.heard_others < memory.before.heard_others) {
        // A reload has changed what is looked for.
        memory.before = {};
        memory.advice.clear();
    }
    if (status.state.stage != OutputStage::control || !status.sends) {
        memory.before = answers;
    }
    answers.heard -= memory.before.heard;
    answers.heard_others -= memory.before.heard_others;
    const std::string advice = output.protocol->advice_by_answers(output.settings, answers);
    const LogFields fields({"TRIBUS_OUTPUT", output.name});
    if (advice.empty()) {
        if (answers.effect && !std::exchange(memory.advice, {}).empty()) {
            log_info("output {}: an answer shows its channels now", output.name);
        }
        return;
    }
    if (advice != memory.advice) {
        log_warning("output {}: {}", output.name, advice);
        memory.advice = advice;
    }
}

void StateLog::look_at_drops(const std::string& name, const OutputStatus& status,
                             OutputMemory& memory, Instant now) {
    if (status.counts.foreign_frames == memory.foreign_frames &&
        status.counts.busy_drops == memory.busy_drops) {
        return;
    }
    const LogFields fields({"TRIBUS_OUTPUT", name},
                           {"TRIBUS_STATE", output_state_word(status.state.stage, status.sends)});
    if (status.counts.foreign_frames != memory.foreign_frames) {
        const std::uint64_t foreign = status.counts.foreign_frames - memory.foreign_frames;
        if (memory.foreign_limit.pass(now)) {
            log_warning(
                "output {}: another node sends frames with its ids ({} since the last line); give "
                "one of the two different ids",
                name, foreign);
            memory.foreign_frames = status.counts.foreign_frames;
        }
    }
    if (status.counts.busy_drops != memory.busy_drops) {
        const std::uint64_t dropped = status.counts.busy_drops - memory.busy_drops;
        if (memory.drops_limit.pass(now)) {
            log_warning("output {}: {} dropped because the port still had the frame before", name,
                        counted(dropped, "frame"));
            memory.busy_drops = status.counts.busy_drops;
        }
    }
}

/// Logged before its consequences: an input that was lost meanwhile is not at fault.
void StateLog::look_at_absence(const AbsenceStatus& absence, Instant now) {
    if (absence.count == absences_) {
        return;
    }
    if (const auto swallowed = absence_limit_.pass(now)) {
        log_warning(
            "this program did not run for {:.1f} s (stopped, suspended, or without processor "
            "time): inputs with a shorter timeout count as lost{}",
            std::chrono::duration<double>(absence.latest).count(), swallowed_note(*swallowed));
        absences_ = absence.count;
    }
}

void StateLog::look(const Appliance& appliance, const Appliance::DeviceNews& news, Instant now) {
    look_at_absence(appliance.absence(), now);
    for (const Appliance::DeviceEvent& event : news.events) {
        if (!event.problem.empty()) {
            log_warning("{}", event.problem);
        }
    }
    can_.look(appliance, news.restarts, now);
    sensor_buses_.look(appliance, now);
    const Configuration& configuration = appliance.configuration();
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        const InputStatus status = appliance.input_status(i);
        look_for_two_senders(configuration.inputs[i].name, status, inputs_[i]);
        look_at_implausible(configuration.inputs[i].name, status, inputs_[i], now);
        look_at_unproved(configuration.inputs[i].name, status, inputs_[i], now);
        const std::size_t port = port_of(appliance, input_station(i));
        if (appliance.port_present(port)) {
            log_missing_signal(configuration.inputs[i].name, status, appliance.ports()[port],
                               inputs_[i], now);
        } else {
            // Nothing can come before the device is there. Another message says that it is missing.
            inputs_[i].start = now;
        }
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const OutputStatus status = appliance.output_status(i);
        look_at_presets(configuration.outputs[i].name, status, outputs_[i]);
        look_at_drops(configuration.outputs[i].name, status, outputs_[i], now);
        look_at_answers(configuration.outputs[i], status, outputs_[i]);
    }
}

}  // namespace tribus
