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

/// What its inputs and outputs speak.
enum class WorldKind : std::uint8_t { serial, with_can };

/// A random configuration, and random receivers with random troubles, all of it from one seed. A
/// change of what it draws, or in which order, makes other worlds of the same seeds.
class RandomWorld {
  public:
    explicit RandomWorld(std::uint64_t seed, WorldKind kind = WorldKind::serial);

    /// So long it lasts; its troubles end some time before.
    static constexpr Instant kEnd = Instant(std::chrono::seconds(34));

    const std::string& text() const { return text_; }
    const std::vector<Sender>& senders() const { return senders_; }
    /// So long may the values of a sender that has gone bad be repeated unmarked at an output that
    /// can mark, and at one that cannot, from when they were first sent there.
    Duration longest_unmarked(std::size_t output) const;
    Duration period(std::size_t output) const { return periods_[output]; }
    /// Its schedule is a grid that its input's frames steer.
    bool locked(std::size_t output) const { return locked_[output]; }
    /// Of a sender's frames.
    Duration longest_interval() const { return longest_interval_; }
    /// Its failsafe is silence; else it speaks from its first frame on.
    bool falls_silent(std::size_t output) const { return falls_silent_[output]; }
    /// So many frames of values that nobody sent may pass for good ones: of wires without a
    /// checksum.
    std::size_t most_invented() const { return most_invented_; }
    /// What it writes may be made of the values of several frames.
    bool blends() const { return blends_; }

  private:
    std::size_t below(std::size_t count) { return random_() % count; }
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
    std::vector<bool> locked_;
    Duration hold_{};
    Duration longest_unnoticed_{};
    Duration longest_interval_{};
    std::size_t most_invented_ = 0;
    bool blends_ = false;
};

/// What the world's outputs wrote, held against every promise: the first that was broken, in a
/// sentence; nothing if all were kept.
std::optional<std::string> broken_promise(const RandomWorld& world, const Simulation& simulation);

}  // namespace tribus::test
