#include "app/log/state_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "app/log/doctor_hint.h"
#include "app/log/port_of.h"
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
    : can_(appliance), sensor_buses_(appliance, start), nodes_(appliance) {
    const Configuration& configuration = appliance.configuration();
    for (const InputConfig& input : configuration.inputs) {
        input_names_.push_back(input.name);
        inputs_.push_back(
            {.start = start, .unproved_causes = unproved_causes(appliance, inputs_.size())});
    }
    outputs_.resize(configuration.outputs.size());
    for (const Appliance::DeviceEvent& device : appliance.devices()) {
        // The start itself reports the devices that it waits for.
        const bool told = !device.back && !appliance.waits_for().empty();
        devices_[device.name] = {
            .present = device.back, .ever = !told, .word = ChangeReport(!told)};
    }
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
            // The indices in it may mean other inputs now.
            outputs_[i].state.reset();
        }
    }
    for (auto& [name, memory] : devices_) {
        if (const auto known = before.devices_.find(name); known != before.devices_.end()) {
            memory.word = known->second.word;
            memory.ever = known->second.ever;
            memory.limit = known->second.limit;
        }
    }
    absences_ = before.absences_;
    absence_limit_ = before.absence_limit_;
    can_.go_on_from(before.can_, appliance);
    sensor_buses_.go_on_from(before.sensor_buses_, carry_over.values.buses);
    nodes_.go_on_from(before.nodes_, carry_over.engine.nodes);
}

void StateLog::look_at_input(const std::string& name, const InputStatus& status,
                             InputMemory& memory, Instant now) {
    if (status.two_senders && !std::exchange(memory.two_senders_logged, true)) {
        const LogFields fields({"TRIBUS_INPUT", name});
        log_warning("input {}: {}", name, kTwoSendersText);
    }
    // The line of the output that waits for it says what it lacks.
    if (status.state.cause == LinkCause::unproved) {
        return;
    }
    const auto swallowed = memory.cause.look(status.state.cause, memory.limit, now);
    if (!swallowed) {
        return;
    }
    const std::string_view cause = word_of(status.state.cause);
    const LogFields fields({"TRIBUS_INPUT", name}, {"TRIBUS_CAUSE", cause});
    const bool good = status.state.cause == LinkCause::good;
    log_at(good ? LogLevel::info : LogLevel::warning, "input {}: {}{}", name,
           cause_text(status.state, status.implausible, status.fault.view()),
           swallowed_note(*swallowed));
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

/// Names of the outvoted inputs; bit i of `outvoted` stands for `places[i]`.
std::string StateLog::outvoted_names(std::uint32_t outvoted,
                                     std::span<const std::size_t> places) const {
    std::string text;
    for (std::size_t place = 0; place < places.size(); ++place) {
        if ((outvoted >> place & 1U) != 0) {
            text += fmt::format("{}{}", text.empty() ? "" : ", ", input_names_[places[place]]);
        }
    }
    return text;
}

void StateLog::look_at_output(const std::string& name, const OutputStatus& status,
                              std::span<const std::size_t> places, OutputMemory& memory,
                              Instant now) {
    // A line about the state says what it waits for, too.
    const bool changed = memory.state && status.state != *memory.state;
    const std::string& awaited =
        memory.awaited.look(wait_key(status.wait, input_names_), changed, now);
    // Nearly always nothing has changed, and nothing waits to be logged.
    if (status.state != memory.state || awaited != memory.word.seen().awaited ||
        memory.word.seen() != memory.word.reported()) {
        memory.state = status.state;
        look_at_state(name, status, places, awaited, memory, now);
    }
    look_at_drops(name, status, memory, now);
}

void StateLog::look_at_state(const std::string& name, const OutputStatus& status,
                             std::span<const std::size_t> places, const std::string& awaited,
                             OutputMemory& memory, Instant now) {
    const LogFields fields({"TRIBUS_OUTPUT", name},
                           {"TRIBUS_STATE", output_state_word(status.state.stage, status.sends)});
    const OutputWord word{.state = output_text(status.state, input_names_),
                          .outvoted = outvoted_names(status.state.outvoted, places),
                          .awaited = awaited};
    const bool same_votes = word.outvoted == memory.word.reported().outvoted;
    const bool same_state = word.state == memory.word.reported().state;
    if (const auto swallowed = memory.word.look(word, memory.limit, now)) {
        const Hearing hearing = status.state.hearing;
        const bool fine = status.state.stage == OutputStage::control && word.outvoted.empty() &&
                          hearing != Hearing::silent && hearing != Hearing::unreadable;
        const std::string votes = same_votes ? ""
                                  : word.outvoted.empty()
                                      ? "; its inputs agree again"
                                      : "; outvoted by the others: " + word.outvoted;
        const std::string text =
            same_state && !awaited.empty()
                ? "waits for " + wait_text(status.state, status.wait, input_names_)
                : output_sentence(status.state, status.wait, input_names_);
        log_at(fine ? LogLevel::info : LogLevel::warning, "output {}: {}{}{}", name, text, votes,
               swallowed_note(*swallowed));
    }
    if ((status.state.by_preset & ~memory.presets_logged) != 0) {
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

void StateLog::look_at_devices(std::span<const Appliance::DeviceEvent> events, Instant now) {
    const auto look = [now](const std::string& name, DeviceMemory& memory) {
        const bool back = memory.present;
        if (const auto swallowed = memory.word.look(back, memory.limit, now)) {
            const LogFields fields({"TRIBUS_DEVICE", name});
            const std::string_view word = !back         ? "is gone; waiting for it"
                                          : memory.ever ? "is back"
                                                        : "is there";
            log_at(back ? LogLevel::info : LogLevel::warning, "{}: {}{}", name, word,
                   swallowed_note(*swallowed));
        }
        memory.ever = memory.ever || back;
    };
    // A device that was gone and is back within one round is reported as gone, too.
    for (const Appliance::DeviceEvent& event : events) {
        if (!event.problem.empty()) {
            log_at(LogLevel::warning, "{}", event.problem);
        }
        devices_[event.name].present = event.back;
        look(event.name, devices_[event.name]);
    }
    for (auto& [name, memory] : devices_) {
        look(name, memory);
    }
}

void StateLog::look(const Appliance& appliance, const Appliance::DeviceNews& news, Instant now) {
    look_at_absence(appliance.absence(), now);
    look_at_devices(news.events, now);
    can_.look(appliance, news.restarts, now);
    sensor_buses_.look(appliance, now);
    nodes_.look(appliance, now);
    const Configuration& configuration = appliance.configuration();
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        const InputStatus status = appliance.input_status(i);
        look_at_input(configuration.inputs[i].name, status, inputs_[i], now);
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
        look_at_output(configuration.outputs[i].name, status, appliance.inputs_of(i), outputs_[i],
                       now);
        look_at_answers(configuration.outputs[i], status, outputs_[i]);
    }
}

}  // namespace tribus
