#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// Messages for people to read. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: nodes".
namespace tribus::dronecan {

struct LogLevel {
    static constexpr std::string_view kName = "uavcan.protocol.debug.LogLevel";

    static constexpr std::uint8_t kDebug = 0;
    static constexpr std::uint8_t kInfo = 1;
    static constexpr std::uint8_t kWarning = 2;
    static constexpr std::uint8_t kError = 3;

    std::uint8_t value = 0;

    bool operator==(const LogLevel&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<3>>("value", &LogLevel::value));
    }
};

struct LogMessage {
    static constexpr std::string_view kName = "uavcan.protocol.debug.LogMessage";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 16383;
    static constexpr std::uint64_t kSignature = 0xD654A48E0C049D75;

    LogLevel level;
    BoundedText<31> source;
    BoundedText<90> text;

    bool operator==(const LogMessage&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Nested>("level", &LogMessage::level),
                          field<ArrayOf<Unsigned<8>>>("source", &LogMessage::source),
                          field<ArrayOf<Unsigned<8>>>("text", &LogMessage::text));
    }
};

/// Any named value.
struct KeyValue {
    static constexpr std::string_view kName = "uavcan.protocol.debug.KeyValue";
    static constexpr TransferKind kKind = TransferKind::message;
    static constexpr std::uint16_t kId = 16370;
    static constexpr std::uint64_t kSignature = 0xE02F25D6E0C98AE0;

    float value = 0;
    BoundedText<58> key;

    bool operator==(const KeyValue&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Float32>("value", &KeyValue::value),
                          field<ArrayOf<Unsigned<8>>>("key", &KeyValue::key));
    }
};

}  // namespace tribus::dronecan
