#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/value_board.h"
#include "pipelines/sensor_bus/role.h"
#include "pipelines/sensor_bus/sensor_role.h"
#include "tests/support/ibus_checksum.h"

/// A bench for both roles of a sensor bus under virtual time.
namespace tribus::test::sensor_bus {

using Bytes = std::vector<std::uint8_t>;
using namespace std::chrono_literals;

inline constexpr Instant kStart{10s};

inline Bytes request(unsigned command_and_address) {
    return with_ibus_checksum({0x04, static_cast<std::uint8_t>(command_and_address)});
}

inline SensorSettings sensor(const char* type, std::size_t value) {
    SensorSettings settings;
    settings.type = *SensorTypes().find(std::string_view(type));
    settings.sources.resize(settings.type.fields.size());
    settings.sources.front() = FieldSource{.value = value};
    return settings;
}

/// Returns what a role writes at its turn. It counts as written.
inline Bytes turn(SensorBusRole& role, Instant now, ValueBoard& board) {
    const auto bytes = role.run(now, board);
    Bytes said(bytes.begin(), bytes.end());
    if (!said.empty()) {
        role.written(now, board);
    }
    return said;
}

}  // namespace tribus::test::sensor_bus
