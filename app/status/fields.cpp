#include "app/status/fields.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>

#include "app/status/field_tables.h"
#include "app/status/field_values.h"
#include "app/status/json_fields.h"
#include "app/status/status_json.h"

namespace tribus {
namespace pipeline_fields {
namespace {

using namespace field_values;

OrderedJson from(const StatusPart& part) {
    return names_of(of<PipelineConfig>(part).selection.inputs, part.report.configuration->inputs);
}
OrderedJson to(const StatusPart& part) {
    return names_of(of<PipelineConfig>(part).outputs, part.report.configuration->outputs);
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&PipelineConfig::name>},
    {"from", FieldKind::other, "its inputs", from, {.shape = "string[]"}},
    {"to", FieldKind::other, "its outputs", to, {.shape = "string[]"}},
};

}  // namespace

constexpr PartKind kKind{
    "pipelines",
    "pipeline",
    "pipeline",
    "",
    kFields,
    [](const StatusReport& all) { return all.configuration->pipelines.size(); },
    [](const StatusPart& part) -> std::string_view { return of<PipelineConfig>(part).name; }};

}  // namespace pipeline_fields

namespace program_field_table {
namespace {

using namespace field_values;

OrderedJson type(const StatusPart&) {
    return "status";
}
OrderedJson version(const StatusPart&) {
    return kStatusVersion;
}
OrderedJson name(const StatusPart& part) {
    return name_of(part.report);
}
OrderedJson file(const StatusPart& part) {
    return part.report.configuration->file;
}
OrderedJson time(const StatusPart& part) {
    return us(part.report.now.time_since_epoch());
}
OrderedJson uptime(const StatusPart& part) {
    return us(part.report.now - part.report.started);
}
OrderedJson start_since_boot(const StatusPart& part) {
    return us(part.report.started.time_since_epoch());
}
OrderedJson figures_age(const StatusPart& part) {
    return age(part.report.figures_at, part.report.now);
}
/// Before the first figures it grows too: else nothing would tell that none come.
OrderedJson figures_age_or_uptime(const StatusPart& part) {
    const OrderedJson age = figures_age(part);
    return age.is_null() ? uptime(part) : age;
}
OrderedJson absences(const StatusPart& part) {
    return part.report.absence.count;
}
OrderedJson realtime_parts_missing(const StatusPart& part) {
    return part.report.missing_realtime.size();
}

constexpr StatusField kFields[]{
    {"type", FieldKind::text, "`\"status\"`", type, {.shape = "'status'"}},
    {"version", FieldKind::amount, "1", version},
    {"name", FieldKind::text, "of the configuration", name},
    {"file", FieldKind::text, "of the configuration", file},
    {"t_us", FieldKind::time, "on the monotonic clock", time},
    {"unix_time_us",
     FieldKind::time,
     "on the system clock",
     member<&StatusReport::wall_time>,
     {.fleet = "unix_time_us"}},
    {"uptime_us",
     FieldKind::time,
     "time since the program started",
     uptime,
     {.metric = "uptime_seconds", .fleet = "uptime_s"}},
    {"start_since_boot_us",
     FieldKind::time,
     "when the program started, on the board's clock since its boot; it never changes in a "
     "process, so `changes()` counts restarts",
     start_since_boot,
     {.metric = "start_since_boot_seconds", .in_status = false}},
    {"trial_left_us",
     FieldKind::time,
     "time until the configuration on trial goes back by itself; else `null`",
     member<&StatusReport::trial_left>,
     {.may_be_null = true, .fleet = "trial_left_s"}},
    {"trial",
     FieldKind::amount,
     "number of that trial; else `null`",
     member<&StatusReport::trial>,
     {.may_be_null = true}},
    {"text",
     FieldKind::text,
     "the state of all inputs and outputs in one line, the worst first",
     member<&StatusReport::text>,
     {.fleet = "text"}},
    {"fingerprint",
     FieldKind::text,
     "of the configuration that runs, with every default: another text, another fingerprint",
     member<&StatusReport::fingerprint>,
     {.fleet = "fingerprint"}},
    {"figures_age_us",
     FieldKind::time,
     "time since the data thread last published its figures, normally below 150000. **If it grows, "
     "everything else here is old**",
     figures_age,
     {.may_be_null = true, .fleet = "figures_age_s"}},
    {"figures_age_or_uptime_us",
     FieldKind::time,
     "time since the data thread last published its figures, or since the program started; if it "
     "grows, all others are old",
     figures_age_or_uptime,
     {.metric = "figures_age_seconds", .in_status = false}},
    {"changes", FieldKind::counter,
     "changes of state since the start; the number of the newest one, for the request `changes`",
     member<&StatusReport::changes>},
    {"absences", FieldKind::counter,
     "times that the program did not run for 100 ms or longer: it was stopped, suspended, or "
     "without processor time",
     absences},
    {"missing_realtime",
     FieldKind::other,
     "sentences: which part of real time is missing",
     member<&StatusReport::missing_realtime>,
     {.shape = "string[]"}},
    {"realtime_parts_missing",
     FieldKind::amount,
     "how many sentences `missing_realtime` has",
     realtime_parts_missing,
     {.metric = "realtime_parts_missing", .in_status = false}},
};

}  // namespace
}  // namespace program_field_table

std::span<const StatusField> program_fields() {
    return program_field_table::kFields;
}

std::span<const PartKind> part_kinds() {
    static constexpr std::size_t kKinds = 9;
    static const std::array<PartKind, kKinds> kinds{
        input_fields::kKind,      pipeline_fields::kKind, output_fields::kKind,
        port_fields::kKind,       can_fields::kKind,      line_fields::kKind,
        sensor_bus_fields::kKind, node_fields::kKind,     value_fields::kKind};
    return kinds;
}

const PartKind& can_kind() {
    return can_fields::kKind;
}

nlohmann::ordered_json fields_json(std::span<const StatusField> fields, const StatusPart& part) {
    JsonFields json;
    for (const StatusField& field : fields) {
        if (!field.options.in_status) {
            continue;
        }
        nlohmann::ordered_json value = field.read(part);
        if (!value.is_discarded()) {
            json.add(field.name, std::move(value));
        }
    }
    return json.take();
}

std::string metric_of(const StatusField& field) {
    const bool counts = field.kind == FieldKind::counter || field.kind == FieldKind::counters;
    return !field.options.metric.empty() || !counts ? std::string(field.options.metric)
                                                    : std::string(field.name) + "_total";
}

std::string_view metric_type(const StatusField& field) {
    switch (field.kind) {
        case FieldKind::counter:
        case FieldKind::counters:
            return "counter";
        case FieldKind::distribution:
            return "summary";
        default:
            return "gauge";
    }
}

std::string plain_text(std::string_view help) {
    std::string text;
    for (std::size_t at = 0; at < help.size(); ++at) {
        const char c = help[at];
        if (c == ']' && help.substr(at + 1, 1) == "(") {
            at = std::min(help.find(')', at), help.size() - 1);
        } else if (c != '`' && c != '*' && c != '[') {
            text += c;
        }
    }
    return text;
}

namespace field_values {

OrderedJson json_of(const ChannelFrame& frame) {
    OrderedJson json = OrderedJson::array();
    std::size_t last = kChannelCount;
    while (last > 0 && !frame.has(last - 1)) {
        --last;
    }
    for (std::size_t channel = 0; channel < last; ++channel) {
        const auto pulse = frame.channel(channel);
        json.push_back(pulse ? number_json(pulse->microseconds()) : OrderedJson());
    }
    return json;
}

namespace {

/// Rounded down to a tenth of a microsecond.
OrderedJson fine_us(Duration duration) {
    constexpr std::int64_t kTenth = 100;
    constexpr double kTenthsPerUs = 10;
    const std::int64_t tenths = duration.count() / kTenth;
    return number_json(static_cast<double>(tenths) / kTenthsPerUs);
}

}  // namespace

OrderedJson json_of(const HistogramReading& reading) {
    constexpr double kHalf = 0.5;
    constexpr double kMost = 0.99;
    return {{"count", reading.count()},
            {"p50_us", fine_us(reading.quantile(kHalf))},
            {"p99_us", fine_us(reading.quantile(kMost))},
            {"max_us", fine_us(reading.worst)}};
}

}  // namespace field_values
}  // namespace tribus
