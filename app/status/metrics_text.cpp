#include "app/status/metrics_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/link_cause.h"
#include "pipelines/engine/machine_facts.h"

namespace tribus {
namespace {

using Label = std::pair<std::string_view, std::string_view>;

/// Writes metric families one after the other, each with one help and one type line.
class Text {
  public:
    explicit Text(std::string_view daemon) : daemon_(escaped_label(daemon)) {}
    void family(std::string_view name, std::string_view type, std::string_view help) {
        name_ = name;
        type_ = type;
        help_ = help;
    }
    void sample(const std::vector<Label>& labels, double value) {
        if (!name_.empty() && name_ != begun_) {
            text_ +=
                fmt::format("# HELP tribus_{0} {1}\n# TYPE tribus_{0} {2}\n", name_, help_, type_);
            begun_ = name_;
        }
        text_ += fmt::format("tribus_{}{{daemon=\"{}\"", name_, daemon_);
        for (const auto& [label, content] : labels) {
            text_ += fmt::format(",{}=\"{}\"", label, escaped_label(content));
        }
        text_ += "} ";
        text_ += std::isnan(value)   ? std::string("NaN")
                 : std::isinf(value) ? std::string(value > 0 ? "+Inf" : "-Inf")
                                     : fmt::format("{}", value);
        text_ += '\n';
    }
    std::string take() { return std::move(text_); }

  private:
    std::string daemon_;
    std::string text_;
    std::string_view name_;
    std::string_view type_;
    std::string_view help_;
    std::string_view begun_;
};

double count(std::uint64_t number) {
    return static_cast<double>(number);
}

double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// A row of a table of counters.
template <class Status>
struct Counter {
    std::string_view name;
    std::string_view help;
    std::uint64_t (*value)(const Status&);
};

constexpr std::array kInputCounters{
    Counter<InputStatus>{"input_frames_total", "Frames received.",
                         [](const InputStatus& status) { return status.counts.frames; }},
    Counter<InputStatus>{"input_bytes_total", "Bytes received.",
                         [](const InputStatus& status) { return status.counts.bytes; }},
    Counter<InputStatus>{"input_frame_lost_frames_total", "Frames marked frame-lost.",
                         [](const InputStatus& status) { return status.counts.frame_lost_frames; }},
    Counter<InputStatus>{"input_failsafe_frames_total", "Frames marked failsafe.",
                         [](const InputStatus& status) { return status.counts.failsafe_frames; }},
    Counter<InputStatus>{"input_skipped_bytes_total", "Bytes outside frames.",
                         [](const InputStatus& status) { return status.skipped_bytes; }},
    Counter<InputStatus>{"input_device_losses_total", "Times that the device vanished.",
                         [](const InputStatus& status) { return status.counts.device_losses; }},
};

constexpr std::array kOutputCounters{
    Counter<OutputStatus>{"output_frames_total", "Frames sent.",
                          [](const OutputStatus& status) { return status.counts.frames; }},
    Counter<OutputStatus>{"output_overruns_total", "Whole periods that were skipped.",
                          [](const OutputStatus& status) { return status.overruns; }},
    Counter<OutputStatus>{
        "output_failsafe_entries_total", "Times that the output went into failsafe.",
        [](const OutputStatus& status) { return status.counts.failsafe_entries; }},
    Counter<OutputStatus>{"output_recoveries_total", "Times that control came back.",
                          [](const OutputStatus& status) { return status.counts.recoveries; }},
    Counter<OutputStatus>{"output_changeovers_total", "Changes from one input to another.",
                          [](const OutputStatus& status) { return status.counts.changeovers; }},
    Counter<OutputStatus>{"output_foreign_frames_total", "CAN frames of another node with its ids.",
                          [](const OutputStatus& status) { return status.counts.foreign_frames; }},
};

std::string cause_word(LinkCause cause) {
    std::string text(name_of(cause));
    std::ranges::replace(text, ' ', '_');
    return text;
}

void add_inputs(Text& text, const StatusReport& report) {
    const auto name = [&](std::size_t i) {
        return Label{"input", report.configuration->inputs[i].name};
    };
    for (const Counter<InputStatus>& counter : kInputCounters) {
        text.family(counter.name, "counter", counter.help);
        for (std::size_t i = 0; i < report.inputs.size(); ++i) {
            text.sample({name(i)}, count(counter.value(report.inputs[i].status)));
        }
    }
    text.family("input_rejected_total", "counter", "Frames rejected, by cause.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        const InputReport& input = report.inputs[i];
        for (std::size_t cause = 0; cause < input.reject_causes.size(); ++cause) {
            text.sample({name(i), {"cause", input.reject_causes[cause]}},
                        count(input.status.rejected_by[cause]));
        }
    }
    text.family("input_losses_total", "counter", "Times that the input was lost, by cause.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        for (std::size_t cause = 2; cause < kLinkCauseCount; ++cause) {
            const std::string word = cause_word(static_cast<LinkCause>(cause));
            text.sample({name(i), {"cause", word}},
                        count(report.inputs[i].status.counts.began[cause]));
        }
    }
    text.family("input_good", "gauge", "1 while its frames count.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        text.sample({name(i)}, report.inputs[i].status.state.cause == LinkCause::good ? 1 : 0);
    }
}

void add_quantiles(Text& text, std::string_view name, std::string_view help,
                   const StatusReport& report, HistogramReading OutputReport::*reading) {
    constexpr std::array<std::pair<std::string_view, double>, 3> kQuantiles{
        {{"0.5", 0.5}, {"0.99", 0.99}, {"1", 1.0}}};
    text.family(name, "gauge", help);
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        for (const auto& [word, share] : kQuantiles) {
            text.sample({{"output", report.configuration->outputs[i].name}, {"quantile", word}},
                        seconds((report.outputs[i].*reading).quantile(share)));
        }
    }
}

void add_outputs(Text& text, const StatusReport& report) {
    const auto name = [&](std::size_t i) {
        return Label{"output", report.configuration->outputs[i].name};
    };
    for (const Counter<OutputStatus>& counter : kOutputCounters) {
        text.family(counter.name, "counter", counter.help);
        for (std::size_t i = 0; i < report.outputs.size(); ++i) {
            text.sample({name(i)}, count(counter.value(report.outputs[i].status)));
        }
    }
    text.family("output_dropped_total", "counter", "Frames that the port did not take, by cause.");
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        const OutputCounts& counts = report.outputs[i].status.counts;
        text.sample({name(i), {"cause", "busy"}}, count(counts.busy_drops));
        text.sample({name(i), {"cause", "lost"}}, count(counts.lost_drops));
        text.sample({name(i), {"cause", "unavailable"}}, count(counts.unavailable_drops));
    }
    text.family("output_deadline_misses_total", "counter",
                "Frames late by more than a tenth of the period.");
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        text.sample({name(i)}, count(report.outputs[i].deadline_misses));
    }
    text.family("output_in_control", "gauge", "1 while an input is in control.");
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        const OutputStage stage = report.outputs[i].status.state.stage;
        text.sample({name(i)}, stage == OutputStage::control ? 1 : 0);
    }
    text.family("output_cannot_send", "gauge", "1 while the output cannot send.");
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        const OutputStage stage = report.outputs[i].status.state.stage;
        text.sample({name(i)}, stage == OutputStage::cannot_send ? 1 : 0);
    }
    add_quantiles(text, "output_lateness_seconds", "Time from due to taken, last minute.", report,
                  &OutputReport::lateness);
    add_quantiles(
        text, "output_latency_seconds",
        "Time from reading an input's frame to handing over the output's frame, last minute.",
        report, &OutputReport::latency);
}

void add_surroundings(Text& text, const StatusReport& report) {
    text.family("port_present", "gauge", "1 while the device or interface is present.");
    for (const PortReport& port : report.ports) {
        text.sample({{"port", port.name}}, port.present ? 1 : 0);
    }
    text.family("can_ready", "gauge", "1 while the interface can send without trouble.");
    for (const PortReport& port : report.ports) {
        if (port.can) {
            const bool ready = port.present && port.can->state == CanBusState::ready;
            text.sample({{"port", port.name}}, ready ? 1 : 0);
        }
    }
    text.family("can_error_frames_total", "counter", "Error frames of the interface.");
    for (const PortReport& port : report.ports) {
        if (port.can) {
            text.sample({{"port", port.name}}, count(port.can->counts.error_frames));
        }
    }
    text.family("value", "gauge", "A named value that is not stale, in its own unit.");
    for (const ValueReport& value : report.values) {
        const ValueStatus& status = value.status;
        const bool fresh =
            value.value.lasts == kForever || report.now - status.at <= value.value.lasts;
        if (status.available && fresh) {
            text.sample({{"name", value.value.name}, {"unit", value.value.unit}}, status.number);
        }
    }
}

}  // namespace

/// Backslash, quote and line feed are escaped (text format 0.0.4, "Line format").
std::string escaped_label(std::string_view text) {
    std::string out;
    for (const char byte : text) {
        out += byte == '\\'   ? std::string("\\\\")
               : byte == '"'  ? std::string("\\\"")
               : byte == '\n' ? std::string("\\n")
                              : std::string(1, byte);
    }
    return out;
}

std::string metrics_text(const StatusReport& report) {
    Text text(name_of(report));
    text.family("uptime_seconds", "gauge", "Time since the program started.");
    text.sample({}, seconds(report.now - report.started));
    text.family("figures_age_seconds", "gauge",
                "Time since the data thread published the figures below; if it grows, all of them "
                "are old.");
    text.sample({}, seconds(report.now - report.figures_at));
    add_inputs(text, report);
    add_outputs(text, report);
    add_surroundings(text, report);
    return text.take();
}

}  // namespace tribus
