#include <array>
#include <cstddef>

#include "app/state_text/cause_text.h"
#include "app/status/field_tables.h"
#include "app/status/field_values.h"
#include "core/link_cause.h"

namespace tribus::input_fields {
namespace {

using namespace field_values;

const InputStatus& status(const StatusPart& part) {
    return part.report.inputs[part.index].status;
}

constexpr std::array<std::string_view, 3> kStates{"good", "frame_lost", "failsafe"};
constexpr std::array<std::string_view, 5> kSigns{"none", "failsafe_flag", "value_rule",
                                                 "frame_lost_run", "frame_lost_ratio"};

bool good(const StatusPart& part) {
    return status(part).state.cause == LinkCause::good;
}

OrderedJson state(const StatusPart& part) {
    return !good(part) ? kStates[2] : status(part).latest.frame_lost ? kStates[1] : kStates[0];
}

OrderedJson implausible(const StatusPart& part) {
    const ImplausibleFrames& implausible = status(part).implausible;
    OrderedJson json{{"frames", implausible.frames},
                     {"channel", nullptr},
                     {"us", nullptr},
                     {"plausible_us", nullptr}};
    if (implausible.frames > 0) {
        json["channel"] = implausible.channel + 1;
        json["us"] = number_json(implausible.pulse.microseconds());
    }
    if (const auto& range = implausible.plausible) {
        json["plausible_us"] = {number_json(range->low.microseconds()),
                                number_json(range->high.microseconds())};
    }
    return json;
}

OrderedJson rejected(const StatusPart& part) {
    OrderedJson json = OrderedJson::object();
    const InputReport& input = of<InputReport>(part);
    for (std::size_t i = 0; i < input.reject_causes.size(); ++i) {
        json[as_word(input.reject_causes[i])] = input.status.rejected_by[i];
    }
    return json;
}

/// The causes before `wire_silent` are no losses, and `unproved` is none either.
constexpr auto kFirstLoss = static_cast<std::size_t>(LinkCause::wire_silent);
constexpr std::span<const std::string_view> kLossWords(
    kLinkCauseWords.begin() + kFirstLoss,
    kLinkCauseWords.begin() + static_cast<std::size_t>(LinkCause::unproved));

OrderedJson losses(const StatusPart& part) {
    OrderedJson json = OrderedJson::object();
    for (std::size_t i = 0; i < kLossWords.size(); ++i) {
        const std::uint64_t count = status(part).counts.began[kFirstLoss + i];
        const bool usual = static_cast<LinkCause>(kFirstLoss + i) <= LinkCause::channels_missing;
        if (usual || count != 0) {
            json[std::string(kLossWords[i])] = count;
        }
    }
    return json;
}

OrderedJson is_good(const StatusPart& part) {
    return good(part);
}
OrderedJson cause(const StatusPart& part) {
    return word_of(status(part).state.cause);
}
OrderedJson text(const StatusPart& part) {
    const InputStatus& input = status(part);
    return cause_text(input.state, input.implausible, input.fault.view());
}
OrderedJson state_age(const StatusPart& part) {
    const LinkState& state = status(part).state;
    return state.cause == LinkCause::never_seen ? OrderedJson() : age(state.since, part.report.now);
}
OrderedJson newest_age(const StatusPart& part) {
    const InputStatus& input = status(part);
    return input.counts.frames == 0 ? OrderedJson() : age(input.newest_at, part.report.now);
}
OrderedJson implausible_frames(const StatusPart& part) {
    return status(part).implausible.frames;
}

template <bool ChannelFrame::*Mark>
OrderedJson mark(const StatusPart& part) {
    return status(part).latest.*Mark;
}

constexpr std::string_view kImplausibleShape =
    "{ frames: number; channel: number | null; us: number | null;"
    " plausible_us: [number, number] | null }";

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&InputConfig::name>},
    {"protocol", FieldKind::text, "as configured", member<&InputConfig::protocol>},
    {"port", FieldKind::text, "its device, interface or address", member<&InputConfig::port>},
    {"state",
     FieldKind::word,
     "`frame_lost`: its newest frame is marked so; `failsafe`: its frames do not count, or no "
     "output can use them yet",
     state,
     {.words = kStates}},
    {"good",
     FieldKind::flag,
     "an output can use it, or it feeds none and its frames count",
     is_good,
     {.metric = "good", .fleet = "good"}},
    {"cause",
     FieldKind::word,
     "why it is good or not ([failsafe.md](failsafe.md))",
     cause,
     {.words = kLinkCauseWords, .metric = "cause", .fleet = "cause"}},
    {"sign",
     FieldKind::word,
     "what shows `radio_lost`",
     [](const StatusPart& part) { return word_in(kSigns, status(part).state.sign); },
     {.words = kSigns}},
    {"text", FieldKind::text,
     "the cause as the log says it; of implausible frames with the channel, its value and the "
     "range",
     text},
    {"state_age_us",
     FieldKind::time,
     "for how long `cause` has been so; `null` for `never_seen`",
     state_age,
     {.may_be_null = true, .fleet = "for_s"}},
    {"rate_hz",
     FieldKind::amount,
     "frames in the last second",
     member<&InputReport::rate_hz>,
     {.fleet = "rate_hz"}},
    {"interval_us", FieldKind::time, "usual time between two frames",
     member<&InputStatus::interval>},
    {"age_us",
     FieldKind::time,
     "age of the newest frame; `null` before the first",
     newest_age,
     {.may_be_null = true, .fleet = "age_s"}},
    {"channels", FieldKind::channels, "the newest frame as it came; `null` for an absent channel",
     member<&InputStatus::latest>},
    {"frame_lost", FieldKind::flag, "the mark of that frame", mark<&ChannelFrame::frame_lost>},
    {"failsafe", FieldKind::flag, "the mark of that frame", mark<&ChannelFrame::failsafe>},
    {"bytes", FieldKind::counter, "bytes received", member<&InputCounts::bytes>},
    {"frames", FieldKind::counter, "frames received", member<&InputCounts::frames>},
    {"frame_lost_frames", FieldKind::counter, "frames marked frame-lost",
     member<&InputCounts::frame_lost_frames>},
    {"failsafe_frames", FieldKind::counter, "frames marked failsafe",
     member<&InputCounts::failsafe_frames>},
    {"implausible",
     FieldKind::other,
     "`frames`: counter of frames that are not plausible; `channel`, `us`, `plausible_us`: a value "
     "of the latest, and the range that it missed, `null` for a raw zero",
     implausible,
     {.shape = kImplausibleShape}},
    {"implausible_frames",
     FieldKind::counter,
     "frames that are not plausible",
     implausible_frames,
     {.in_status = false}},
    {"two_senders",
     FieldKind::flag,
     "its frames come with two periods, as from two senders",
     member<&InputStatus::two_senders>,
     {.metric = "two_senders"}},
    {"skipped_bytes", FieldKind::counter, "bytes in no frame", member<&InputStatus::skipped_bytes>},
    {"device_losses", FieldKind::counter, "how often the device vanished",
     member<&InputCounts::device_losses>},
    {"rejected", FieldKind::counters,
     "frames refused, by cause, as [decode](commands.md#decode) names them", rejected},
    {"losses",
     FieldKind::counters,
     "how often each `cause` of a loss began; the last four once they have happened",
     losses,
     {.words = kLossWords}},
    {"frame_age", FieldKind::distribution, "how old a frame was when the next one came",
     member<&InputReport::frame_age>},
};

}  // namespace

constexpr PartKind kKind{
    "inputs",
    "input",
    "input",
    "inputs",
    kFields,
    [](const StatusReport& all) { return all.inputs.size(); },
    [](const StatusPart& part) -> std::string_view { return of<InputConfig>(part).name; }};

}  // namespace tribus::input_fields
