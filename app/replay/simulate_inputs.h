#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
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
#include "pipelines/virtual_time/virtual_loop.h"

/// Recordings as input of a configuration that runs in virtual time.
namespace tribus {

/// A part of a configuration that can receive a recording.
struct SimulatedSource {
    Station station;
    std::string_view name;
    std::string_view protocol;
    const PortConfig* port = nullptr;
    /// Time between two bursts of a recording without times.
    Duration usual_period{};
    /// Outputs on the same line that read what comes back: they may be asked for a frame.
    std::vector<Station> replies{};
};
/// All sources; inputs come first. They refer to the configuration.
std::vector<SimulatedSource> simulated_sources(const Configuration& configuration);

struct ArrivedByte {
    std::uint8_t value = 0;
    bool damaged = false;
    /// The recording has no times; those used are invented.
    bool untimed = false;
};

/// `at` is the instant of its last bit.
struct Arrival {
    Instant at;
    std::size_t source = 0;
    std::variant<ArrivedByte, CanFrame> what;
};
/// The loop receives what arrives at that source.
void arrive(VirtualLoop& loop, const SimulatedSource& source, const Arrival& arrival);

/// The recordings of some sources, merged by time and read as they are needed. Thread-bound.
class Arrivals {
  public:
    /// Opens files of sources, by their indices. Each recording starts at the zero of the
    /// simulation. Of a candump log, a source takes the frames of its own interface; if the log has
    /// only one other interface, it takes all. The error is `file: text` or
    /// `file:line:column: text`. `sources` must outlive the object.
    static tl::expected<Arrivals, std::string> open(const std::map<std::size_t, std::string>& files,
                                                    std::span<const SimulatedSource> sources);
    Arrivals(Arrivals&&) noexcept;
    Arrivals& operator=(Arrivals&&) noexcept;
    ~Arrivals();

    /// The next arrival, nothing at the end. Valid until the next call. After an error, which is as
    /// above, nothing can be read.
    tl::expected<const Arrival*, std::string> next();

    /// For each recording that is not played to its end: why, as `file:line:column: text`.
    const std::vector<std::string>& rests() const { return rests_; }

  private:
    class Recorded;

    Arrivals();

    /// In the order of the sources.
    std::vector<std::unique_ptr<Recorded>> recordings_;
    std::vector<std::string> rests_;
    /// It gave the latest arrival.
    Recorded* latest_ = nullptr;
};

}  // namespace tribus
