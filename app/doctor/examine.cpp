#include "app/doctor/examine.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "app/doctor/line_advice.h"
#include "app/doctor/listening/line_heard.h"
#include "app/doctor/listening/listener.h"

namespace tribus::doctor {
namespace {

/// The result of a trial overrides what is known about the kind of port.
void take_trials(const std::vector<Trial>& trials, ExaminedPort& port) {
    for (PortAbility& ability : port.opinion.abilities) {
        const LineSettings& line = ability.protocol == "SBUS"        ? kSbusLine
                                   : ability.protocol == "fast SBUS" ? kFastSbusLine
                                                                     : kIbusLine;
        const auto trial = std::ranges::find(trials, line, &Trial::line);
        if (trial != trials.end() && !trial->refusal.empty()) {
            ability.ability = Ability::no;
            ability.because = trial->refusal;
        } else if (trial != trials.end() && ability.ability != Ability::yes) {
            ability.ability = Ability::yes;
            ability.because.clear();
        }
    }
}

void take_story(const Visit& visit, ExaminedPort& port) {
    const std::string& device = port.facts.node;
    port.story = visit.story;
    std::vector<Finding> findings = judge_story(*port.story, device);
    std::ranges::move(findings, std::back_inserter(port.opinion.findings));
    port.lines = configuration_lines(*port.story, port.facts.device);
    const bool some_refused = std::ranges::any_of(
        visit.trials, [](const Trial& trial) { return !trial.refusal.empty(); });
    if (some_refused && port.story->sound == LineSound::unknown) {
        port.opinion.findings.push_back(
            {Severity::note, "line.sbus_unheard", device,
             "this may be SBUS: this port cannot be set to it", "",
             "To find out, connect it to a port that can; `tribus doctor` lists them."});
    }
}

void try_and_listen(const KernelFiles& files, Duration time,
                    const std::function<void(std::string_view)>& says, ExaminedPort& port) {
    const std::string device = port.facts.node;
    const Visit visit = visit_port(device, time, says);
    // Only an open adapter has accepted or refused the short timer.
    port.facts.latency_timer = look_at_serial_port(files, device).latency_timer;
    port.facts.was_opened = visit.failure.empty();
    port.opinion = judge_port(port.facts, true);
    if (!visit.failure.empty()) {
        port.opinion.findings.push_back(
            {Severity::problem, "port.cannot_open", device, visit.failure, "", ""});
        return;
    }
    port.tried = true;
    take_trials(visit.trials, port);
    if (visit.story) {
        take_story(visit, port);
    }
}

}  // namespace

bool may_be_used(const std::vector<Finding>& findings) {
    return std::ranges::none_of(
        findings, [](const Finding& finding) { return finding.severity == Severity::problem; });
}

Finding unknown_interface(const std::string& name, std::string_view error) {
    const std::size_t prefix = name.size() + std::string_view(": ").size();
    return {Severity::problem, "can.unknown", name, std::string(error.substr(prefix)), "", ""};
}

ExaminedPort examine_port(const KernelFiles& files, const std::string& device, Duration time,
                          const std::function<void(std::string_view)>& says) {
    ExaminedPort port{.facts = look_at_serial_port(files, device)};
    port.opinion = judge_port(port.facts, true);
    if (may_be_used(port.opinion.findings)) {
        try_and_listen(files, time, says, port);
    }
    return port;
}

}  // namespace tribus::doctor
