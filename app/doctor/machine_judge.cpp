#include "app/doctor/machine_judge.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace tribus::doctor {
namespace {

constexpr std::string_view kMachine = "machine";
/// Temperature in degC at which a Raspberry Pi begins to slow down.
constexpr double kHotDegrees = 80;
/// Default priority of `tribus run`.
constexpr std::int64_t kUsualPriority = 80;
/// More bytes than a running configuration locks.
constexpr std::int64_t kEnoughLocked = std::int64_t{32} << 20;

class Findings {
  public:
    void add(Severity severity, std::string_view id, std::string what, std::string why,
             std::string fix, std::vector<std::string> commands = {}) {
        all_.push_back({severity, id, std::string(kMachine), std::move(what), std::move(why),
                        std::move(fix), std::move(commands)});
    }
    std::vector<Finding> take() { return std::move(all_); }

  private:
    std::vector<Finding> all_;
};

void judge_power(const MachineFacts& facts, Findings& findings) {
    constexpr std::int64_t kUndervoltage = 0x1;
    constexpr std::int64_t kSlowed = 0xE;
    constexpr std::int64_t kEver = 0xF0000;
    const std::int64_t bits = facts.throttled.value_or(0);
    if ((bits & kUndervoltage) != 0 || facts.undervoltage == true) {
        findings.add(Severity::problem, "machine.undervoltage",
                     "the supply of the board is too low now",
                     "The board slows down, USB adapters drop out, and it may stop at any time.",
                     "Give it its own supply that keeps 5 V at 3 A, over a short thick cable; "
                     "never use the servos' regulator.");
    }
    if ((bits & kSlowed) != 0) {
        findings.add(Severity::problem, "machine.throttled",
                     fmt::format("the processor is slowed down now (get_throttled {:#x})", bits),
                     "A slower processor makes frames late.",
                     "Cool it or fix its supply; then check with `vcgencmd get_throttled`.");
    } else if ((bits & kEver) != 0) {
        findings.add(
            Severity::advice, "machine.was_throttled",
            fmt::format(
                "since its start the board had undervoltage or was too hot (get_throttled {:#x})",
                bits),
            "It will happen again, in flight or at full load.",
            "Use a better supply or a heat sink; the next start clears these bits.");
    }
    if (!facts.throttled && facts.model.starts_with("Raspberry Pi")) {
        findings.add(Severity::note, "machine.throttling_unknown",
                     "this kernel does not report whether the board is throttled", "",
                     "Ask the firmware; 0x0 means no throttling:", {"vcgencmd get_throttled"});
    }
    if (facts.temperature && *facts.temperature >= kHotDegrees) {
        findings.add(Severity::advice, "machine.hot",
                     fmt::format("its temperature is {:.0f} degC", *facts.temperature),
                     "Boards slow down at 80 to 85 degC.", "Add a heat sink or a fan.");
    }
}

void judge_frequency(const MachineFacts& facts, Findings& findings) {
    // These two drivers use the name for an ordinary, load-driven governor.
    const bool load_driven = facts.frequency_driver.starts_with("intel_pstate") ||
                             facts.frequency_driver.starts_with("amd-pstate");
    const bool slowest =
        std::ranges::find(facts.governors, "powersave") != facts.governors.end() && !load_driven;
    if (slowest) {
        findings.add(Severity::advice, "machine.powersave",
                     "the processor is kept at its lowest frequency (governor powersave)",
                     "Every wake-up takes several times longer than necessary.",
                     "Let it run at its highest frequency:",
                     {"echo performance | sudo tee "
                      "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"});
    }
}

/// Debian's package, if the kernel is Debian's; Raspberry Pi OS has its own kernel.
std::string realtime_package(const MachineFacts& facts) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kArchitectures{
        {{"x86_64", "amd64"}, {"aarch64", "arm64"}, {"armv7l", "armmp"}}};
    const bool own_kernel = facts.model.starts_with("Raspberry Pi");
    for (const auto& [kernel, debian] : kArchitectures) {
        if (facts.architecture == kernel && !own_kernel) {
            return fmt::format("linux-image-rt-{}", debian);
        }
    }
    return {};
}

void judge_realtime(const MachineFacts& facts, Findings& findings) {
    if (!facts.realtime_kernel) {
        const std::string package = realtime_package(facts);
        findings.add(Severity::advice, "machine.kernel_not_realtime",
                     fmt::format("the kernel {} is not PREEMPT_RT", facts.kernel),
                     "It works, but now and then a frame is late by milliseconds instead of tenths "
                     "of one. `tribus bench` measures it.",
                     package.empty() ? "If there is a PREEMPT_RT kernel for this board, use it."
                                     : "Debian has one:",
                     package.empty() ? std::vector<std::string>{}
                                     : std::vector{"sudo apt install " + package});
    }
    if (facts.realtime_share_us == 0) {
        findings.add(
            Severity::problem, "machine.realtime_off",
            "real-time threads get no time at all (kernel.sched_rt_runtime_us is 0)",
            "`tribus run` cannot get SCHED_FIFO; with realtime = \"require\" it does not start.",
            "Set the usual share:", {"sudo sysctl -w kernel.sched_rt_runtime_us=950000"});
    }
    if (facts.group_share_us == 0) {
        findings.add(Severity::advice, "machine.realtime_group_off",
                     "the control group of this shell has no real-time share "
                     "(cpu.rt_runtime_us is 0)",
                     "A program that is started from here gets no SCHED_FIFO, not even as root.",
                     "Start it as a service, or use a kernel without CONFIG_RT_GROUP_SCHED.");
    }
}

void judge_rights(const MachineFacts& facts, Findings& findings) {
    constexpr std::string_view kServiceHasIt =
        "The service tribus@NAME has it. For `tribus run` from a shell, add one line each to "
        "/etc/security/limits.d/tribus.conf and log in again:";
    if (!facts.may_schedule && facts.priority_limit.value_or(kUsualPriority) < kUsualPriority) {
        findings.add(Severity::advice, "machine.no_realtime_right",
                     fmt::format("this user may use real-time priorities only up to {}",
                                 *facts.priority_limit),
                     "Any busy program can make frames late by several milliseconds.",
                     std::string(kServiceHasIt),
                     {"echo '@dialout - rtprio 90' | sudo tee -a "
                      "/etc/security/limits.d/tribus.conf"});
    }
    if (!facts.may_lock && facts.lock_limit.value_or(kEnoughLocked) < kEnoughLocked) {
        findings.add(
            Severity::advice, "machine.no_memory_right",
            fmt::format("this user may lock only {} kB of memory", *facts.lock_limit / 1024),
            "Memory that is swapped out or not yet loaded makes a frame late.",
            std::string(kServiceHasIt),
            {"echo '@dialout - memlock unlimited' | sudo tee -a "
             "/etc/security/limits.d/tribus.conf"});
    }
    if (facts.modem_manager) {
        findings.add(
            Severity::advice, "machine.modem_manager", "ModemManager runs",
            "It opens USB serial devices that are plugged in and sends commands to them, "
            "to see whether they are modems: servos and receivers get those.",
            "If this machine has no modem:", {"sudo systemctl disable --now ModemManager"});
    }
}

}  // namespace

std::vector<Finding> judge_machine(const MachineFacts& facts) {
    Findings findings;
    judge_power(facts, findings);
    judge_frequency(facts, findings);
    judge_realtime(facts, findings);
    judge_rights(facts, findings);
    return findings.take();
}

}  // namespace tribus::doctor
