#pragma once

#include <cstdint>
#include <string_view>
#include <tuple>

#include "transports/codecs/dronecan/fields.h"

namespace tribus::dronecan {

/// Time on the clock that the nodes of the bus share. Source: dronecan/DSDL.
struct Timestamp {
    static constexpr std::string_view kName = "uavcan.Timestamp";

    static constexpr std::uint64_t kUnknown = 0;

    std::uint64_t usec = kUnknown;

    bool operator==(const Timestamp&) const = default;

    static constexpr auto fields() {
        return std::tuple(field<Unsigned<56, Cast::truncated>>("usec", &Timestamp::usec, "us"));
    }
};

}  // namespace tribus::dronecan
