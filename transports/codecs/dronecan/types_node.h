#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// Messages and services of every node. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: nodes".
namespace tribus::dronecan {

using UniqueId = std::array<std::uint8_t, 16>;

struct NodeStatus {
    static constexpr std::string_view kName = "uavcan.protocol.NodeStatus";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 341;
    static constexpr std::uint64_t kSignature = 0x0F0868D0C1A7C6F1;

    static constexpr unsigned kMostPeriodMs = 1000;
    static constexpr unsigned kLeastPeriodMs = 2;
    static constexpr unsigned kOfflineTimeoutMs = 3000;

    static constexpr std::uint8_t kHealthOk = 0;
    static constexpr std::uint8_t kHealthWarning = 1;
    static constexpr std::uint8_t kHealthError = 2;
    static constexpr std::uint8_t kHealthCritical = 3;

    static constexpr std::uint8_t kModeOperational = 0;
    static constexpr std::uint8_t kModeInitialization = 1;
    static constexpr std::uint8_t kModeMaintenance = 2;
    static constexpr std::uint8_t kModeSoftwareUpdate = 3;
    static constexpr std::uint8_t kModeOffline = 7;

    std::uint32_t uptime_sec = 0;
    std::uint8_t health = kHealthOk;
    std::uint8_t mode = kModeOperational;
    std::uint8_t sub_mode = 0;
    std::uint16_t vendor_specific_status_code = 0;

    bool operator==(const NodeStatus&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<32>>("uptime_sec", &NodeStatus::uptime_sec, "s"),
                          field<Unsigned<2>>("health", &NodeStatus::health),
                          field<Unsigned<3>>("mode", &NodeStatus::mode),
                          field<Unsigned<3>>("sub_mode", &NodeStatus::sub_mode),
                          field<Unsigned<16>>("vendor_specific_status_code",
                                              &NodeStatus::vendor_specific_status_code));
    }
};

struct SoftwareVersion {
    static constexpr std::string_view kName = "uavcan.protocol.SoftwareVersion";

    /// Bits of optional_field_flags: which of the fields after it are valid.
    static constexpr std::uint8_t kVcsCommitGiven = 1;
    static constexpr std::uint8_t kImageCrcGiven = 2;

    std::uint8_t major = 0;
    std::uint8_t minor = 0;
    std::uint8_t optional_field_flags = 0;
    std::uint32_t vcs_commit = 0;
    std::uint64_t image_crc = 0;

    bool operator==(const SoftwareVersion&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Unsigned<8>>("major", &SoftwareVersion::major),
            field<Unsigned<8>>("minor", &SoftwareVersion::minor),
            field<Unsigned<8>>("optional_field_flags", &SoftwareVersion::optional_field_flags),
            field<Unsigned<32>>("vcs_commit", &SoftwareVersion::vcs_commit),
            field<Unsigned<64>>("image_crc", &SoftwareVersion::image_crc));
    }
};

struct HardwareVersion {
    static constexpr std::string_view kName = "uavcan.protocol.HardwareVersion";

    std::uint8_t major = 0;
    std::uint8_t minor = 0;
    UniqueId unique_id{};  ///< not all zero
    BoundedArray<std::uint8_t, 255> certificate_of_authenticity;

    bool operator==(const HardwareVersion&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Unsigned<8>>("major", &HardwareVersion::major),
            field<Unsigned<8>>("minor", &HardwareVersion::minor),
            field<ArrayOf<Unsigned<8>>>("unique_id", &HardwareVersion::unique_id),
            field<ArrayOf<Unsigned<8>>>("certificate_of_authenticity",
                                        &HardwareVersion::certificate_of_authenticity));
    }
};

struct GetNodeInfo {
    static constexpr std::string_view kName = "uavcan.protocol.GetNodeInfo";
    static constexpr std::uint16_t kId = 1;
    static constexpr std::uint64_t kSignature = 0xEE468A8121C46A9E;

    struct Request {
        using Service = GetNodeInfo;
        static constexpr TransferKind kKind = TransferKind::request;

        bool operator==(const Request&) const = default;

        static constexpr auto fields() { return std::tuple(); }
    };

    struct Response {
        using Service = GetNodeInfo;
        static constexpr TransferKind kKind = TransferKind::response;

        NodeStatus status;
        SoftwareVersion software_version;
        HardwareVersion hardware_version;
        BoundedText<80> name;  ///< a-z, 0-9, '.', '_', '-'

        bool operator==(const Response&) const = default;

        static constexpr auto fields() {
            return std::tuple(field<Nested>("status", &Response::status),
                              field<Nested>("software_version", &Response::software_version),
                              field<Nested>("hardware_version", &Response::hardware_version),
                              field<ArrayOf<Unsigned<8>>>("name", &Response::name));
        }
    };
};

struct Allocation {
    static constexpr std::string_view kName = "uavcan.protocol.dynamic_node_id.Allocation";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 1;
    static constexpr std::uint64_t kSignature = 0x0B2A812620A11D40;

    /// Random pauses: between requests, and between an answer and the next part of the unique id.
    static constexpr unsigned kLeastRequestPeriodMs = 600;
    static constexpr unsigned kMostRequestPeriodMs = 1000;
    static constexpr unsigned kLeastFollowupDelayMs = 0;
    static constexpr unsigned kMostFollowupDelayMs = 400;
    /// After this time the allocator forgets an unfinished unique id.
    static constexpr unsigned kFollowupTimeoutMs = 500;
    static constexpr std::size_t kMostUniqueIdBytesInRequest = 6;
    static constexpr std::uint8_t kAnyNodeId = 0;

    std::uint8_t node_id = kAnyNodeId;  ///< 0 to 127
    bool first_part_of_unique_id = false;
    BoundedArray<std::uint8_t, 16> unique_id;

    bool operator==(const Allocation&) const = default;

    static constexpr auto fields() {
        return std::tuple(
            field<Unsigned<7>>("node_id", &Allocation::node_id),
            field<Boolean>("first_part_of_unique_id", &Allocation::first_part_of_unique_id),
            field<ArrayOf<Unsigned<8>>>("unique_id", &Allocation::unique_id));
    }
};

struct RestartNode {
    static constexpr std::string_view kName = "uavcan.protocol.RestartNode";
    static constexpr std::uint16_t kId = 5;
    static constexpr std::uint64_t kSignature = 0x569E05394A3017F0;

    static constexpr std::uint64_t kMagicNumber = 0xACCE551B1E;

    struct Request {
        using Service = RestartNode;
        static constexpr TransferKind kKind = TransferKind::request;

        std::uint64_t magic_number = kMagicNumber;

        bool operator==(const Request&) const = default;

        static constexpr auto fields() {
            return std::tuple(field<Unsigned<40>>("magic_number", &Request::magic_number));
        }
    };

    struct Response {
        using Service = RestartNode;
        static constexpr TransferKind kKind = TransferKind::response;

        bool ok = false;

        bool operator==(const Response&) const = default;

        static constexpr auto fields() { return std::tuple(field<Boolean>("ok", &Response::ok)); }
    };
};

struct CanIfaceStats {
    static constexpr std::string_view kName = "uavcan.protocol.CANIfaceStats";

    std::uint64_t frames_tx = 0;
    std::uint64_t frames_rx = 0;
    std::uint64_t errors = 0;

    bool operator==(const CanIfaceStats&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<48>>("frames_tx", &CanIfaceStats::frames_tx),
                          field<Unsigned<48>>("frames_rx", &CanIfaceStats::frames_rx),
                          field<Unsigned<48>>("errors", &CanIfaceStats::errors));
    }
};

struct GetTransportStats {
    static constexpr std::string_view kName = "uavcan.protocol.GetTransportStats";
    static constexpr std::uint16_t kId = 4;
    static constexpr std::uint64_t kSignature = 0xBE6F76A7EC312B04;

    struct Request {
        using Service = GetTransportStats;
        static constexpr TransferKind kKind = TransferKind::request;

        bool operator==(const Request&) const = default;

        static constexpr auto fields() { return std::tuple(); }
    };

    struct Response {
        using Service = GetTransportStats;
        static constexpr TransferKind kKind = TransferKind::response;

        std::uint64_t transfers_tx = 0;
        std::uint64_t transfers_rx = 0;
        std::uint64_t transfer_errors = 0;
        BoundedArray<CanIfaceStats, 3> can_iface_stats;

        bool operator==(const Response&) const = default;

        static constexpr auto fields() {
            return std::tuple(
                field<Unsigned<48>>("transfers_tx", &Response::transfers_tx),
                field<Unsigned<48>>("transfers_rx", &Response::transfers_rx),
                field<Unsigned<48>>("transfer_errors", &Response::transfer_errors),
                field<ArrayOf<Nested>>("can_iface_stats", &Response::can_iface_stats));
        }
    };
};

}  // namespace tribus::dronecan
