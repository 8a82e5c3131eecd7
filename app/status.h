#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/appliance.h"
#include "config/schema.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/realtime/histogram.h"
#include "pipelines/realtime/loop.h"

/// All that a running configuration knows of itself, for those who tell people.
namespace tribus {

struct InputReport {
    InputStatus status;
    std::vector<std::string_view> reject_causes;  ///< what `status.rejected_by` counts
    double rate_hz = 0;                           ///< frames that came in the last second
    HistogramReading age;                         ///< how old its frames became, last minute
};

struct OutputReport {
    OutputStatus status;
    std::vector<std::size_t> inputs;  ///< that may feed it, the preferred first
    double rate_hz = 0;               ///< frames that went in the last second
    HistogramReading lateness;        ///< of the last minute
    HistogramReading latency;         ///< of the last minute
    std::uint64_t deadline_misses = 0;
};

/// A serial device or CAN interface.
struct PortReport {
    std::string name;
    bool present = true;
    std::optional<CanLinkStatus> can;
};

struct NodeStatus {
    std::string interface;
    dronecan::NodeReport report;
};

struct ValueReport {
    NamedValue value;
    ValueStatus status;
};

/// At `now`; with figures that the data thread wrote down at `figures_at`. Its lists stand in the
/// order of the configuration, which must outlive it.
struct StatusReport {
    const Configuration* configuration = nullptr;
    Instant now{};
    Duration wall_time{};  ///< since 1970
    Instant started{};
    Instant figures_at{};
    std::optional<Duration> trial_left;  ///< until the configuration goes back by itself
    std::vector<std::string> missing_realtime;
    std::vector<InputReport> inputs;
    std::vector<OutputReport> outputs;
    std::vector<PortReport> ports;
    std::vector<bool> lines_present;
    std::vector<SensorBusState> sensor_buses;
    std::vector<NodeStatus> nodes;
    std::vector<ValueReport> values;
    std::vector<std::optional<double>> machine;  ///< by `kMachineFacts`; empty: nobody looked
};

/// Frames a second, from counts that are looked at now and then. Pure.
class RateWindow {
  public:
    /// `count` as it was at `at`; the data thread's own instant, so that the rate is exact.
    void look(std::uint64_t count, Instant at);
    /// Zero where nobody has counted for longer than the window: a frozen data thread has no rate.
    double rate_hz(Instant now) const;

  private:
    static constexpr Duration kWindow = std::chrono::seconds(1);

    Instant begin_{};
    Instant latest_{};
    std::uint64_t begin_count_ = 0;
    bool begun_ = false;
    double rate_ = 0;
};

/// Gathers reports of one appliance. Thread-bound to the main thread.
class StatusKeeper {
  public:
    StatusKeeper(const Appliance& appliance, Instant started);

    /// For the rates; call a few times a second.
    void look(const Appliance& appliance);
    StatusReport report(const Appliance& appliance, Instant now, Duration wall_time) const;

  private:
    Instant started_;
    std::vector<RateWindow> inputs_;
    std::vector<RateWindow> outputs_;
    /// Interfaces of the nodes of DroneCAN.
    std::vector<std::string> nodes_;
};

}  // namespace tribus
