#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/time.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

/// Pairs the frames of an i.Bus sensor bus into requests and replies.
namespace tribus {

/// A frame with the start of its first and the end of its last byte, if the recording has times.
struct ReceivedSensorFrame {
    SensorFrame frame;
    std::optional<Duration> start{};
    std::optional<Duration> end{};
};

enum class SensorOutcome : std::uint8_t {
    answered,
    missed,    ///< no reply to a request for a type or a value
    free,      ///< no reply to discover: the address is free
    cut,       ///< the recording ends before a reply could have come
    unasked,   ///< a reply without a request
    power_up,  ///< the receiver's power-up frame, which has no reply
};

/// What a sensor reported as its type.
struct ReportedType {
    std::uint8_t id = 0;
    std::uint8_t size = 0;
};

/// A request with its result.
struct SensorExchange {
    SensorOutcome outcome = SensorOutcome::answered;
    /// The request; for an unasked reply, the reply.
    ReceivedSensorFrame asked;
    std::optional<ReceivedSensorFrame> answer{};
    /// From the end of the request, or of its last echo, to the start of the reply.
    std::optional<Duration> response_time{};
    /// How often the recorder received the request again as its echo.
    unsigned echoes = 0;
    /// The receiver's next request is the same.
    bool asked_again = false;
    /// The type that the sensor at this address has reported so far, this exchange included.
    std::optional<ReportedType> type{};
};

/// Counts of exchanges. `requests` excludes the `probes` of free addresses.
struct SensorCounts {
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t probes = 0;
    std::uint64_t misses = 0;
    std::uint64_t misses_asked_again = 0;
    std::uint64_t discover = 0;  ///< requests of each command, with probes
    std::uint64_t type = 0;
    std::uint64_t value = 0;
    std::uint64_t power_up = 0;
    std::uint64_t echoes = 0;
    std::uint64_t unasked = 0;
};

struct SensorAddressCounts {
    std::optional<ReportedType> type{};
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t misses = 0;
    std::uint64_t probes = 0;
    std::vector<Duration> response_times{};
};

/// Pairs requests with their replies. Reports an exchange as soon as it is decided: an answered one
/// with its reply, others with the next frame.
///
/// If the same request comes again within kLongestSensorPause it is an echo. If it comes later, or
/// if there are no times, it is a repetition: a receiver leaves 7.7 ms between two requests. A
/// reply to discover has the same bytes as the request. The next request tells it from an echo: the
/// receiver asks a sensor that replied for its type. If the recording ends there, it counts as a
/// reply, unless other requests had echoes; without times it does not. Thread-bound.
class SensorConversation {
  public:
    explicit SensorConversation(std::function<void(const SensorExchange&)> handler);

    /// Takes the next frame of the recording.
    void take(const ReceivedSensorFrame& received);
    /// Call it after the last frame.
    void finish();

    const SensorCounts& counts() const { return counts_; }
    /// By address; index 0 is unused.
    const std::array<SensorAddressCounts, kMostSensors + 1>& addresses() const {
        return addresses_;
    }

  private:
    void take_request(const ReceivedSensorFrame& received);
    void take_answer(const ReceivedSensorFrame& received);
    bool is_pending(const ReceivedSensorFrame& received) const;
    void resolve(const ReceivedSensorFrame* next);
    void resolve_discover(const ReceivedSensorFrame* next);
    void leave_unanswered(const ReceivedSensorFrame& asked, unsigned echoes,
                          const ReceivedSensorFrame* next);
    void answer(const ReceivedSensorFrame& asked, unsigned echoes,
                const ReceivedSensorFrame& asked_end, const ReceivedSensorFrame& answer);
    void report(SensorExchange exchange);
    void count(const SensorExchange& exchange);

    std::function<void(const SensorExchange&)> handler_;
    /// An undecided request, followed by copies of it that are echoes or replies.
    std::vector<ReceivedSensorFrame> pending_;
    SensorCounts counts_;
    std::array<SensorAddressCounts, kMostSensors + 1> addresses_;
};

}  // namespace tribus
