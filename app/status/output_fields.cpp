#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
#include "app/status/field_tables.h"
#include "app/status/field_values.h"
#include "app/status/output_why.h"
#include "config/schema/choices.h"
#include "core/link_cause.h"

namespace tribus::output_fields {
namespace {

using namespace field_values;

const Configuration& configuration(const StatusPart& part) {
    return *part.report.configuration;
}
const OutputStatus& status(const StatusPart& part) {
    return part.report.outputs[part.index].status;
}

constexpr std::array<std::string_view, 6> kObstacles{"",     "device",   "bus",
                                                     "busy", "receiver", "epoch"};
constexpr std::array<std::string_view, 4> kHearings{"", "heard", "silent", "unreadable"};

OrderedJson inputs(const StatusPart& part) {
    return names_of(of<OutputReport>(part).inputs, configuration(part).inputs);
}
OrderedJson state(const StatusPart& part) {
    return output_state_word(status(part).state.stage, status(part).sends);
}
OrderedJson in_control(const StatusPart& part) {
    return status(part).state.stage == OutputStage::control;
}
bool cannot_send(const StatusPart& part) {
    return status(part).state.stage == OutputStage::cannot_send;
}
OrderedJson text(const StatusPart& part) {
    return output_text(status(part).state, input_names(configuration(part)));
}
OrderedJson state_age(const StatusPart& part) {
    return age(status(part).stage_since, part.report.now);
}
/// The channels that send their presets.
OrderedJson by_preset(const StatusPart& part) {
    OrderedJson json = OrderedJson::array();
    for (std::uint32_t left = status(part).state.by_preset; left != 0; left &= left - 1) {
        json.push_back(std::countr_zero(left) + 1);
    }
    return json;
}
OrderedJson waits_for(const StatusPart& part) {
    return text_or_null(
        wait_text(status(part).state, status(part).wait, input_names(configuration(part))));
}
OrderedJson why(const StatusPart& part) {
    return text_or_null(output_why(part));
}
OrderedJson hold(const StatusPart& part) {
    const FailsafeSettings* const failsafe = failsafe_of(part);
    return failsafe == nullptr ? OrderedJson() : OrderedJson(us(failsafe->hold));
}
OrderedJson action(const StatusPart& part) {
    const FailsafeSettings* const failsafe = failsafe_of(part);
    return failsafe == nullptr ? OrderedJson() : OrderedJson(word_of(failsafe->action));
}
OrderedJson input(const StatusPart& part) {
    const std::size_t input = status(part).state.input;
    const auto& inputs = configuration(part).inputs;
    return input < inputs.size() ? OrderedJson(inputs[input].name) : OrderedJson();
}
/// Bit i of `outvoted` stands for the i-th input of the output.
OrderedJson outvoted(const StatusPart& part) {
    OrderedJson json = OrderedJson::array();
    const auto& places = of<OutputReport>(part).inputs;
    for (std::size_t place = 0; place < places.size(); ++place) {
        if ((status(part).state.outvoted >> place & 1U) != 0) {
            json.push_back(configuration(part).inputs[places[place]].name);
        }
    }
    return json;
}
// A receiver that gets nothing has no control.
OrderedJson frame_lost(const StatusPart& part) {
    return status(part).latest.frame_lost || cannot_send(part);
}
OrderedJson failsafe(const StatusPart& part) {
    return status(part).latest.failsafe || cannot_send(part);
}
OrderedJson cause(const StatusPart& part) {
    return word_of(status(part).latest.cause);
}
OrderedJson dropped(const StatusPart& part) {
    const OutputCounts& counts = status(part).counts;
    return {{"busy", counts.busy_drops},
            {"lost", counts.lost_drops},
            {"unavailable", counts.unavailable_drops}};
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&OutputConfig::name>},
    {"protocol", FieldKind::text, "as configured", member<&OutputConfig::protocol>},
    {"port", FieldKind::text, "its device, interface or address", member<&OutputConfig::port>},
    {"inputs",
     FieldKind::other,
     "inputs that may control it, in order of preference",
     inputs,
     {.shape = "string[]"}},
    {"state",
     FieldKind::word,
     "`hold`: last values, marked frame-lost; `failsafe`: presets, marked; `silent`: failsafe "
     "without frames; `cannot_send`: nothing leaves, whatever its inputs say",
     state,
     {.words = kOutputStateWords, .metric = "state", .fleet = "state"}},
    {"in_control",
     FieldKind::flag,
     "an input is in control",
     in_control,
     {.metric = "in_control", .in_status = false}},
    {"cannot_send",
     FieldKind::flag,
     "it cannot send",
     [](const StatusPart& part) { return OrderedJson(cannot_send(part)); },
     {.metric = "cannot_send", .in_status = false}},
    {"obstacle",
     FieldKind::word,
     "of `cannot_send`: its device is gone; the bus is down, off, or nobody acknowledges; frame "
     "after frame finds the one before still waiting; no receiver with the same key answers; its "
     "epoch file could not be written",
     [](const StatusPart& part) { return word_in(kObstacles, status(part).state.obstacle); },
     {.may_be_null = true, .words = std::span(kObstacles).subspan(1), .fleet = "obstacle"}},
    {"text", FieldKind::text, "the state as the log says it", text},
    {"state_age_us",
     FieldKind::time,
     "for how long `state` has been so; of `hold`: since the values were lost",
     state_age,
     {.may_be_null = true, .fleet = "for_s"}},
    {"waits_for",
     FieldKind::text,
     "what it waits for while it is not in control, and how far that is, such as `\"receiver: good "
     "for 0.2 of 0.5 s\"`; of several inputs the one that is nearest to control "
     "([failsafe.md](failsafe.md#what-an-output-waits-for))",
     waits_for,
     {.may_be_null = true, .fleet = "waits_for"}},
    {"why",
     FieldKind::text,
     "one sentence for who looks: what it sends meanwhile, what it waits for, and what its other "
     "inputs "
     "lack, with times",
     why,
     {.may_be_null = true}},
    {"hold_us",
     FieldKind::time,
     "how long it holds values after a loss; `null` for an output of values",
     hold,
     {.may_be_null = true}},
    {"action",
     FieldKind::word,
     "what it does then ([failsafe.md](failsafe.md)); `null` for an output of values",
     action,
     {.may_be_null = true, .words = ChoiceWords<FailsafeAction>::kAll}},
    {"marks_frame_lost", FieldKind::flag, "its frames can say frame-lost",
     member<&OutputState::marks_frame_lost>},
    {"forced", FieldKind::flag,
     "it is in failsafe because a GPIO line asks for it, another node sends with its CAN ids, or "
     "the program ends",
     member<&OutputState::forced>},
    {"awaits_release", FieldKind::flag, "it is in failsafe because `release_when` is not true",
     member<&OutputState::awaits_release>},
    {"module",
     FieldKind::word,
     "with `role = \"handset\"` of `crsf`: whether its transmitter module is heard; `silent`: "
     "nothing comes back; `unreadable`: bytes, but no frame of a module; `null` until it has sent "
     "for 3 s, and for other outputs",
     [](const StatusPart& part) { return word_in(kHearings, status(part).state.hearing); },
     {.may_be_null = true, .words = std::span(kHearings).subspan(1)}},
    {"input",
     FieldKind::text,
     "the input in control",
     input,
     {.may_be_null = true, .fleet = "input"}},
    {"outvoted",
     FieldKind::other,
     "inputs that a median outvotes",
     outvoted,
     {.shape = "string[]"}},
    {"by_preset",
     FieldKind::other,
     "channels that send their preset because the channel that they are mapped from is absent",
     by_preset,
     {.shape = "number[]"}},
    {"rate_hz",
     FieldKind::amount,
     "frames in the last second",
     member<&OutputReport::rate_hz>,
     {.fleet = "rate_hz"}},
    {"period_us", FieldKind::time, "least time between two frames", member<&OutputStatus::period>},
    {"channels", FieldKind::channels, "the newest frame as it was made",
     member<&OutputStatus::latest>},
    {"frame_lost", FieldKind::flag, "the mark of that frame; true with `cannot_send`", frame_lost},
    {"failsafe", FieldKind::flag, "the mark of that frame; true with `cannot_send`", failsafe},
    {"cause", FieldKind::word, "the cause in that frame", cause, {.words = kLinkCauseWords}},
    {"frames", FieldKind::counter, "frames sent", member<&OutputCounts::frames>},
    {"overruns", FieldKind::counter, "whole periods that were skipped",
     member<&OutputStatus::overruns>},
    {"deadline_misses", FieldKind::counter, "frames late by more than a tenth of the period",
     member<&OutputReport::deadline_misses>},
    {"dropped", FieldKind::counters,
     "frames that the port did not take: it still had the frame before (`busy`), it was not there "
     "(`lost`), the bus was down, off or stalled (`unavailable`)",
     dropped},
    {"foreign_frames", FieldKind::counter, "CAN frames of another node with its ids",
     member<&OutputCounts::foreign_frames>},
    {"hold_entries", FieldKind::counter, "times that it began to hold the last values",
     member<&OutputCounts::hold_entries>},
    {"failsafe_entries", FieldKind::counter, "times that it went into failsafe",
     member<&OutputCounts::failsafe_entries>},
    {"recoveries", FieldKind::counter, "times that control came back",
     member<&OutputCounts::recoveries>},
    {"changeovers", FieldKind::counter, "changes from one input to another",
     member<&OutputCounts::changeovers>},
    {"lateness",
     FieldKind::distribution,
     "from due to taken, in the last minute",
     member<&OutputReport::lateness>,
     {.metric = "lateness_seconds"}},
    {"latency",
     FieldKind::distribution,
     "from reading an input's frame to handing over the output's frame, in the last minute",
     member<&OutputReport::latency>,
     {.metric = "latency_seconds"}},
};

}  // namespace

constexpr PartKind kKind{
    "outputs",
    "output",
    "output",
    "outputs",
    kFields,
    [](const StatusReport& all) { return all.outputs.size(); },
    [](const StatusPart& part) -> std::string_view { return of<OutputConfig>(part).name; }};

}  // namespace tribus::output_fields
