#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/doctor/report.h"

namespace tribus::doctor {
namespace {

using OrderedJson = nlohmann::ordered_json;

template <class Value>
OrderedJson or_null(const std::optional<Value>& value) {
    return value ? OrderedJson(*value) : OrderedJson();
}

OrderedJson machine_json(const MachineFacts& machine) {
    return {{"model", machine.model},
            {"kernel", machine.kernel},
            {"realtime_kernel", machine.realtime_kernel},
            {"governors", machine.governors},
            {"throttled", or_null(machine.throttled)},
            {"temperature", or_null(machine.temperature)}};
}

OrderedJson line_json(const LineSettings& line) {
    return {{"baud", line.baud},
            {"parity", line.parity == Parity::even ? "even" : "none"},
            {"stop_bits", line.stop_bits}};
}

OrderedJson story_json(const LineStory& story) {
    constexpr std::int64_t kMicrosecond = 1000;
    OrderedJson json = {
        {"sound", sound_name(story.sound)},
        {"protocol", story.protocol.empty() ? OrderedJson() : OrderedJson(story.protocol)},
        {"line", story.protocol.empty() ? OrderedJson() : line_json(story.line)},
        {"inverted", story.sound == LineSound::inverted},
        {"listened_us", story.listened.count() / kMicrosecond},
        {"bytes", story.bytes},
        {"damaged", story.damaged},
        {"frames", story.frames},
        {"lost_bytes", story.lost_bytes}};
    json["period_us"] =
        story.period ? OrderedJson(story.period->count() / kMicrosecond) : OrderedJson();
    if (story.channels > 0) {
        json["channels"] = story.channels;
        json["frame_lost"] = story.frame_lost;
        json["failsafe"] = story.failsafe;
        json["least_us"] = or_null(story.least_us);
        json["most_us"] = or_null(story.most_us);
    }
    if (story.protocol == "sbus") {
        json["sbus2"] = story.sbus2;
        json["scale"] = story.scale.name.empty() ? OrderedJson() : OrderedJson(story.scale.name);
    }
    if (story.requests > 0) {
        json["requests"] = story.requests;
        json["replies"] = story.replies;
    }
    return json;
}

OrderedJson port_json(const ExaminedPort& port) {
    OrderedJson abilities = OrderedJson::array();
    for (const PortAbility& one : port.opinion.abilities) {
        abilities.push_back({{"protocol", one.protocol},
                             {"can", ability_name(one.ability)},
                             {"because", one.because}});
    }
    OrderedJson users = OrderedJson::array();
    for (const PortUser& user : port.facts.users) {
        users.push_back({{"process", user.process},
                         {"command", user.command},
                         {"unit", user.unit},
                         {"login", user.is_login}});
    }
    return {{"node", port.facts.node},
            {"device", port.facts.device},
            {"kind", port.opinion.kind},
            {"driver", port.facts.driver},
            {"tried", port.tried},
            {"abilities", std::move(abilities)},
            {"users", std::move(users)},
            {"heard", port.story ? story_json(*port.story) : OrderedJson()},
            {"configuration", port.lines}};
}

OrderedJson finding_json(const Finding& finding) {
    return {{"severity", severity_name(finding.severity)},
            {"id", finding.id},
            {"where", finding.where},
            {"what", finding.what},
            {"why", finding.why},
            {"fix", finding.fix},
            {"commands", finding.commands}};
}

OrderedJson can_json(const CanInterface& interface) {
    return {{"name", interface.name},
            {"kind", interface.kind},
            {"up", interface.up},
            {"bit_rate", or_null(interface.bit_rate)},
            {"data_bit_rate", or_null(interface.data_bit_rate)},
            {"fd", interface.takes_fd()},
            {"queue_length", interface.queue_length},
            {"restart_ms", or_null(interface.restart_ms)},
            {"transmit_errors", or_null(interface.transmit_errors)},
            {"receive_errors", or_null(interface.receive_errors)}};
}

OrderedJson input_json(const InputFacts& facts) {
    OrderedJson users = OrderedJson::array();
    for (const PortUser& user : facts.users.users) {
        users.push_back(
            {{"process", user.process}, {"command", user.command}, {"unit", user.unit}});
    }
    return {{"node", facts.device.node},
            {"device", facts.device.device},
            {"name", facts.device.name},
            {"address", facts.device.unique},
            {"gamepad", facts.device.is_gamepad()},
            {"axes", facts.device.axes.size()},
            {"buttons", facts.device.buttons.size()},
            {"may_open", facts.access.may_open},
            {"group", facts.access.group},
            {"users", std::move(users)},
            {"configuration", configuration_lines(facts)}};
}

OrderedJson pwm_json(const PwmFacts& facts) {
    constexpr std::int64_t kMicrosecond = 1000;
    OrderedJson taken = OrderedJson::array();
    for (const auto& [output, state] : facts.taken) {
        taken.push_back({{"output", output},
                         {"on", state.on},
                         {"pulse_us", state.pulse.count() / kMicrosecond},
                         {"period_us", state.period.count() / kMicrosecond}});
    }
    return {{"name", facts.chip.name},       {"driver", facts.chip.driver},
            {"outputs", facts.chip.outputs}, {"may_use", facts.access.may_open},
            {"group", facts.access.group},   {"taken", std::move(taken)}};
}

OrderedJson uinput_json(const UinputFacts& facts) {
    return {{"exists", facts.access.exists},
            {"may_open", facts.access.may_open},
            {"group", facts.access.group}};
}

OrderedJson gpio_json(const GpioFacts& facts) {
    OrderedJson lines = OrderedJson::array();
    for (const unsigned offset : facts.asked) {
        const GpioLineFacts& line = facts.chip.lines[offset];
        lines.push_back({{"line", offset},
                         {"name", line.name},
                         {"used", line.used},
                         {"consumer", line.consumer}});
    }
    return {{"chip", facts.chip.path},
            {"lines", facts.chip.lines.size()},
            {"asked", std::move(lines)},
            {"configuration", configuration_lines(facts)}};
}

OrderedJson loopback_json(const SpiLoopback& loopback) {
    return {{"sent", loopback.sent},
            {"right", loopback.right},
            {"silent", loopback.silent},
            {"rate_hz", loopback.hz},
            {"byte_before_ns", loopback.byte_before.count()},
            {"byte_after_ns", loopback.byte_after.count()}};
}

OrderedJson spi_json(const SpiFacts& facts) {
    return {{"device", facts.device},
            {"exists", facts.access.exists},
            {"may_open", facts.access.may_open},
            {"group", facts.access.group},
            {"refusal", or_null(facts.refusal)},
            {"no_output", facts.no_output},
            {"loopback", facts.loopback ? loopback_json(*facts.loopback) : OrderedJson()},
            {"configuration", configuration_lines(facts)}};
}

}  // namespace

std::string report_json(const Report& report) {
    OrderedJson json = {{"machine", report.machine ? machine_json(*report.machine) : OrderedJson()},
                        {"ports", OrderedJson::array()},
                        {"can", OrderedJson::array()},
                        {"inputs", OrderedJson::array()},
                        {"pwm", OrderedJson::array()},
                        {"uinput", report.uinput ? uinput_json(*report.uinput) : OrderedJson()},
                        {"gpio", OrderedJson::array()},
                        {"spi", OrderedJson::array()},
                        {"findings", OrderedJson::array()}};
    for (const ExaminedPort& port : report.ports) {
        json["ports"].push_back(port_json(port));
    }
    for (const CanInterface& interface : report.can) {
        json["can"].push_back(can_json(interface));
    }
    for (const InputFacts& facts : report.inputs) {
        json["inputs"].push_back(input_json(facts));
    }
    for (const PwmFacts& facts : report.pwm) {
        json["pwm"].push_back(pwm_json(facts));
    }
    for (const GpioFacts& facts : report.gpio) {
        json["gpio"].push_back(gpio_json(facts));
    }
    for (const SpiFacts& facts : report.spi) {
        json["spi"].push_back(spi_json(facts));
    }
    for (const Finding& finding : report.findings) {
        json["findings"].push_back(finding_json(finding));
    }
    // Bytes that are not UTF-8, of file names for example, are replaced.
    return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace tribus::doctor
