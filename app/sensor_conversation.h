#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/time.h"
#include "transports/codecs/ibus_sensor.h"

/// What was said on an i.Bus sensor bus: frames to questions and answers.
namespace tribus {

/// A frame with the instants of its first and behind its last byte, where the recording has times.
struct HeardSensorFrame {
    SensorFrame frame;
    std::optional<Duration> start{};
    std::optional<Duration> end{};
};

enum class SensorOutcome : std::uint8_t {
    answered,
    missed,    ///< a type or a value was asked for, and nobody answered
    free,      ///< discover, and nobody answered: nobody has that address
    cut,       ///< the recording ends before an answer could have come
    unasked,   ///< an answer, but nobody had asked for it
    power_up,  ///< the receiver's power-up frame, which nobody answers
};

/// What a sensor said of itself.
struct SaidType {
    std::uint8_t id = 0;
    std::uint8_t size = 0;
};

/// A request and what came of it.
struct SensorExchange {
    SensorOutcome outcome = SensorOutcome::answered;
    /// The request; of an unasked answer, that.
    HeardSensorFrame asked;
    std::optional<HeardSensorFrame> answer{};
    /// From the end of the request, or of its last echo, to the start of the answer.
    std::optional<Duration> response_time{};
    /// How often the recorder heard the request again, as one does that sends it itself.
    unsigned echoes = 0;
    /// The receiver's next request is the same.
    bool asked_again = false;
    /// What the sensor at this address had said of itself before, or says with this.
    std::optional<SaidType> type{};
};

/// Counts of exchanges. Requests are all that somebody has an address for: `probes`, which found
/// nobody, are beside them.
struct SensorCounts {
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t probes = 0;
    std::uint64_t misses = 0;
    std::uint64_t misses_asked_again = 0;
    std::uint64_t discover = 0;  ///< requests of each command, probes too
    std::uint64_t type = 0;
    std::uint64_t value = 0;
    std::uint64_t power_up = 0;
    std::uint64_t echoes = 0;
    std::uint64_t unasked = 0;
};

struct SensorAddressCounts {
    std::optional<SaidType> type{};
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t misses = 0;
    std::uint64_t probes = 0;
    std::vector<Duration> response_times{};
};

/// Pairs requests with their answers. An exchange is told as soon as it is decided: an answered one
/// with its answer, the others with the next frame.
///
/// The same request again is an echo if it comes within kLongestSensorPause, and a repetition
/// otherwise, and wherever there are no times: a receiver leaves 7.7 ms between two. An answer to
/// discover is the same bytes as the request, so it is told from an echo by what the receiver does
/// next: it asks a sensor that answered for its type. If the recording ends there, it is an answer,
/// unless other requests had echoes; without times it is none. Thread-bound.
class SensorConversation {
  public:
    explicit SensorConversation(std::function<void(const SensorExchange&)> handler);

    void hear(const HeardSensorFrame& heard);
    /// No frame follows.
    void finish();

    const SensorCounts& counts() const { return counts_; }
    /// By address; 0 stays empty.
    const std::array<SensorAddressCounts, kMostSensors + 1>& addresses() const {
        return addresses_;
    }

  private:
    void hear_request(const HeardSensorFrame& heard);
    void hear_answer(const HeardSensorFrame& heard);
    bool is_pending(const HeardSensorFrame& heard) const;
    void settle(const HeardSensorFrame* next);
    void settle_discover(const HeardSensorFrame* next);
    void leave_unanswered(const HeardSensorFrame& asked, unsigned echoes,
                          const HeardSensorFrame* next);
    void answer(const HeardSensorFrame& asked, unsigned echoes, const HeardSensorFrame& asked_end,
                const HeardSensorFrame& answer);
    void tell(SensorExchange exchange);
    void count(const SensorExchange& exchange);

    std::function<void(const SensorExchange&)> handler_;
    /// A request that is not settled, and the same bytes again that may be echo or answer.
    std::vector<HeardSensorFrame> pending_;
    SensorCounts counts_;
    std::array<SensorAddressCounts, kMostSensors + 1> addresses_;
};

}  // namespace tribus
