#include "app/status/metrics_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/state_text/cause_text.h"
#include "core/link_cause.h"
#include "core/utf8.h"

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
    Counter<InputStatus>{"input_implausible_frames_total", "Frames with implausible values.",
                         [](const InputStatus& status) { return status.implausible.frames; }},
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

constexpr std::array kCanCounters{
    Counter<CanCounts>{"can_received_frames_total", "Frames received.",
                       [](const CanCounts& counts) { return counts.received; }},
    Counter<CanCounts>{"can_sent_frames_total", "Frames that the kernel took.",
                       [](const CanCounts& counts) { return counts.sent; }},
    Counter<CanCounts>{"can_bus_offs_total", "Times that the controller left the bus.",
                       [](const CanCounts& counts) { return counts.bus_offs; }},
    Counter<CanCounts>{"can_stalls_total", "Times that frames waited too long for the bus.",
                       [](const CanCounts& counts) { return counts.stalls; }},
    Counter<CanCounts>{"can_downs_total", "Times that the interface went down.",
                       [](const CanCounts& counts) { return counts.downs; }},
    Counter<CanCounts>{"can_error_frames_total", "Error frames of the interface.",
                       [](const CanCounts& counts) { return counts.error_frames; }},
    Counter<CanCounts>{"can_missing_acknowledges_total",
                       "Error frames that report a missing acknowledgement.",
                       [](const CanCounts& counts) { return counts.missing_acknowledges; }},
    Counter<CanCounts>{"can_receive_overflows_total", "Frames for which the socket had no room.",
                       [](const CanCounts& counts) { return counts.receive_overflows; }},
};

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
            text.sample({name(i), {"cause", as_word(input.reject_causes[cause])}},
                        count(input.status.rejected_by[cause]));
        }
    }
    text.family("input_losses_total", "counter", "Times that the input was lost, by cause.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        // The causes in front of these are no losses, and `unproved` is none either.
        for (auto cause = static_cast<std::size_t>(LinkCause::wire_silent);
             cause < static_cast<std::size_t>(LinkCause::unproved); ++cause) {
            const std::string word = as_word(name_of(static_cast<LinkCause>(cause)));
            text.sample({name(i), {"cause", word}},
                        count(report.inputs[i].status.counts.began[cause]));
        }
    }
    text.family("input_good", "gauge", "1 while an output can use its frames.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        text.sample({name(i)}, report.inputs[i].status.state.cause == LinkCause::good ? 1 : 0);
    }
    text.family("input_cause", "gauge", "1 for the present cause, 0 for the others.");
    for (std::size_t i = 0; i < report.inputs.size(); ++i) {
        for (std::size_t cause = 0; cause < kLinkCauseCount; ++cause) {
            const auto named = static_cast<LinkCause>(cause);
            text.sample({name(i), {"cause", as_word(name_of(named))}},
                        report.inputs[i].status.state.cause == named ? 1 : 0);
        }
    }
}

/// Quantiles of no values are no numbers: as 0 an output that sends nothing would look punctual.
void add_quantiles(Text& text, std::string_view name, std::string_view help,
                   const StatusReport& report, HistogramReading OutputReport::*reading) {
    constexpr std::array<std::pair<std::string_view, double>, 3> kQuantiles{
        {{"0.5", 0.5}, {"0.99", 0.99}, {"1", 1.0}}};
    text.family(name, "summary", help);
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        const HistogramReading& read = report.outputs[i].*reading;
        for (const auto& [word, share] : kQuantiles) {
            text.sample({{"output", report.configuration->outputs[i].name}, {"quantile", word}},
                        read.count() == 0 ? std::numeric_limits<double>::quiet_NaN()
                                          : seconds(read.quantile(share)));
        }
    }
}

void add_output_states(Text& text, const StatusReport& report) {
    constexpr std::array<std::string_view, 5> kStates{"control", "hold", "failsafe", "silent",
                                                      "cannot_send"};
    text.family("output_state", "gauge", "1 for the present state, 0 for the others.");
    for (std::size_t i = 0; i < report.outputs.size(); ++i) {
        const OutputStatus& status = report.outputs[i].status;
        const std::string_view present = output_state_word(status.state.stage, status.sends);
        for (const std::string_view state : kStates) {
            text.sample({{"output", report.configuration->outputs[i].name}, {"state", state}},
                        state == present ? 1 : 0);
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
    add_output_states(text, report);
    add_quantiles(text, "output_lateness_seconds", "Time from due to taken, last minute.", report,
                  &OutputReport::lateness);
    add_quantiles(
        text, "output_latency_seconds",
        "Time from reading an input's frame to handing over the output's frame, last minute.",
        report, &OutputReport::latency);
}

void add_ports(Text& text, const StatusReport& report) {
    text.family("port_present", "gauge", "1 while the device or interface is present.");
    for (const PortReport& port : report.ports) {
        text.sample({{"port", port.name}}, port.present ? 1 : 0);
    }
    std::vector<const PortReport*> buses;
    for (const PortReport& port : report.ports) {
        if (port.can) {
            buses.push_back(&port);
        }
    }
    text.family("can_ready", "gauge", "1 while the interface can send without trouble.");
    for (const PortReport* bus : buses) {
        text.sample({{"port", bus->name}}, can_state_word(*bus) == kCanStateWords.front() ? 1 : 0);
    }
    text.family("can_state", "gauge", "1 for the present state, 0 for the others.");
    for (const PortReport* bus : buses) {
        for (const std::string_view state : kCanStateWords) {
            text.sample({{"port", bus->name}, {"state", state}},
                        can_state_word(*bus) == state ? 1 : 0);
        }
    }
    for (const Counter<CanCounts>& counter : kCanCounters) {
        text.family(counter.name, "counter", counter.help);
        for (const PortReport* bus : buses) {
            text.sample({{"port", bus->name}}, count(counter.value(bus->can->counts)));
        }
    }
}

/// The age goes on where the value is left out: so a value that became stale can be told from one
/// that never was.
void add_values(Text& text, const StatusReport& report) {
    const auto labels = [](const ValueReport& value) {
        return std::vector<Label>{{"name", value.value.name}, {"unit", value.value.unit}};
    };
    text.family("value", "gauge", "A named value that is not stale, in its own unit.");
    for (const ValueReport& value : report.values) {
        const ValueStatus& status = value.status;
        const bool fresh =
            value.value.lasts == kForever || report.now - status.at <= value.value.lasts;
        if (status.available && fresh) {
            text.sample(labels(value), status.number);
        }
    }
    text.family("value_age_seconds", "gauge",
                "Time since the source of a named value last gave it, stale or not.");
    for (const ValueReport& value : report.values) {
        if (value.status.ever) {
            text.sample(labels(value), seconds(report.now - value.status.at));
        }
    }
}

}  // namespace

/// Backslash, quote and line feed are escaped (text format 0.0.4, "Line format"). A scraper refuses
/// all of a text that is not UTF-8, so a byte of something else is shown as \xE4.
std::string escaped_label(std::string_view text) {
    std::string out;
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        const char first = text.front();
        if (length == 0) {
            out += fmt::format("\\\\x{:02X}", static_cast<unsigned char>(first));
        } else if (first == '\n') {
            out += "\\n";
        } else {
            out += first == '\\' || first == '"' ? "\\" : "";
            out += text.substr(0, length);
        }
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return out;
}

std::string metrics_text(const StatusReport& report) {
    Text text(name_of(report));
    text.family("uptime_seconds", "gauge", "Time since the program started.");
    text.sample({}, seconds(report.now - report.started));
    text.family("start_since_boot_seconds", "gauge",
                "When the program started, on the board's clock since its boot; another number is "
                "another process.");
    text.sample({}, seconds(report.started.time_since_epoch()));
    text.family("figures_age_seconds", "gauge",
                "Time since the data thread published the figures below; if it grows, all of them "
                "are old.");
    text.sample({}, seconds(report.now - report.figures_at));
    text.family("realtime_parts_missing", "gauge",
                "Parts of real time that are missing; the status has their sentences.");
    text.sample({}, static_cast<double>(report.missing_realtime.size()));
    add_inputs(text, report);
    add_outputs(text, report);
    add_ports(text, report);
    add_values(text, report);
    return text.take();
}

}  // namespace tribus
