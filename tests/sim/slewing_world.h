#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"

namespace tribus::test {

/// Random receivers with random troubles, and outputs whose channels have limits of their rate of
/// change, with random reloads, stalls and a line that forces failsafe. All is made from one seed.
///
/// Channel 1 has a slew in the map of the pipeline, channel 2 one in the map of each input. Channel
/// 3 has none; its sticks do not move, so that only changeovers and presets move it.
class SlewingWorld final : public StationObserver {
  public:
    explicit SlewingWorld(std::uint64_t seed);
    ~SlewingWorld() override;

    /// Runs the world to its end. Returns the first step that is too large, or nothing.
    std::optional<std::string> too_large_step();

    void wrote(Station station, Instant at, const Transmission& sent) override;

  private:
    struct Stage;
    struct Receiver {
        bool sbus = false;
        Duration interval{};
        Instant next{};
        Instant silent_until{};
        Instant failsafe_until{};
        Instant sticks_stay_until{};
        int first_us = 1500;
        int second_us = 1500;
    };
    /// A frame that an output wrote.
    struct Step {
        Instant at{};
        ChannelFrame frame{};
        bool failsafe = true;
        std::uint64_t failsafe_entries = 0;
        std::uint64_t changeovers = 0;
        double map_slew = 0;
    };

    std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
    bool chance(unsigned percent) { return below(100) < percent; }
    Duration between(Duration low, Duration high);
    double any_rate();
    void draw();
    std::string text() const;
    static std::unique_ptr<Stage> stage_of(const std::string& text);

    void run_to_the_end();
    void trouble(Receiver& receiver, Instant at);
    void send(std::size_t index, Instant at, std::optional<Instant> read_at = {});
    void own_trouble(Instant at);
    void reload(Instant at);
    void stall(Instant since, Instant until);

    void judge(std::size_t output, const Step& before, const Step& now);
    void expect_within(std::size_t output, std::size_t channel, const Step& before, const Step& now,
                       double us_per_second);

    std::mt19937_64 random_;
    std::vector<Receiver> receivers_;
    std::vector<std::string> outputs_;
    std::string mode_;
    std::string action_;
    double map_slew_ = 0;
    double input_slew_ = 0;
    std::optional<double> failsafe_slew_;
    std::optional<double> changeover_;
    Duration hold_{};
    Duration recover_{};
    int trim_us_ = 0;
    bool forced_ = false;

    std::unique_ptr<Stage> stage_;
    std::unique_ptr<VirtualLoop> loop_;
    std::vector<std::optional<Step>> latest_;
    std::optional<std::string> fault_;
};

}  // namespace tribus::test
