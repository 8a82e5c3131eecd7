#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include <tl/expected.hpp>

#include "config/schema.h"
#include "core/can_frame.h"
#include "core/time.h"

/// Recordings as what arrives at the inputs of a configuration, for `simulate`.
namespace tribus {

struct ArrivedByte {
    std::uint8_t value = 0;
    bool damaged = false;
};
/// One of `Arrivals::can_frames`.
struct ArrivedCanFrame {
    std::size_t index = 0;
};

/// At the instant at which its last bit is there.
struct Arrival {
    Instant at;
    std::size_t input = 0;
    std::variant<ArrivedByte, ArrivedCanFrame> what;
};

struct Arrivals {
    std::vector<Arrival> in_order;
    std::vector<CanFrame> can_frames;
};

/// Reads the recordings of some inputs, by their indices; each starts at the zero of the
/// simulation. Of a log of candump an input takes the frames of its own interface or, where the
/// log names another one only, all. The error is `file: text` or `file:line:column: text`.
tl::expected<Arrivals, std::string> load_arrivals(const std::map<std::size_t, std::string>& files,
                                                  const Configuration& configuration);

}  // namespace tribus
