#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/appliance/appliance.h"
#include "config/schema/schema.h"
#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/realtime/histogram.h"
#include "pipelines/realtime/loop.h"

/// Everything that a running configuration knows about itself, for log, monitor, status and
/// metrics.
namespace tribus {

struct InputReport {
    InputStatus status;
    std::vector<std::string_view> reject_causes;  ///< names of the counters in `status.rejected_by`
    double rate_hz = 0;                           ///< frames received in the last second
    HistogramReading frame_age;  ///< how old a frame was when the next one came, last minute
};

struct OutputReport {
    OutputStatus status;
    std::vector<std::size_t> inputs;  ///< inputs that may control it, in order of preference
    double rate_hz = 0;               ///< frames sent in the last second
    HistogramReading lateness;        ///< from due to taken, last minute
    HistogramReading latency;         ///< from an input's frame to the output's, last minute
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
    dronecan::NodeId wanted = dronecan::kNobody;  ///< as configured
    dronecan::NodeReport report;
};

struct ValueReport {
    NamedValue value;
    ValueStatus status;
};

/// Whether tribus makes the value of that name of an input or output, which is told anyway.
bool is_of_part(std::string_view name);
/// Whether its number says something about `now`.
bool is_fresh(const ValueStatus& status, Duration lasts, Instant now);
inline bool is_fresh(const ValueReport& value, Instant now) {
    return is_fresh(value.status, value.value.lasts, now);
}

struct LineReport {
    bool present = false;
    std::optional<bool> active;
};

/// State at `now`; the data thread published the figures at `figures_at`. The lists are in the
/// order of `configuration`, which must outlive the report.
struct StatusReport {
    const Configuration* configuration = nullptr;
    Instant now{};
    Duration wall_time{};  ///< since 1970
    Instant started{};
    Instant figures_at{};
    std::optional<Duration>
        trial_left;  ///< time until the configuration on trial goes back by itself
    std::optional<std::uint64_t> trial;  ///< its number
    std::string fingerprint;             ///< of the configuration with every default
    std::string text;                    ///< all inputs and outputs in one line: `status_line`
    std::vector<std::string> missing_realtime;
    AbsenceStatus absence;
    std::uint64_t changes = 0;  ///< number of the newest change of state
    std::vector<InputReport> inputs;
    std::vector<OutputReport> outputs;
    std::vector<PortReport> ports;
    std::vector<LineReport> lines;
    std::vector<SensorBusState> sensor_buses;
    std::vector<NodeStatus> nodes;
    std::vector<ValueReport> values;
    std::vector<std::optional<double>>
        machine;  ///< in the order of `kMachineFacts`; empty: not read
};
/// The daemon's name: that of its configuration file without extension.
std::string name_of(const StatusReport& report);

/// Words for `CanBusState`, in its order, and at the end the one for an interface that is not
/// present.
inline constexpr std::array<std::string_view, 7> kCanStateWords{
    "ready", "warning", "passive", "stalled", "bus_off", "down", "gone"};
/// One of them. `port` is a CAN interface.
std::string_view can_state_word(const PortReport& port);

/// The line of all inputs and outputs of an appliance. Main thread.
std::string status_line(const Appliance& appliance, Instant now);

/// Frames per second, from a counter that is read now and then. Pure.
class RateWindow {
  public:
    /// `count` is the counter at `at`, an instant of the data thread, so that the rate is exact.
    void look(std::uint64_t count, Instant at);
    /// To a tenth. Zero if the last `look` is older than the window: a frozen data thread has no
    /// rate.
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

    /// Updates the rates. Call it a few times a second.
    void look(const Appliance& appliance);
    /// The present state; refers to the configuration of `appliance`.
    StatusReport report(const Appliance& appliance, Instant now, Duration wall_time) const;

  private:
    Instant started_;
    std::vector<RateWindow> inputs_;
    std::vector<RateWindow> outputs_;
    /// CAN interfaces of the DroneCAN nodes, and their configured ids.
    std::vector<std::pair<std::string, dronecan::NodeId>> nodes_;
};

}  // namespace tribus
