#include "app/status/status_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/object_text.h"
#include "app/state_text/cause_text.h"
#include "app/state_text/wait_text.h"
#include "app/status/json_fields.h"
#include "app/status/metrics_text.h"
#include "app/status/sensor_bus_json.h"
#include "config/schema/choices.h"
#include "config/show/fields_json.h"
#include "core/link_cause.h"
#include "pipelines/engine/machine_facts.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

std::int64_t us(Duration duration) {
    return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

/// Rounded down to a tenth of a microsecond.
OrderedJson fine_us(Duration duration) {
    constexpr std::int64_t kTenth = 100;
    constexpr double kTenthsPerUs = 10;
    const std::int64_t tenths = duration.count() / kTenth;
    return number_json(static_cast<double>(tenths) / kTenthsPerUs);
}

OrderedJson channels(const ChannelFrame& frame) {
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

OrderedJson distribution(const HistogramReading& reading) {
    constexpr double kHalf = 0.5;
    constexpr double kMost = 0.99;
    return {{"count", reading.count()},
            {"p50_us", fine_us(reading.quantile(kHalf))},
            {"p99_us", fine_us(reading.quantile(kMost))},
            {"max_us", fine_us(reading.worst)}};
}

/// Null for an instant that was never set.
OrderedJson age(Instant at, Instant now) {
    return at == Instant{} ? OrderedJson() : OrderedJson(std::max<std::int64_t>(us(now - at), 0));
}

std::string_view input_state(const InputStatus& status) {
    return status.state.cause != LinkCause::good ? "failsafe"
           : status.latest.frame_lost            ? "frame_lost"
                                                 : "good";
}

std::string_view sign_word(RadioLossSign sign) {
    constexpr std::array<std::string_view, 5> kWords{"none", "failsafe_flag", "value_rule",
                                                     "frame_lost_run", "frame_lost_ratio"};
    return kWords[static_cast<std::size_t>(sign)];
}

OrderedJson rejected(const InputReport& input) {
    OrderedJson json = OrderedJson::object();
    for (std::size_t i = 0; i < input.reject_causes.size(); ++i) {
        json[as_word(input.reject_causes[i])] = input.status.rejected_by[i];
    }
    return json;
}

OrderedJson implausible(const ImplausibleFrames& implausible) {
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

OrderedJson losses(const InputCounts& counts) {
    OrderedJson json = OrderedJson::object();
    for (std::size_t cause = 0; cause < counts.began.size(); ++cause) {
        const auto named = static_cast<LinkCause>(cause);
        // The causes that few links can have are told once they have happened.
        const bool usual = named <= LinkCause::channels_missing;
        if (named > LinkCause::never_seen && (usual || counts.began[cause] != 0)) {
            json[as_word(name_of(named))] = counts.began[cause];
        }
    }
    return json;
}

OrderedJson input_json(const InputConfig& config, const InputReport& input, Instant now) {
    const InputStatus& status = input.status;
    const InputCounts& counts = status.counts;
    JsonFields json;
    json["name"] = config.name;
    json["protocol"] = config.protocol->name;
    json["port"] = config.port.device;
    json["state"] = input_state(status);
    json["cause"] = as_word(name_of(status.state.cause));
    json["sign"] = sign_word(status.state.sign);
    json["text"] = cause_text(status.state, status.implausible, status.fault.view());
    json["state_age_us"] =
        status.state.cause == LinkCause::never_seen ? OrderedJson() : age(status.state.since, now);
    json["rate_hz"] = number_json(std::round(input.rate_hz * 10) / 10);
    json["interval_us"] = us(status.interval);
    json["age_us"] = counts.frames == 0 ? OrderedJson() : age(status.newest_at, now);
    json["channels"] = channels(status.latest);
    json["frame_lost"] = status.latest.frame_lost;
    json["failsafe"] = status.latest.failsafe;
    json["bytes"] = counts.bytes;
    json["frames"] = counts.frames;
    json["frame_lost_frames"] = counts.frame_lost_frames;
    json["failsafe_frames"] = counts.failsafe_frames;
    json["implausible"] = implausible(status.implausible);
    json["skipped_bytes"] = status.skipped_bytes;
    json["device_losses"] = counts.device_losses;
    json["rejected"] = rejected(input);
    json["losses"] = losses(counts);
    json["frame_age"] = distribution(input.frame_age);
    return json.take();
}

OrderedJson names_of(std::span<const std::size_t> inputs, const Configuration& configuration) {
    OrderedJson json = OrderedJson::array();
    for (const std::size_t input : inputs) {
        json.push_back(configuration.inputs[input].name);
    }
    return json;
}

OrderedJson obstacle_word(SendObstacle obstacle) {
    constexpr std::array<std::string_view, 6> kWords{"",     "device",   "bus",
                                                     "busy", "receiver", "epoch"};
    return obstacle == SendObstacle::none ? OrderedJson()
                                          : OrderedJson(kWords[static_cast<std::size_t>(obstacle)]);
}

OrderedJson hearing_word(Hearing hearing) {
    constexpr std::array<std::string_view, 4> kWords{"", "heard", "silent", "unreadable"};
    return hearing == Hearing::not_awaited ? OrderedJson()
                                           : OrderedJson(kWords[static_cast<std::size_t>(hearing)]);
}

/// Bit i of `outvoted` stands for the i-th input of the output.
OrderedJson outvoted(const OutputReport& output, const Configuration& configuration) {
    OrderedJson json = OrderedJson::array();
    for (std::size_t place = 0; place < output.inputs.size(); ++place) {
        if ((output.status.state.outvoted >> place & 1U) != 0) {
            json.push_back(configuration.inputs[output.inputs[place]].name);
        }
    }
    return json;
}

/// Null for an output without a pipeline: it sends values only.
const FailsafeSettings* failsafe_of(std::size_t output, const Configuration& configuration) {
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        const auto found = std::ranges::find(pipeline.outputs, output);
        if (found != pipeline.outputs.end()) {
            return &pipeline.failsafe[static_cast<std::size_t>(found - pipeline.outputs.begin())];
        }
    }
    return nullptr;
}

std::vector<std::string> input_names(const Configuration& configuration) {
    std::vector<std::string> names;
    for (const InputConfig& input : configuration.inputs) {
        names.push_back(input.name);
    }
    return names;
}

OrderedJson waits_for(const OutputStatus& status, std::span<const std::string> inputs) {
    const std::string text = wait_text(status.state, status.wait, inputs);
    return text.empty() ? OrderedJson() : OrderedJson(text);
}

OrderedJson output_json(std::size_t index, const OutputReport& output, const StatusReport& report) {
    const Configuration& configuration = *report.configuration;
    const OutputConfig& config = configuration.outputs[index];
    const OutputStatus& status = output.status;
    JsonFields json;
    json["name"] = config.name;
    json["protocol"] = config.protocol->name;
    json["port"] = config.port.device;
    json["inputs"] = names_of(output.inputs, configuration);
    json["state"] = output_state_word(status.state.stage, status.sends);
    json["obstacle"] = obstacle_word(status.state.obstacle);
    const std::vector<std::string> inputs = input_names(configuration);
    json["text"] = output_text(status.state, inputs);
    json["waits_for"] = waits_for(status, inputs);
    const FailsafeSettings* const failsafe = failsafe_of(index, configuration);
    json["hold_us"] = failsafe == nullptr ? OrderedJson() : OrderedJson(us(failsafe->hold));
    json["action"] = failsafe == nullptr ? OrderedJson() : OrderedJson(word_of(failsafe->action));
    json["marks_frame_lost"] = status.state.marks_frame_lost;
    json["forced"] = status.state.forced;
    json["awaits_release"] = status.state.awaits_release;
    json["module"] = hearing_word(status.state.hearing);
    json["input"] = status.state.input < configuration.inputs.size()
                        ? OrderedJson(configuration.inputs[status.state.input].name)
                        : OrderedJson();
    json["outvoted"] = outvoted(output, configuration);
    json["rate_hz"] = number_json(std::round(output.rate_hz * 10) / 10);
    json["period_us"] = us(status.period);
    json["channels"] = channels(status.latest);
    // A receiver that gets nothing has no control.
    const bool cannot_send = status.state.stage == OutputStage::cannot_send;
    json["frame_lost"] = status.latest.frame_lost || cannot_send;
    json["failsafe"] = status.latest.failsafe || cannot_send;
    json["cause"] = as_word(name_of(status.latest.cause));
    json["frames"] = status.counts.frames;
    json["overruns"] = status.overruns;
    json["deadline_misses"] = output.deadline_misses;
    json["dropped"] = {{"busy", status.counts.busy_drops},
                       {"lost", status.counts.lost_drops},
                       {"unavailable", status.counts.unavailable_drops}};
    json["foreign_frames"] = status.counts.foreign_frames;
    json["failsafe_entries"] = status.counts.failsafe_entries;
    json["recoveries"] = status.counts.recoveries;
    json["changeovers"] = status.counts.changeovers;
    json["lateness"] = distribution(output.lateness);
    json["latency"] = distribution(output.latency);
    return json.take();
}

OrderedJson can_json(const PortReport& port) {
    const CanCounts& counts = port.can->counts;
    return {{"state", can_state_word(port)},
            {"received", counts.received},
            {"sent", counts.sent},
            {"confirmed", counts.confirmed},
            {"queue_full", counts.queue_full},
            {"abandoned", counts.abandoned},
            {"stalls", counts.stalls},
            {"bus_offs", counts.bus_offs},
            {"downs", counts.downs},
            {"error_frames", counts.error_frames},
            {"missing_acknowledges", counts.missing_acknowledges},
            {"receive_overflows", counts.receive_overflows},
            {"implausible_times", counts.implausible_times}};
}

OrderedJson port_json(const PortReport& port) {
    OrderedJson json = {
        {"name", port.name}, {"kind", port.can ? "can" : "serial"}, {"present", port.present}};
    if (port.can) {
        json["can"] = can_json(port);
    }
    return json;
}

OrderedJson node_json(const NodeStatus& node) {
    constexpr std::array<std::string_view, 3> kStages{"allocating", "online", "conflict"};
    const dronecan::NodeCounts& counts = node.report.counts;
    return {
        {"interface", node.interface},
        {"state", kStages[static_cast<std::size_t>(node.report.stage)]},
        {"id", node.report.id == dronecan::kNobody ? OrderedJson() : OrderedJson(node.report.id)},
        {"sent", counts.sent},
        {"received", counts.received},
        {"errors", counts.errors},
        {"requests", counts.requests},
        {"dropped", counts.dropped},
        {"conflicts", counts.conflicts}};
}

/// JSON has neither infinity nor "not a number".
OrderedJson finite(double number) {
    return std::isfinite(number) ? number_json(number) : OrderedJson();
}

OrderedJson value_json(const ValueReport& value, Instant now) {
    const ValueStatus& status = value.status;
    const bool lasts = value.value.lasts == kForever || now - status.at <= value.value.lasts;
    return {{"name", value.value.name},
            {"number", status.ever ? finite(status.number) : OrderedJson()},
            {"unit", value.value.unit},
            {"age_us", status.ever ? age(status.at, now) : OrderedJson()},
            {"stale", !(status.available && lasts)}};
}

OrderedJson machine_json(const StatusReport& report) {
    OrderedJson json = OrderedJson::object();
    for (std::size_t fact = 0; fact < report.machine.size(); ++fact) {
        const auto& [name, unit] = kMachineFacts[fact];
        const std::string_view written = unit == "%" ? "percent" : unit;
        const std::string key =
            std::string(name) + (written.empty() ? "" : "_") + std::string(written);
        json[key] = report.machine[fact] ? finite(*report.machine[fact]) : OrderedJson();
    }
    return json;
}

OrderedJson pipeline_json(const PipelineConfig& pipeline, const Configuration& configuration) {
    OrderedJson to = OrderedJson::array();
    for (const std::size_t output : pipeline.outputs) {
        to.push_back(configuration.outputs[output].name);
    }
    return {{"name", pipeline.name},
            {"from", names_of(pipeline.selection.inputs, configuration)},
            {"to", std::move(to)}};
}

OrderedJson line_json(const LineConfig& line, const LineReport& report) {
    return {{"name", line.name},
            {"line", to_text(line.place)},
            {"present", report.present},
            {"role", word_of(line.task.role)},
            {"active", report.active ? OrderedJson(*report.active) : OrderedJson(nullptr)}};
}

void add_lists(ObjectText& json, const StatusReport& report) {
    const Configuration& configuration = *report.configuration;
    json.add_list("inputs", report.inputs.size(), [&](std::size_t i) {
        return input_json(configuration.inputs[i], report.inputs[i], report.now);
    });
    json.add_list("pipelines", configuration.pipelines.size(), [&](std::size_t i) {
        return pipeline_json(configuration.pipelines[i], configuration);
    });
    json.add_list("outputs", report.outputs.size(),
                  [&](std::size_t i) { return output_json(i, report.outputs[i], report); });
    json.add_list("ports", report.ports.size(),
                  [&](std::size_t i) { return port_json(report.ports[i]); });
    json.add_list("lines", report.lines.size(), [&](std::size_t i) {
        return line_json(configuration.lines[i], report.lines[i]);
    });
    json.add_list("sensor_buses", report.sensor_buses.size(), [&](std::size_t i) {
        return sensor_bus_json(configuration.sensor_buses[i], report.sensor_buses[i], report);
    });
    json.add_list("dronecan", report.nodes.size(),
                  [&](std::size_t i) { return node_json(report.nodes[i]); });
    json.add_list("values", report.values.size(),
                  [&](std::size_t i) { return value_json(report.values[i], report.now); });
}

}  // namespace

std::string status_json(const StatusReport& report) {
    ObjectText json;
    json.add("type", "status");
    json.add("version", kStatusVersion);
    json.add("name", name_of(report));
    json.add("file", report.configuration->file);
    json.add("t_us", us(report.now.time_since_epoch()));
    json.add("unix_time_us", us(report.wall_time));
    json.add("uptime_us", us(report.now - report.started));
    json.add("trial_left_us",
             report.trial_left ? OrderedJson(us(*report.trial_left)) : OrderedJson());
    json.add("trial", report.trial ? OrderedJson(*report.trial) : OrderedJson());
    json.add("fingerprint", report.fingerprint);
    json.add("figures_age_us", age(report.figures_at, report.now));
    json.add("missing_realtime", report.missing_realtime);
    add_lists(json, report);
    json.add("machine", machine_json(report));
    return std::move(json).end();
}

std::string metrics_json(const StatusReport& report) {
    ObjectText json;
    json.add("type", "metrics");
    json.add("text", metrics_text(report));
    return std::move(json).end();
}

}  // namespace tribus
