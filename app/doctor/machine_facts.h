#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/doctor/kernel_files.h"

namespace tribus::doctor {

/// What the machine tells of itself; what it does not tell is nothing.
struct MachineFacts {
    std::string model;         ///< of the device tree; PCs have none
    std::string kernel;        ///< its release
    std::string architecture;  ///< as the kernel calls it: "aarch64"
    bool realtime_kernel = false;
    /// Of each second, that real-time threads may have, in us; -1 is all.
    std::optional<std::int64_t> realtime_share_us;
    /// The same for this program's own control group (version 1), where the kernel has that.
    std::optional<std::int64_t> group_share_us;

    /// Of the processors, each once.
    std::vector<std::string> governors;
    std::string frequency_driver;
    /// Raspberry Pi's firmware: bit 0 undervoltage, 1 frequency capped, 2 throttled, 3 hot; the
    /// same 16 higher: since the start.
    std::optional<std::int64_t> throttled;
    /// Of Raspberry Pi's voltage monitor.
    std::optional<bool> undervoltage;
    std::optional<double> temperature;  ///< degC, of the hottest zone

    bool may_schedule = false;                   ///< CAP_SYS_NICE
    bool may_lock = false;                       ///< CAP_IPC_LOCK
    std::optional<std::int64_t> priority_limit;  ///< RLIMIT_RTPRIO; nothing: unlimited
    std::optional<std::int64_t> lock_limit;      ///< RLIMIT_MEMLOCK in bytes; nothing: unlimited

    /// Asks every new serial device whether it is a modem.
    bool modem_manager = false;
};

/// Reads a few small files; nothing is opened that could disturb anyone.
MachineFacts look_at_machine(const KernelFiles& files);

}  // namespace tribus::doctor
