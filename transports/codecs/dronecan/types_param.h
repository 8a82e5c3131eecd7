#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>
#include <variant>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// Parameters of a node. Source: the DSDL files of these names in dronecan/DSDL;
/// docs/protocols/can.md, "DroneCAN: nodes".
namespace tribus::dronecan {

struct ParamEmpty {
    static constexpr std::string_view kName = "uavcan.protocol.param.Empty";

    bool operator==(const ParamEmpty&) const = default;

    static constexpr auto fields() { return std::tuple(); }
};

struct ParamValue {
    static constexpr std::string_view kName = "uavcan.protocol.param.Value";

    /// Nothing, an integer, a real number, a boolean (0 or 1) or a text.
    std::variant<ParamEmpty, std::int64_t, float, std::uint8_t, BoundedText<128>> held;

    bool operator==(const ParamValue&) const = default;

    static constexpr auto alternatives() {
        return std::tuple(Alternative<Nested>{"empty"}, Alternative<Signed<64>>{"integer_value"},
                          Alternative<Float32>{"real_value"},
                          Alternative<Unsigned<8>>{"boolean_value"},
                          Alternative<ArrayOf<Unsigned<8>>>{"string_value"});
    }
};

struct ParamNumericValue {
    static constexpr std::string_view kName = "uavcan.protocol.param.NumericValue";

    std::variant<ParamEmpty, std::int64_t, float> held;

    bool operator==(const ParamNumericValue&) const = default;

    static constexpr auto alternatives() {
        return std::tuple(Alternative<Nested>{"empty"}, Alternative<Signed<64>>{"integer_value"},
                          Alternative<Float32>{"real_value"});
    }
};

struct ParamGetSet {
    static constexpr std::string_view kName = "uavcan.protocol.param.GetSet";
    static constexpr std::uint16_t kId = 11;
    static constexpr std::uint64_t kSignature = 0xA7B622F939D1A4D5;

    struct Request {
        using Service = ParamGetSet;
        static constexpr TransferKind kKind = TransferKind::request;

        std::uint16_t index = 0;  ///< index of the parameter, used if the name is empty; 0 to 8191
        ParamValue value;         ///< new value; empty: only reads
        BoundedText<92> name;

        bool operator==(const Request&) const = default;

        static constexpr auto fields() {
            return std::tuple(field<Unsigned<13>>("index", &Request::index),
                              field<Nested>("value", &Request::value),
                              field<ArrayOf<Unsigned<8>>>("name", &Request::name));
        }
    };

    struct Response {
        using Service = ParamGetSet;
        static constexpr TransferKind kKind = TransferKind::response;

        ParamValue value;
        ParamValue default_value;
        ParamNumericValue max_value;
        ParamNumericValue min_value;
        BoundedText<92> name;  ///< empty: there is no such parameter

        bool operator==(const Response&) const = default;

        static constexpr auto fields() {
            return std::tuple(Padding<5>{}, field<Nested>("value", &Response::value), Padding<5>{},
                              field<Nested>("default_value", &Response::default_value),
                              Padding<6>{}, field<Nested>("max_value", &Response::max_value),
                              Padding<6>{}, field<Nested>("min_value", &Response::min_value),
                              field<ArrayOf<Unsigned<8>>>("name", &Response::name));
        }
    };
};

struct ParamExecuteOpcode {
    static constexpr std::string_view kName = "uavcan.protocol.param.ExecuteOpcode";
    static constexpr std::uint16_t kId = 10;
    static constexpr std::uint64_t kSignature = 0x3B131AC5EB69D2CD;

    static constexpr std::uint8_t kSave = 0;   ///< saves all parameters permanently
    static constexpr std::uint8_t kErase = 1;  ///< resets all parameters to their defaults

    struct Request {
        using Service = ParamExecuteOpcode;
        static constexpr TransferKind kKind = TransferKind::request;

        std::uint8_t opcode = kSave;
        std::int64_t argument = 0;  ///< reserved: 0

        bool operator==(const Request&) const = default;

        static constexpr auto fields() {
            return std::tuple(field<Unsigned<8>>("opcode", &Request::opcode),
                              field<Signed<48>>("argument", &Request::argument));
        }
    };

    struct Response {
        using Service = ParamExecuteOpcode;
        static constexpr TransferKind kKind = TransferKind::response;

        std::int64_t argument = 0;  ///< reserved: 0
        bool ok = false;

        bool operator==(const Response&) const = default;

        static constexpr auto fields() {
            return std::tuple(field<Signed<48>>("argument", &Response::argument),
                              field<Boolean>("ok", &Response::ok));
        }
    };
};

}  // namespace tribus::dronecan
