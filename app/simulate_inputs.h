#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <tl/expected.hpp>

#include "config/schema.h"
#include "core/can_frame.h"
#include "core/time.h"

/// Recordings as what arrives at a configuration, for `simulate`.
namespace tribus {

/// Something of a configuration that a recording can be played to.
struct SimulatedSource {
    enum class Kind : std::uint8_t { input, sensor_bus, value_message };
    Kind kind = Kind::input;
    /// Of the input or bus; of a message among the messages with values.
    std::size_t index = 0;
    std::string_view name;
    std::string_view protocol;
    const PortConfig* port = nullptr;
    /// Between the bursts of a recording without times.
    Duration usual_period{};
};
/// Its inputs first, in their order. Refers to the configuration.
std::vector<SimulatedSource> simulated_sources(const Configuration& configuration);

struct ArrivedByte {
    std::uint8_t value = 0;
    bool damaged = false;
    /// The recording has no times; those here are made up.
    bool untimed = false;
};
/// One of `Arrivals::can_frames`.
struct ArrivedCanFrame {
    std::size_t index = 0;
};

/// At the instant at which its last bit is there.
struct Arrival {
    Instant at;
    std::size_t source = 0;
    std::variant<ArrivedByte, ArrivedCanFrame> what;
};

struct Arrivals {
    std::vector<Arrival> in_order;
    std::vector<CanFrame> can_frames;
};

/// Reads the recordings of some sources, by their indices; each starts at the zero of the
/// simulation. Of a log of candump a source takes the frames of its own interface or, where the
/// log names another one only, all. The error is `file: text` or `file:line:column: text`.
tl::expected<Arrivals, std::string> load_arrivals(const std::map<std::size_t, std::string>& files,
                                                  std::span<const SimulatedSource> sources);

}  // namespace tribus
