#include "app/doctor/can_judge.h"

#include <cstdint>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace tribus::doctor {
namespace {

// linux/if_arp.h: ARPHRD_CAN.
constexpr std::int64_t kCanHardware = 280;
/// First threshold of both error counters on the way to bus-off.
constexpr std::uint16_t kManyErrors = 96;

class CanFindings {
  public:
    explicit CanFindings(std::string name) : name_(std::move(name)) {}
    void add(Severity severity, std::string_view id, std::string what, std::string why,
             std::string fix, std::vector<std::string> commands = {}) {
        all_.push_back({severity, id, name_, std::move(what), std::move(why), std::move(fix),
                        std::move(commands)});
    }
    /// A controller accepts settings only while it is down.
    std::vector<std::string> set_controller(std::string_view setting) const {
        return {fmt::format("sudo ip link set {} down", name_),
                fmt::format("sudo ip link set {} up type can {}", name_, setting)};
    }
    const std::string& name() const { return name_; }
    std::vector<Finding> take() { return std::move(all_); }

  private:
    std::string name_;
    std::vector<Finding> all_;
};

void judge_state(const CanInterface& interface, Severity hindrance, CanFindings& findings) {
    const bool without_rate = interface.kind == "can" && !interface.bit_rate;
    if (!interface.up) {
        findings.add(hindrance, "can.down",
                     without_rate ? "it is down, and has no bit rate" : "it is down",
                     "Nothing is sent or received; `tribus run` waits for it.",
                     without_rate ? "Bring it up with the bit rate of your bus; the files of "
                                    "deploy/networkd do so at each boot:"
                                  : "Bring it up; the files of deploy/networkd do so at each boot:",
                     {without_rate ? fmt::format("sudo ip link set {} up type can bitrate 1000000 "
                                                 "restart-ms 100",
                                                 findings.name())
                                   : fmt::format("sudo ip link set {} up", findings.name())});
    } else if (interface.state == CanControllerState::bus_off) {
        findings.add(hindrance, "can.bus_off", "its controller is in bus-off and sends nothing",
                     "There were too many errors: wrong bit rate, crossed or open wires, or "
                     "missing termination (60 Ohm between the wires, without power).",
                     "Repair the bus, then:",
                     {fmt::format("sudo ip link set {} type can restart", findings.name())});
    } else if (!interface.lower_up) {
        findings.add(hindrance, "can.no_carrier", "it has no carrier",
                     "Nothing is connected to its other end, or that is down.",
                     "Bring up the other end.");
    } else if (interface.state == CanControllerState::passive ||
               interface.state == CanControllerState::warning ||
               interface.transmit_errors.value_or(0) >= kManyErrors ||
               interface.receive_errors.value_or(0) >= kManyErrors) {
        findings.add(hindrance, "can.errors",
                     fmt::format("its controller counts many errors ({} sending, {} receiving)",
                                 interface.transmit_errors.value_or(0),
                                 interface.receive_errors.value_or(0)),
                     "Errors only in sending: no other node acknowledges. Errors in receiving: "
                     "another bit rate, or bad wires.",
                     "Compare the bit rates, measure 60 Ohm between the wires without power, and "
                     "watch the counters:",
                     {fmt::format("ip -details -statistics link show {}", findings.name())});
    }
}

void judge_modes(const CanInterface& interface, CanFindings& findings) {
    if (interface.listen_only) {
        findings.add(Severity::advice, "can.listen_only", "it is in listen-only mode",
                     "It sends nothing, not even acknowledgements.",
                     "To use it for an output:", findings.set_controller("listen-only off"));
    }
    if (interface.loopback) {
        findings.add(Severity::advice, "can.loopback", "it is in loopback mode",
                     "Its frames do not reach the bus.",
                     "Turn it off:", findings.set_controller("loopback off"));
    }
    if (interface.one_shot) {
        findings.add(Severity::advice, "can.one_shot", "it is in one-shot mode",
                     "A frame that loses arbitration is not repeated.",
                     "Turn it off:", findings.set_controller("one-shot off"));
    }
    if (interface.restart_ms == 0U) {
        findings.add(Severity::advice, "can.no_restart",
                     "after a bus-off it stays silent until somebody restarts it",
                     "After one short circuit RC over it does not come back.",
                     "Let it restart by itself:", findings.set_controller("restart-ms 100"));
    }
    if (interface.queue_length > kMostUsefulQueue) {
        findings.add(
            Severity::advice, "can.long_queue",
            fmt::format("its queue holds {} frames", interface.queue_length),
            "Frames of other programs wait there while no node acknowledges, and are old when they "
            "are sent.",
            "Make it short:", {fmt::format("sudo ip link set {} txqueuelen 16", findings.name())});
    }
    if (!interface.takes_fd()) {
        findings.add(Severity::note, "can.no_fd", "it carries no CAN FD frames",
                     "CAN FD is needed only with fd = true.", "");
    }
}

}  // namespace

std::vector<std::string> can_interfaces(const KernelFiles& files) {
    std::vector<std::string> names;
    for (const std::string& name : files.names_in("sys/class/net")) {
        if (files.number("sys/class/net/" + name + "/type") == kCanHardware) {
            names.push_back(name);
        }
    }
    return names;
}

std::vector<Finding> judge_can(const CanInterface& interface, bool asked_for) {
    CanFindings findings(interface.name);
    judge_state(interface, asked_for ? Severity::problem : Severity::advice, findings);
    judge_modes(interface, findings);
    return findings.take();
}

}  // namespace tribus::doctor
