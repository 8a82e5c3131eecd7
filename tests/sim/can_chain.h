#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "tests/sim/simulation.h"
#include "transports/links/can/can_link.h"
#include "transports/links/twins/faulty_link.h"

/// The chain i.Bus -> tribus A -> CAN -> tribus B -> SBUS under virtual time.
namespace tribus::test {

struct ChainSettings {
    std::string protocol = "can";
    /// Configuration lines for both ends, such as `fd = true`.
    std::string format;
    std::string sender_lines{};
    CanFaultSettings faults{};
    Instant input_ends{};
    Instant end{};
    /// The bus carries nothing from `bus_dies` until `bus_returns`.
    Instant bus_dies = kNever;
    Instant bus_returns = kNever;
    std::uint64_t seed = 1;
};

/// Time from the start of one frame on the bus to the start of the next: five classic frames take
/// 1.35 ms at 500 kbit/s in the worst case (docs/protocols/can.md, "Bus load").
inline constexpr Duration kCanFrameTime = std::chrono::microseconds(270);
inline constexpr Duration kChainPeriod = std::chrono::milliseconds(7);

class CanChain {
  public:
    explicit CanChain(const ChainSettings& settings);

    const Simulation& a() const { return a_; }
    const Simulation& b() const { return b_; }
    std::size_t snapshots_sent() const { return a_.written_to_can().size(); }
    std::uint64_t snapshots_published() const { return b_.engine().inputs()[0].counts().frames; }
    /// Age of the values in a frame that B wrote, counted from their arrival at A.
    Duration age(const Written& written) const;

  private:
    Simulation a_;
    Simulation b_;
};

/// Returns whether all 18 channels are those of the numbered frame that the first three channels
/// name.
bool whole(const Written& written);

}  // namespace tribus::test
