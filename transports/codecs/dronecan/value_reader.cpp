#include "transports/codecs/dronecan/value_reader.h"

#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "transports/codecs/dronecan/numbers.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types.h"

namespace tribus::dronecan {
namespace {

/// In the order of kValueMessages.
using ValueTypes = std::tuple<BatteryInfo, CircuitStatus, EscStatus, EscStatusExtended, GnssFix2,
                              DeviceTemperature, StaticPressure, StaticTemperature, FuelTankStatus,
                              Rpm, BatteryCells, BatteryInfoAux>;

/// Calls `visit.operator()<T>()` for the type with that name.
template <class Visit>
void with_type(std::string_view message, Visit visit) {
    const auto try_one = [&]<class T>(const T*) {
        if (message == T::kName) {
            visit.template operator()<T>();
        }
    };
    [&]<class... T>(const std::tuple<T...>*) {
        static_assert([]<std::size_t... kAt>(std::index_sequence<kAt...>) {
            return ((T::kName == kValueMessages[kAt]) && ...);
        }(std::index_sequence_for<T...>{}));
        (try_one(static_cast<const T*>(nullptr)), ...);
    }(static_cast<const ValueTypes*>(nullptr));
}

struct NoInstance {
    static constexpr std::string_view kField{};
    template <class T>
    std::uint32_t operator()(const T&) const {
        return 0;
    }
};

/// Number of the battery, motor or sensor on its node that a message is about.
template <class T>
struct InstanceOf : NoInstance {};
template <>
struct InstanceOf<BatteryInfo> {
    static constexpr std::string_view kField = "battery_id";
    std::uint32_t operator()(const BatteryInfo& message) const { return message.battery_id; }
};
template <>
struct InstanceOf<BatteryInfoAux> {
    static constexpr std::string_view kField = "battery_id";
    std::uint32_t operator()(const BatteryInfoAux& message) const { return message.battery_id; }
};
template <>
struct InstanceOf<CircuitStatus> {
    static constexpr std::string_view kField = "circuit_id";
    std::uint32_t operator()(const CircuitStatus& message) const { return message.circuit_id; }
};
template <>
struct InstanceOf<EscStatus> {
    static constexpr std::string_view kField = "esc_index";
    std::uint32_t operator()(const EscStatus& message) const { return message.esc_index; }
};
template <>
struct InstanceOf<EscStatusExtended> {
    static constexpr std::string_view kField = "esc_index";
    std::uint32_t operator()(const EscStatusExtended& message) const { return message.esc_index; }
};
template <>
struct InstanceOf<DeviceTemperature> {
    static constexpr std::string_view kField = "device_id";
    std::uint32_t operator()(const DeviceTemperature& message) const { return message.device_id; }
};
template <>
struct InstanceOf<FuelTankStatus> {
    static constexpr std::string_view kField = "fuel_tank_id";
    std::uint32_t operator()(const FuelTankStatus& message) const { return message.fuel_tank_id; }
};
template <>
struct InstanceOf<Rpm> {
    static constexpr std::string_view kField = "sensor_id";
    std::uint32_t operator()(const Rpm& message) const { return message.sensor_id; }
};

/// Whether the number of a field, given by its address, is marked as unknown.
template <class T>
bool is_unknown(const T&, const void*) {
    return false;
}
bool is_unknown(const BatteryInfo& message, const void* field) {
    return field == &message.state_of_health_pct &&
           message.state_of_health_pct == BatteryInfo::kStateOfHealthUnknown;
}
bool is_unknown(const BatteryInfoAux& message, const void* field) {
    return field == &message.timestamp.usec && message.timestamp.usec == Timestamp::kUnknown;
}
bool is_unknown(const Rpm& message, const void* field) {
    return field == &message.rpm && (message.flags & Rpm::kUnhealthy) != 0;
}
bool is_unknown(const GnssFix2& message, const void* field) {
    if (field == &message.timestamp.usec) {
        return message.timestamp.usec == Timestamp::kUnknown;
    }
    if (field == &message.gnss_timestamp.usec) {
        return message.gnss_time_standard == GnssFix2::kTimeStandardNone;
    }
    if (field == &message.num_leap_seconds) {
        return message.num_leap_seconds == GnssFix2::kLeapSecondsUnknown;
    }
    if (field == &message.height_ellipsoid_mm || field == &message.height_msl_mm ||
        field == &message.ned_velocity[2]) {
        return message.status < GnssFix2::kStatus3dFix;
    }
    const bool tells_fix = field == &message.sats_used || field == &message.status ||
                           field == &message.mode || field == &message.sub_mode ||
                           field == &message.gnss_time_standard;
    return !tells_fix && message.status < GnssFix2::kStatus2dFix;
}

/// Numbers that are computed from those of a message.
template <class T, class Visit>
void walk_derived(const T&, Visit&) {}
template <class Visit>
void walk_derived(const GnssFix2& message, Visit& visit) {
    const double north = message.ned_velocity[0];
    const double east = message.ned_velocity[1];
    visit.enter("ground_speed");
    visit.number(&message.ned_velocity, std::sqrt(north * north + east * east), "m/s");
    visit.leave();
}

/// Collects names and units.
class NumberNames {
  public:
    void enter(std::string_view name) {
        lengths_.push_back(path_.size());
        path_ += path_.empty() ? "" : ".";
        path_ += name;
    }
    void enter(std::size_t index) {
        lengths_.push_back(path_.size());
        path_ += "[" + std::to_string(index) + "]";
    }
    void leave() {
        path_.resize(lengths_.back());
        lengths_.pop_back();
    }
    void number(const void*, double, std::string_view unit) { missing(unit); }
    void missing(std::string_view unit) { values_.push_back({path_, std::string(unit)}); }

    std::vector<CanValueReader::Value> values() && { return std::move(values_); }

  private:
    std::string path_;
    std::vector<std::size_t> lengths_;
    std::vector<CanValueReader::Value> values_;
};

/// Fills in readings.
template <class T>
class NumberReadings {
  public:
    NumberReadings(const T& message, std::span<ValueReading> readings)
        : message_(message), readings_(readings) {}

    void enter(std::string_view) {}
    void enter(std::size_t) {}
    void leave() {}
    void number(const void* field, double number, std::string_view unit) {
        if (!std::isfinite(number) || is_unknown(message_, field)) {
            missing(unit);
        } else {
            readings_[next_++] = {.state = ValueReading::State::number, .number = number};
        }
    }
    void missing(std::string_view) {
        readings_[next_++] = {.state = ValueReading::State::not_available};
    }

  private:
    const T& message_;
    std::span<ValueReading> readings_;
    std::size_t next_ = 0;
};

template <class T>
class ValueReader final : public CanValueReader {
  public:
    ValueReader(const SourceChoice& choice, bool fd)
        : fd_(fd),
          wanted_(ids_of(TransferKind::message, T::kId)),
          source_(choice),
          receiver_({wanted_transfer<T>()}, choice.node ? 1 : kMostSenders) {
        NumberNames names;
        walk_numbers(T{}, names);
        walk_derived(T{}, names);
        values_ = std::move(names).values();
    }

    bool uses_fd() const override { return fd_; }
    std::span<const CanIdMatch> wanted() const override { return {&wanted_, 1}; }
    std::span<const Value> values() const override { return values_; }
    std::span<const NamedCount> rejected() const override { return rejected_.counts(); }

    std::optional<Instant> take(const CanFrame& frame, Instant at,
                                std::span<ValueReading> readings) override {
        const auto head = wanted_.matches(frame) ? head_of(frame) : std::nullopt;
        if (!head) {
            return std::nullopt;
        }
        if (!source_.may_be(head->source)) {
            rejected_.count_other_source();
            return std::nullopt;
        }
        const auto taken = receiver_.take(frame, at);
        rejected_.count(taken);
        if (!taken.transfer) {
            return std::nullopt;
        }
        const auto message = read<T>(taken.transfer->payload, taken.transfer->fd);
        if (!message) {
            rejected_.count_layout();
            return std::nullopt;
        }
        if (!source_.accepts(head->source, at, InstanceOf<T>{}(*message))) {
            rejected_.count_other_source();
            return std::nullopt;
        }
        NumberReadings<T> filled(*message, readings);
        walk_numbers(*message, filled);
        walk_derived(*message, filled);
        return taken.transfer->first_at;
    }

  private:
    /// Limit of the nodes that send the same message, such as all motors of a machine.
    static constexpr std::size_t kMostSenders = 32;

    bool fd_;
    CanIdMatch wanted_;
    SourceWatch source_;
    TransferReceiver receiver_;
    TransferRejects rejected_;
    std::vector<Value> values_;
};

}  // namespace

std::string_view instance_field(std::string_view message) {
    std::string_view field;
    with_type(message, [&]<class T>() { field = InstanceOf<T>::kField; });
    return field;
}

std::unique_ptr<CanValueReader> make_value_reader(std::string_view message,
                                                  const SourceChoice& source, bool fd) {
    std::unique_ptr<CanValueReader> reader;
    with_type(message, [&]<class T>() { reader = std::make_unique<ValueReader<T>>(source, fd); });
    return reader;
}

}  // namespace tribus::dronecan
