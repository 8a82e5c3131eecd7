#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "tests/sim/simulation.h"
#include "transports/links/can_link.h"
#include "transports/links/faulty_link.h"

/// i.Bus -> tribus A -> CAN -> tribus B -> SBUS under virtual time.
namespace tribus::test {

struct ChainSettings {
    std::string protocol = "can";
    /// Lines for both ends, such as `fd = true`.
    std::string format;
    std::string sender_lines{};
    CanFaultSettings faults{};
    Instant input_ends{};
    Instant end{};
    /// Nothing passes the bus from `bus_dies` until `bus_returns`.
    Instant bus_dies = kNever;
    Instant bus_returns = kNever;
    std::uint64_t seed = 1;
};

/// From the start of one frame on the bus to that of the next: five classic ones take 1.35 ms at
/// 500 kbit/s in the worst case (docs/protocols/can.md, "Bus load").
inline constexpr Duration kCanFrameTime = std::chrono::microseconds(270);
inline constexpr Duration kChainPeriod = std::chrono::milliseconds(7);

class CanChain {
  public:
    explicit CanChain(const ChainSettings& settings);

    const Simulation& a() const { return a_; }
    const Simulation& b() const { return b_; }
    std::size_t snapshots_sent() const { return a_.written_to_can().size(); }
    std::uint64_t snapshots_published() const { return b_.engine().inputs()[0].counts().frames; }
    /// Values of a frame that B wrote: from their arrival at A until B wrote them.
    Duration age(const Written& written) const;

  private:
    Simulation a_;
    Simulation b_;
};

/// Whether all 18 channels are those of the numbered frame that the first three name.
bool whole(const Written& written);

}  // namespace tribus::test
