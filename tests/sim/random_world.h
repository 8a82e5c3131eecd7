#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "core/time.h"
#include "tests/sim/simulation.h"

namespace tribus::test {

/// Protocols of the inputs and outputs.
enum class WorldKind : std::uint8_t { serial, with_can };

/// A random configuration and random receivers with random troubles, all made from one seed. A
/// change of what is drawn, or of the order, makes another world from the same seed.
class RandomWorld {
  public:
    explicit RandomWorld(std::uint64_t seed, WorldKind kind = WorldKind::serial);

    /// End of the world's time. Its troubles end some time earlier.
    static constexpr Instant kEnd = Instant(std::chrono::seconds(34));

    const std::string& text() const { return text_; }
    const std::vector<Sender>& senders() const { return senders_; }
    /// Longest time for which an output may repeat the values of a failed sender unmarked, counted
    /// from the first frame with them. It is longer if the output cannot mark frames.
    Duration longest_unmarked(std::size_t output) const;
    Duration period(std::size_t output) const { return periods_[output]; }
    /// Least time between two frames of the output.
    Duration least_spacing(std::size_t output) const { return least_spacings_[output]; }
    /// Returns whether the output's schedule is a grid that follows the input's frames.
    bool locked(std::size_t output) const { return locked_[output]; }
    /// Longest interval between two frames of a sender.
    Duration longest_interval() const { return longest_interval_; }
    /// Returns whether the output's failsafe is silence. If not, it sends from its first frame on.
    bool falls_silent(std::size_t output) const { return falls_silent_[output]; }
    /// Upper limit of the frames that may pass for good although nobody sent their values, because
    /// SBUS has no checksum.
    std::size_t most_invented() const { return most_invented_; }
    /// Returns whether a frame may combine the values of several input frames.
    bool blends() const { return blends_; }

  private:
    std::size_t below(std::size_t count) { return static_cast<std::size_t>(random_() % count); }
    std::size_t one_to(std::size_t most) { return 1 + below(most); }
    bool chance(unsigned percent) { return below(100) < percent; }
    Duration between(Duration low, Duration high);
    void line(const std::string& text) { text_ += text + "\n"; }
    void duration(std::string_view key, Duration value);

    void add_input(std::size_t index);
    std::string add_port(std::string_view end, std::size_t index, unsigned sbus_percent);
    Duration add_detectors(bool has_flags, bool watches_for_frozen);
    void add_sender(std::size_t index, const std::string& protocol, bool may_freeze);
    void add_output(std::size_t index);
    void add_pipeline();
    void add_failsafe();
    void add_channels();

    std::mt19937_64 random_;
    WorldKind kind_;
    std::string text_;
    std::size_t inputs_ = 0;
    std::size_t outputs_ = 0;
    std::vector<Sender> senders_;
    std::vector<bool> marks_;
    std::vector<bool> falls_silent_;
    std::vector<Duration> periods_;
    std::vector<Duration> least_spacings_;
    std::vector<bool> locked_;
    Duration hold_{};
    Duration longest_unnoticed_{};
    Duration longest_interval_{};
    std::size_t most_invented_ = 0;
    bool blends_ = false;
};

/// Checks every promise against what the world's outputs wrote. Returns the first broken promise as
/// a sentence, or nothing if all are kept.
std::optional<std::string> broken_promise(const RandomWorld& world, const Simulation& simulation);

}  // namespace tribus::test
