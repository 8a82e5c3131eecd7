#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

/// Discovery of a daemon by Home Assistant: one device with its inputs, outputs, causes and values.
/// Source: Home Assistant, "MQTT", section "Discovery", device discovery (since 2024.11). Pure.
namespace tribus::mqtt {

/// The two payloads of topics of availability.
inline constexpr std::string_view kOnline = "online";
inline constexpr std::string_view kOffline = "offline";

/// Topics of one daemon.
struct DaemonTopics {
    std::string board_availability;  ///< of the bridge: its last will
    std::string availability;        ///< of the daemon
    std::string status;
    std::string event;
};

/// `prefix`/`board`/`daemon`/...
DaemonTopics topics_of(const std::string& prefix, const std::string& board,
                       const std::string& daemon);

/// The topic of the discovery message below Home Assistant's `prefix`.
std::string discovery_topic(const std::string& prefix, const std::string& board,
                            const std::string& daemon);

/// The discovery message of a daemon, from one of its statuses. It changes only with the names of
/// inputs, outputs and values that are told, and with units.
std::string discovery_payload(const DaemonTopics& topics, const std::string& board,
                              const nlohmann::json& status, const std::string& version);

}  // namespace tribus::mqtt
