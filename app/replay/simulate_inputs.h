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

#include "config/schema/schema.h"
#include "core/can_frame.h"
#include "core/time.h"
#include "pipelines/stations/station.h"

/// Recordings as input of a configuration, for `simulate`.
namespace tribus {

/// A part of a configuration that can receive a recording.
struct SimulatedSource {
    Station station;
    std::string_view name;
    std::string_view protocol;
    const PortConfig* port = nullptr;
    /// Time between two bursts of a recording without times.
    Duration usual_period{};
};
/// All sources; inputs come first. They refer to the configuration.
std::vector<SimulatedSource> simulated_sources(const Configuration& configuration);

struct ArrivedByte {
    std::uint8_t value = 0;
    bool damaged = false;
    /// The recording has no times; those used are invented.
    bool untimed = false;
};
/// Index of a frame in `Arrivals::can_frames`.
struct ArrivedCanFrame {
    std::size_t index = 0;
};

/// `at` is the instant of its last bit.
struct Arrival {
    Instant at;
    std::size_t source = 0;
    std::variant<ArrivedByte, ArrivedCanFrame> what;
};

struct Arrivals {
    std::vector<Arrival> in_order;
    std::vector<CanFrame> can_frames;
};

/// Reads the recordings of some sources, by their indices. Each recording starts at the zero of the
/// simulation. Of a candump log, a source takes the frames of its own interface; if the log has
/// only one other interface, it takes all. The error is `file: text` or `file:line:column: text`.
tl::expected<Arrivals, std::string> load_arrivals(const std::map<std::size_t, std::string>& files,
                                                  std::span<const SimulatedSource> sources);

}  // namespace tribus
