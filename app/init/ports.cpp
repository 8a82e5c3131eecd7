#include "app/init/ports.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/doctor/can_judge.h"
#include "app/doctor/examine.h"
#include "app/doctor/facts/gpio_facts.h"
#include "app/doctor/facts/input_facts.h"
#include "app/doctor/facts/pwm_facts.h"
#include "app/doctor/facts/spi_facts.h"
#include "app/doctor/listening/listener.h"
#include "app/doctor/serial_judge.h"
#include "transports/links/can/can_interface.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/spi/spi_serial_medium.h"

namespace tribus::init {
namespace {

namespace fs = std::filesystem;
using doctor::Severity;

/// Path of a device; the user may leave out "/dev/".
std::string device_path(const std::string& place) {
    if (place.find('/') == std::string::npos) {
        return "/dev/" + place;
    }
    std::error_code none;
    const fs::path absolute = fs::absolute(place, none);
    return none ? place : absolute.string();
}

/// A symbolic link that the user named is kept. A kernel name is replaced by the stable name if
/// there is one, because kernel names depend on the order in which adapters are plugged in.
std::string stable_name(const std::string& path, const doctor::SerialFacts& facts) {
    std::error_code none;
    return fs::is_symlink(path, none) ? path : facts.device;
}

ExaminedPlace examined_port(const doctor::SerialFacts& facts, doctor::PortOpinion opinion) {
    return {.medium = &kSerialMedium,
            .name = facts.device,
            .node = facts.node,
            .kind = std::move(opinion.kind),
            .facts = facts,
            .findings = std::move(opinion.findings)};
}

ExaminedPlace examined_interface(const std::string& name) {
    ExaminedPlace examined{
        .medium = &kCanMedium, .name = name, .node = name, .kind = "CAN interface"};
    const auto interface = query_can_interface(name);
    if (!interface) {
        examined.findings.push_back(doctor::unknown_interface(name, interface.error()));
        return examined;
    }
    examined.findings = doctor::judge_can(*interface, true);
    return examined;
}

ExaminedPlace examined_spi_port(const doctor::SpiFacts& facts) {
    return {.medium = &kSpiSerialMedium,
            .name = facts.device,
            .node = facts.device,
            .kind = "SPI port: SBUS without an inverter",
            .findings = doctor::judge_spi_port(facts, true)};
}

/// Why `init` writes no lines for this place; empty if it may be a port.
std::string other_end_text(const doctor::KernelFiles& files, const std::string& place) {
    if (doctor::names_input(files, place)) {
        return fmt::format(
            "this is an input device; `tribus learn {}` prints the lines of a gamepad", place);
    }
    if (doctor::names_pwm_chip(files, place)) {
        return "this is a PWM chip; which channel goes to which of its outputs only you know. "
               "/usr/share/doc/tribus/docs/protocols/pwm.md has lines to start from, `tribus pwm` "
               "lists chips";
    }
    if (doctor::names_gpio(place, {})) {
        return "this reads or makes PPM; /usr/share/doc/tribus/docs/protocols/ppm.md has lines to "
               "start from, `tribus doctor " +
               place + "` looks at it";
    }
    if (place == "/dev/uinput" || place == "uinput") {
        return "this makes virtual joysticks; "
               "/usr/share/doc/tribus/docs/protocols/joystick.md has lines to start from";
    }
    return {};
}

/// The interface of this name, whether it exists or not; nothing if the name is a serial device.
std::optional<ExaminedPlace> interface_of(const doctor::KernelFiles& files,
                                          const std::string& place) {
    if (place.find('/') != std::string::npos) {
        return std::nullopt;
    }
    const auto interfaces = doctor::can_interfaces(files);
    if (std::ranges::find(interfaces, place) != interfaces.end()) {
        return examined_interface(place);
    }
    if (fs::exists(device_path(place))) {
        return std::nullopt;
    }
    ExaminedPlace examined = examined_interface(place);
    examined.known = false;
    return examined;
}

}  // namespace

std::vector<ExaminedPlace> MachinePorts::all() {
    std::vector<ExaminedPlace> found;
    for (const doctor::SerialFacts& facts : doctor::look_at_serial_ports(files_)) {
        found.push_back(examined_port(facts, doctor::judge_port(facts, true)));
    }
    for (const doctor::SpiFacts& facts : doctor::look_at_spi_ports(files_)) {
        found.push_back(examined_spi_port(facts));
    }
    for (const std::string& name : doctor::can_interfaces(files_)) {
        found.push_back(examined_interface(name));
    }
    return found;
}

ExaminedPlace MachinePorts::look(const std::string& place) {
    if (std::string why = other_end_text(files_, place); !why.empty()) {
        return {.name = place, .node = place, .kind = {}, .other_end = std::move(why)};
    }
    if (doctor::names_spi_port(place)) {
        return examined_spi_port(doctor::look_at_spi_port(files_, place));
    }
    if (auto interface = interface_of(files_, place)) {
        return *std::move(interface);
    }
    const std::string path = device_path(place);
    const auto facts = doctor::look_at_serial_port(files_, path);
    ExaminedPlace examined = examined_port(facts, doctor::judge_port(facts, true));
    examined.name = stable_name(path, facts);
    return examined;
}

ExaminedPlace MachinePorts::listen(const std::string& place) {
    ExaminedPlace examined = look(place);
    if (examined.medium != &kSerialMedium || listening_ == Duration::zero() ||
        !examined.other_end.empty()) {
        return examined;
    }
    doctor::ExaminedPort port = doctor::examine_port(
        files_, device_path(place), listening_,
        [&](std::string_view words) { says_(fmt::format("{}: {}", examined.node, words)); });
    examined.facts = std::move(port.facts);
    examined.findings = std::move(port.opinion.findings);
    examined.story = port.story;
    return examined;
}

std::string MachinePorts::try_line(ExaminedPlace& examined, const LineSettings& line) {
    if (examined.medium != &kSerialMedium || listening_ == Duration::zero() || !examined.usable()) {
        return {};
    }
    doctor::Visit visit = doctor::try_port(examined.name, line);
    if (!visit.failure.empty()) {
        examined.findings.push_back({Severity::problem, "port.cannot_open", examined.node,
                                     std::move(visit.failure), "", ""});
        return {};
    }
    return std::move(visit.trials.front().refusal);
}

}  // namespace tribus::init
