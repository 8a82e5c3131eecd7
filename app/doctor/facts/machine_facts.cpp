#include "app/doctor/facts/machine_facts.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string_view>

#include "app/appliance/machine_values.h"
#include "pipelines/engine/machine_facts.h"

namespace tribus::doctor {
namespace {

// linux/capability.h
constexpr unsigned kIpcLock = 14;
constexpr unsigned kSysNice = 23;

std::optional<double> machine_value(const MachineValues& values, std::string_view name) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (kMachineFacts[i].name == name) {
            return values[i];
        }
    }
    return std::nullopt;
}

std::optional<std::int64_t> limit_of(const std::string& limits, std::string_view name) {
    const auto word = KernelFiles::word_behind(limits, name);
    std::int64_t number = 0;
    if (!word ||
        std::from_chars(word->data(), word->data() + word->size(), number).ec != std::errc{}) {
        return std::nullopt;
    }
    return number;
}

bool has_capability(const std::string& status, unsigned number) {
    const std::string word = KernelFiles::word_behind(status, "CapEff:").value_or("0");
    return (std::strtoull(word.c_str(), nullptr, 16) >> number & 1U) != 0;
}

/// cgroups version 1: /proc/self/cgroup has the folder of each controller, as
/// "4:cpu,cpuacct:/user.slice".
std::optional<std::int64_t> group_share(const KernelFiles& files) {
    std::istringstream lines(files.text("proc/self/cgroup"));
    for (std::string line; std::getline(lines, line);) {
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos) {
            continue;
        }
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
        if (controllers.find(",cpu,") == std::string::npos) {
            continue;
        }
        return files.number("sys/fs/cgroup/cpu" + line.substr(second + 1) + "/cpu.rt_runtime_us");
    }
    return std::nullopt;
}

void look_at_frequency(const KernelFiles& files, MachineFacts& facts) {
    for (const std::string& name : files.names_in("sys/devices/system/cpu")) {
        const std::string folder = "sys/devices/system/cpu/" + name + "/cpufreq/";
        const std::string governor = files.line(folder + "scaling_governor");
        const auto known = std::ranges::find(facts.governors, governor);
        if (!governor.empty() && known == facts.governors.end()) {
            facts.governors.push_back(governor);
        }
        if (facts.frequency_driver.empty()) {
            facts.frequency_driver = files.line(folder + "scaling_driver");
        }
    }
}

bool runs(const KernelFiles& files, std::string_view command) {
    return std::ranges::any_of(files.names_in("proc"), [&](const std::string& name) {
        return name.find_first_not_of("0123456789") == std::string::npos &&
               files.line("proc/" + name + "/comm") == command;
    });
}

}  // namespace

MachineFacts look_at_machine(const KernelFiles& files) {
    MachineFacts facts;
    facts.model = files.line("proc/device-tree/model");
    facts.kernel = files.line("proc/sys/kernel/osrelease");
    facts.architecture = files.line("proc/sys/kernel/arch");
    facts.realtime_kernel =
        files.number("sys/kernel/realtime") == 1 ||
        files.text("proc/sys/kernel/version").find("PREEMPT_RT") != std::string::npos;
    facts.realtime_share_us = files.number("proc/sys/kernel/sched_rt_runtime_us");
    facts.group_share_us = group_share(files);
    look_at_frequency(files, facts);
    // The number is hexadecimal, with or without 0x, depending on the kernel.
    if (std::string word = files.line("sys/devices/platform/soc/soc:firmware/get_throttled");
        !word.empty()) {
        facts.throttled = std::strtoll(word.c_str(), nullptr, 16);
    }
    const MachineValues values = MachineWatch(files.at("")).look();
    facts.temperature = machine_value(values, "temperature");
    if (const auto alarm = machine_value(values, "undervoltage")) {
        facts.undervoltage = *alarm != 0;
    }
    const std::string status = files.text("proc/self/status");
    facts.may_schedule = has_capability(status, kSysNice);
    facts.may_lock = has_capability(status, kIpcLock);
    const std::string limits = files.text("proc/self/limits");
    facts.priority_limit = limit_of(limits, "Max realtime priority");
    facts.lock_limit = limit_of(limits, "Max locked memory");
    facts.modem_manager = runs(files, "ModemManager");
    return facts;
}

}  // namespace tribus::doctor
