#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/sim/simulation.h"

/// Random configurations, random receivers with random troubles: fail silent or fail explicit,
/// never fail stale.
namespace tribus::test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kSeeds = 600;
/// Troubles end here; what follows shows that everything comes back.
constexpr Instant kTroublesEnd = Instant(20s);
constexpr Instant kEnd = Instant(34s);

/// A random world, all of it from one seed.
class World {
  public:
    explicit World(std::uint64_t seed) : random_(seed) {
        inputs_ = one_to(4);
        for (std::size_t i = 0; i < inputs_; ++i) {
            add_input(i);
        }
        outputs_ = one_to(3);
        for (std::size_t i = 0; i < outputs_; ++i) {
            add_output(i);
        }
        add_pipeline();
    }

    const std::string& text() const { return text_; }
    const std::vector<Sender>& senders() const { return senders_; }
    /// So long may the values of a sender that has gone bad be repeated unmarked at an output that
    /// can mark, and at one that cannot, from when they were first sent there.
    Duration longest_unmarked(std::size_t output) const {
        return longest_unnoticed_ + (marks_[output] ? 0ms : hold_) + 2 * periods_[output];
    }

  private:
    std::size_t below(std::size_t count) { return random_() % count; }
    std::size_t one_to(std::size_t most) { return 1 + below(most); }
    bool chance(unsigned percent) { return below(100) < percent; }
    Duration between(Duration low, Duration high) {
        return low + std::chrono::milliseconds(below(static_cast<std::size_t>((high - low) / 1ms)));
    }
    void line(const std::string& text) { text_ += text + "\n"; }
    void duration(std::string_view key, Duration value) {
        line(fmt::format("{} = \"{}ms\"", key, value / 1ms));
    }

    void add_input(std::size_t index) {
        const bool sbus = chance(50);
        const Duration timeout = between(150ms, 400ms);
        line(fmt::format("[input.in{}]\nprotocol = \"{}\"\ndevice = \"/dev/in{}\"", index,
                         sbus ? "sbus" : "ibus", index));
        duration("timeout", timeout);
        Duration unnoticed = timeout;
        if (sbus && chance(40)) {
            const Duration run = between(50ms, 900ms);
            duration("frame_lost_run", run);
            unnoticed = std::max(unnoticed, run);
        }
        if (sbus && chance(30)) {
            line(fmt::format("frame_lost_ratio = {}", chance(50) ? "1.0" : "0.5"));
        }
        const bool watches_for_frozen = chance(50);
        if (watches_for_frozen) {
            const Duration frozen = between(300ms, 900ms);
            duration("frozen", frozen);
            unnoticed = std::max(unnoticed, frozen);
        }
        longest_unnoticed_ = std::max(longest_unnoticed_, unnoticed);
        add_sender(index, sbus, watches_for_frozen);
    }

    void add_sender(std::size_t index, bool sbus, bool may_freeze) {
        constexpr std::array kPeriods{Duration(4ms), Duration(7ms), Duration(7700us), Duration(9ms),
                                      Duration(14ms)};
        Sender sender{.input = index,
                      .protocol = sbus ? "sbus" : "ibus",
                      .period = kPeriods[below(kPeriods.size())],
                      .first = Instant(between(0ms, 3s)),
                      .last = kEnd,
                      .first_number = static_cast<std::uint32_t>(200'000 * index)};
        sender.faults.drop_frame = chance(30) ? 0.2 : 0;
        // SBUS has no checksum: a lost byte can make a frame of wrong values, which is a change.
        sender.faults.lose_byte = !sbus && chance(30) ? 0.005 : 0;
        for (Instant at = Instant(between(1s, 6s)); at < kTroublesEnd - 4s;) {
            const auto kind = static_cast<SpellKind>(below(5));
            // Without a flag, and without `frozen`, nobody can tell it from a pilot who holds
            // still.
            const bool invisible =
                kind == SpellKind::frozen ||
                (!sbus && (kind == SpellKind::frame_lost || kind == SpellKind::failsafe));
            const Instant until = at + between(20ms, 4s);
            sender.spells.push_back(
                {at, until, invisible && !may_freeze ? SpellKind::silence : kind});
            at = until + between(10ms, 3s);
        }
        senders_.push_back(sender);
    }

    void add_output(std::size_t index) {
        const bool sbus = chance(60);
        const Duration period = sbus ? between(7ms, 20ms) : between(5ms, 20ms);
        line(fmt::format("[output.out{}]\nprotocol = \"{}\"\ndevice = \"/dev/out{}\"", index,
                         sbus ? "sbus" : "ibus", index));
        if (!sbus) {
            line("channels = 18");
        }
        duration("period", period);
        if (chance(50)) {
            line("schedule = \"grid\"");
            line(chance(50) ? "phase = \"locked\"" : "phase = \"free\"");
        }
        marks_.push_back(sbus);
        periods_.push_back(period);
    }

    void add_pipeline() {
        std::string from;
        std::string to;
        for (std::size_t i = 0; i < inputs_; ++i) {
            from += fmt::format("{}\"in{}\"", i == 0 ? "" : ", ", i);
        }
        for (std::size_t i = 0; i < outputs_; ++i) {
            to += fmt::format("{}\"out{}\"", i == 0 ? "" : ", ", i);
        }
        constexpr std::array kModes{"priority", "sticky", "freshest", "median"};
        const std::string mode = kModes[below(inputs_ > 2 ? 4 : 3)];
        line(fmt::format("[pipeline.main]\nfrom = [{}]\nto = [{}]\nmode = \"{}\"", from, to, mode));
        if (inputs_ > 1 && mode != "freshest" && chance(30)) {
            line("changeover = \"4000us/s\"");
        }
        if (inputs_ > 1 && chance(20)) {
            line(fmt::format("handover = {{ input = \"in0\", channel = {} }}", one_to(16)));
        }
        line("[pipeline.main.failsafe]");
        hold_ = between(0ms, 900ms);
        duration("hold", hold_);
        duration("recover", between(0ms, 900ms));
        duration("power_on", between(0ms, 900ms));
        if (chance(30)) {
            line("slew = \"3000us/s\"");
        }
        if (chance(30)) {
            line("release_when = { channel = 3, below = 1200 }");
        }
        for (std::size_t i = 0; i < outputs_; ++i) {
            line(fmt::format("[pipeline.main.failsafe.output.out{}]\naction = \"{}\"", i,
                             marks_[i] ? std::array{"preset", "hold", "silence"}[below(3)]
                                       : std::array{"preset", "silence"}[below(2)]));
        }
    }

    std::mt19937_64 random_;
    std::string text_;
    std::size_t inputs_ = 0;
    std::size_t outputs_ = 0;
    std::vector<Sender> senders_;
    std::vector<bool> marks_;
    std::vector<Duration> periods_;
    Duration hold_{};
    Duration longest_unnoticed_{};
};

bool is_preset(const ChannelFrame& frame) {
    return frame.channel(0) == kCentrePulse && frame.channel(2) == Pulse::from_microseconds(988) &&
           frame.channel(5) == kCentrePulse;
}

/// Every sender's values change with every frame, so an output whose values do not change repeats
/// old ones.
void expect_never_stale(const std::vector<Written>& written, Duration longest) {
    ASSERT_FALSE(written.empty());
    Instant since = written.front().at;
    for (std::size_t i = 1; i < written.size(); ++i) {
        const ChannelFrame& frame = written[i].frame;
        const bool same = frame.same_content(written[i - 1].frame);
        since = same ? since : written[i].at;
        if (frame.good() && !is_preset(frame)) {
            ASSERT_LE(written[i].at - since, longest)
                << "frame " << i << " at " << written[i].at.time_since_epoch() / 1ms << " ms";
        }
    }
}

class NeverStale : public testing::Test {
  protected:
    template <class Check>
    void for_all_seeds(Check check) {
        const std::uint64_t first = seed_or(1);
        const std::uint64_t last = std::getenv("TRIBUS_SEED") ? first : kSeeds;
        for (std::uint64_t seed = first; seed <= last; ++seed) {
            const World world(seed);
            SCOPED_TRACE(replay_command(seed) + "\n" + world.text());
            Simulation simulation(configuration_of(world.text()), world.senders(), seed);
            simulation.run_until(kEnd);
            EXPECT_EQ(simulation.allocations(), 0U);
            check(world, simulation);
            if (HasFailure()) {
                return;
            }
        }
    }
};

TEST_F(NeverStale, no_output_repeats_old_values_unmarked_longer_than_it_may) {
    for_all_seeds([](const World& world, const Simulation& simulation) {
        for (std::size_t i = 0; i < simulation.engine().outputs().size(); ++i) {
            expect_never_stale(simulation.written(i), world.longest_unmarked(i));
        }
    });
}

TEST_F(NeverStale, every_output_is_in_control_again_some_time_after_the_troubles) {
    for_all_seeds([](const World&, const Simulation& simulation) {
        for (const Output& output : simulation.engine().outputs()) {
            EXPECT_EQ(output.stage(), OutputStage::control) << output.name();
        }
    });
}

}  // namespace
}  // namespace tribus::test
