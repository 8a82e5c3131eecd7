#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/time.h"
#include "pipelines/engine/carry_over.h"
#include "pipelines/engine/engine.h"

namespace tribus {

/// Facts about an input that are available as named values, input.NAME.FACT.
enum class InputFact : std::uint8_t {
    frame_rate,    ///< Hz, over the last second
    loss_ratio,    ///< %, over the last second: frames marked as lost, and frames that did not come
    age,           ///< ms, age of the latest good frame
    good,          ///< 1 or 0
    cause,         ///< number of the LinkCause
    link_quality,  ///< %, as the latest frame says; only some protocols have it
    // From the latest statistics of the radio link; only some protocols have them.
    rssi,   ///< dBm
    snr,    ///< dB
    power,  ///< mW, of the transmitter
    mode,   ///< number of the rate
};
/// The same for an output, output.NAME.FACT.
enum class OutputFact : std::uint8_t {
    frame_rate,
    failsafe,  ///< 1 or 0; 1 also in the stage cannot_send
    holding,   ///< 1 while held values are sent, marked frame-lost
    cannot_send,
};

/// Last part of the name of a value, and its unit.
struct FactName {
    std::string_view name;
    std::string_view unit;
};
/// In the order of InputFact and OutputFact.
inline constexpr std::array<FactName, 10> kInputFacts{{{"frame_rate", "Hz"},
                                                       {"loss_ratio", "%"},
                                                       {"age", "ms"},
                                                       {"good", ""},
                                                       {"cause", ""},
                                                       {"link_quality", "%"},
                                                       {"rssi", "dBm"},
                                                       {"snr", "dB"},
                                                       {"power", "mW"},
                                                       {"mode", ""}}};
inline constexpr std::array<FactName, 4> kOutputFacts{
    {{"frame_rate", "Hz"}, {"failsafe", ""}, {"holding", ""}, {"cannot_send", ""}}};

/// Health of inputs and outputs as numbers. Pure. Thread-bound. No allocation after construction.
class HealthWatch {
  public:
    /// Covers the first `inputs` inputs and `outputs` outputs of the engine.
    HealthWatch(std::size_t inputs, std::size_t outputs);

    /// Least time between two calls of `look`.
    static constexpr Duration kPeriod = std::chrono::milliseconds(100);

    /// Takes over the history of `before` for each input and output that `carry` names.
    void continue_from(const HealthWatch& before, const EngineCarry& carry);

    /// Samples the counters. Call every kPeriod, so that the samples cover a second.
    void look(const Engine& engine, Instant now);
    /// Number as of the latest `look`. `nullopt` if there is none yet.
    std::optional<double> number(const Engine& engine, std::size_t input, InputFact fact,
                                 Instant now) const;
    std::optional<double> number(const Engine& engine, std::size_t output, OutputFact fact,
                                 Instant now) const;

  private:
    /// Counters of one input or output since the start.
    struct Counts {
        std::uint64_t frames = 0;
        std::uint64_t lost = 0;
    };
    static constexpr std::size_t kLooks = 10;
    using Looks = std::array<Counts, kLooks>;
    static std::size_t place_of(std::uint64_t look) {
        return static_cast<std::size_t>(look % kLooks);
    }

    double rate(const Looks& looks) const;
    double loss_ratio(const Engine& engine, std::size_t input) const;
    const Counts& newest(const Looks& looks) const;
    const Counts& oldest(const Looks& looks) const;
    Duration watched() const;

    std::vector<Looks> inputs_;
    std::vector<Looks> outputs_;
    std::array<Instant, kLooks> looked_at_{};
    std::uint64_t looks_ = 0;
};

}  // namespace tribus
