#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/doctor/facts/kernel_files.h"

namespace tribus::doctor {

/// Facts about the machine; unknown ones are empty.
struct MachineFacts {
    std::string model;         ///< from the device tree; empty on PCs
    std::string kernel;        ///< kernel release
    std::string architecture;  ///< in the kernel's words: "aarch64"
    bool realtime_kernel = false;
    /// Microseconds of each second that real-time threads may use; -1: all.
    std::optional<std::int64_t> realtime_share_us;
    /// The same for this program's control group (version 1), if the kernel has that.
    std::optional<std::int64_t> group_share_us;

    /// Frequency governors of the processors, without duplicates.
    std::vector<std::string> governors;
    std::string frequency_driver;
    /// From the firmware of a Raspberry Pi: bit 0 undervoltage, 1 frequency capped, 2 throttled, 3
    /// hot; bits 16 to 19: the same since the start.
    std::optional<std::int64_t> throttled;
    /// From the voltage monitor of a Raspberry Pi.
    std::optional<bool> undervoltage;
    std::optional<double> temperature;  ///< degC, hottest zone

    bool may_schedule = false;                   ///< CAP_SYS_NICE
    bool may_lock = false;                       ///< CAP_IPC_LOCK
    std::optional<std::int64_t> priority_limit;  ///< RLIMIT_RTPRIO; empty: unlimited
    std::optional<std::int64_t> lock_limit;      ///< RLIMIT_MEMLOCK in bytes; empty: unlimited

    /// ModemManager runs; it probes each new serial device for a modem.
    bool modem_manager = false;
};

/// Reads a few small files; opens nothing that could disturb other programs.
MachineFacts look_at_machine(const KernelFiles& files);

}  // namespace tribus::doctor
