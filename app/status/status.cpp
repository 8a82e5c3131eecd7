#include "app/status/status.h"

#include <cmath>
#include <filesystem>
#include <utility>

#include "app/status/status_line.h"
#include "config/build/dronecan.h"

namespace tribus {

void RateWindow::look(std::uint64_t count, Instant at) {
    if (!begun_ || count < begin_count_) {
        begun_ = true;
        begin_ = at;
        begin_count_ = count;
    } else if (at - begin_ >= kWindow) {
        rate_ = static_cast<double>(count - begin_count_) /
                std::chrono::duration<double>(at - begin_).count();
        begin_ = at;
        begin_count_ = count;
    }
    latest_ = at;
}

double RateWindow::rate_hz(Instant now) const {
    constexpr double kTenths = 10;
    return now - latest_ > kWindow ? 0 : std::round(rate_ * kTenths) / kTenths;
}

StatusKeeper::StatusKeeper(const Appliance& appliance, Instant started)
    : started_(started),
      inputs_(appliance.configuration().inputs.size()),
      outputs_(appliance.configuration().outputs.size()) {
    for (const NodePlan& plan : plan_nodes(appliance.configuration(), {})) {
        nodes_.emplace_back(plan.port.device, plan.settings.id);
    }
    look(appliance);
}

void StatusKeeper::look(const Appliance& appliance) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        const InputStatus status = appliance.input_status(i);
        inputs_[i].look(status.counts.frames, status.at);
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const OutputStatus status = appliance.output_status(i);
        outputs_[i].look(status.counts.frames, status.at);
    }
}

namespace {

InputReport input_report(const Appliance& appliance, std::size_t index, const RateWindow& rate,
                         Instant now) {
    InputReport report;
    report.status = appliance.input_status(index);
    for (std::size_t i = 0; i < appliance.reject_cause_count(index); ++i) {
        report.reject_causes.push_back(appliance.reject_cause(index, i));
    }
    report.rate_hz = rate.rate_hz(now);
    report.frame_age = appliance.input_timing(index).age().last_minute(now);
    return report;
}

OutputReport output_report(const Appliance& appliance, std::size_t index, const RateWindow& rate,
                           Instant now) {
    OutputReport report;
    report.status = appliance.output_status(index);
    const auto inputs = appliance.inputs_of(index);
    report.inputs.assign(inputs.begin(), inputs.end());
    report.rate_hz = rate.rate_hz(now);
    const OutputTiming& timing = appliance.output_timing(index);
    report.lateness = timing.lateness().last_minute(now);
    report.latency = timing.latency().last_minute(now);
    report.deadline_misses = timing.deadline_misses();
    return report;
}

std::vector<PortReport> port_reports(const Appliance& appliance) {
    std::vector<PortReport> reports;
    for (std::size_t port = 0; port < appliance.ports().size(); ++port) {
        const PortConfig& config = appliance.ports()[port].config;
        PortReport report{config.device, appliance.port_present(port), std::nullopt};
        if (config.medium->shape == WireShape::can_frames) {
            report.can = appliance.can_status(port);
        }
        reports.push_back(std::move(report));
    }
    return reports;
}

}  // namespace

std::string name_of(const StatusReport& report) {
    return std::filesystem::path(report.configuration->file).stem().string();
}

bool is_of_part(std::string_view name) {
    return name.starts_with("input.") || name.starts_with("output.");
}

bool is_fresh(const ValueStatus& status, Duration lasts, Instant now) {
    return status.available && (lasts == kForever || now - status.at <= lasts);
}

std::string_view can_state_word(const PortReport& port) {
    return port.present && port.can ? kCanStateWords[static_cast<std::size_t>(port.can->state)]
                                    : kCanStateWords.back();
}

std::string status_line(const Appliance& appliance, Instant now) {
    const Configuration& configuration = appliance.configuration();
    std::vector<InputStatus> inputs;
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        inputs.push_back(appliance.input_status(i));
    }
    std::vector<OutputStatus> outputs;
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        outputs.push_back(appliance.output_status(i));
    }
    return status_line(configuration, inputs, outputs, appliance.figures_at(), now);
}

StatusReport StatusKeeper::report(const Appliance& appliance, Instant now,
                                  Duration wall_time) const {
    StatusReport report;
    report.configuration = &appliance.configuration();
    report.now = now;
    report.wall_time = wall_time;
    report.started = started_;
    report.missing_realtime = appliance.missing_realtime();
    report.absence = appliance.absence();
    report.text = status_line(appliance, now);
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        report.inputs.push_back(input_report(appliance, i, inputs_[i], now));
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        report.outputs.push_back(output_report(appliance, i, outputs_[i], now));
    }
    report.figures_at = appliance.figures_at();
    report.ports = port_reports(appliance);
    for (std::size_t i = 0; i < report.configuration->lines.size(); ++i) {
        report.lines.push_back({appliance.line_present(i), appliance.line_active(i)});
    }
    for (std::size_t i = 0; i < report.configuration->sensor_buses.size(); ++i) {
        report.sensor_buses.push_back(appliance.bus_state(i));
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
        report.nodes.push_back({nodes_[i].first, nodes_[i].second, appliance.node_report(i)});
    }
    for (std::size_t i = 0; i < appliance.value_count(); ++i) {
        report.values.push_back({appliance.value(i), appliance.value_status(i)});
    }
    if (appliance.machine().measured_at() != Instant{}) {
        for (std::size_t fact = 0; fact < kMachineFactCount; ++fact) {
            report.machine.push_back(appliance.machine().number(fact));
        }
    }
    return report;
}

}  // namespace tribus
