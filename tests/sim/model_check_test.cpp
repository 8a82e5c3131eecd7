#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <deque>
#include <memory>
#include <optional>
#include <ostream>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "config/build/build.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/sim/simulation.h"
#include "transports/codecs/codec.h"

/// Failsafe and the selection of inputs as a state machine, searched until no history leads to a
/// new state. Timers are one to three steps long, and in each step the sender of an input does one
/// of a few things. The output is compared with what the history alone allows. Two states are the
/// same if what an observer knows is the same, with elapsed timers capped. States could therefore
/// hide differences, so all short histories are tried as well.
namespace tribus::test::model_check_test {
namespace {

constexpr Duration kStep = std::chrono::milliseconds(10);
constexpr int kTimeoutSteps = 3;
constexpr int kHoldSteps = 1;
constexpr int kRecoverSteps = 1;
constexpr int kProofFrames = 3;
/// A frame counts until the next one, so losses are judged a period ahead. The output's own tick is
/// up to a period after the event.
constexpr int kPeriodSteps = 1;

/// What the sender of an input does in one step.
enum class Act : std::uint8_t { good, silence, failsafe, frame_lost };
std::ostream& operator<<(std::ostream& out, Act act) {
    constexpr std::string_view kNames = "g.FL";
    return out << kNames[static_cast<std::size_t>(act)];
}

std::string job(std::size_t inputs, std::string_view mode) {
    std::string text;
    std::string from;
    for (std::size_t i = 0; i < inputs; ++i) {
        const std::string name = "in" + std::to_string(i);
        text += "[input." + name + "]\nprotocol = \"sbus\"\ndevice = \"/dev/" + name +
                "\"\ntimeout = \"30ms\"\nframe_lost_ratio = 1.0\n";
        from += (i == 0 ? "\"" : ", \"") + name + "\"";
    }
    return text + "[output.out]\nprotocol = \"sbus\"\ndevice = \"/dev/out\"\nperiod = \"10ms\"\n" +
           "schedule = \"grid\"\n[pipeline.main]\nfrom = [" + from + "]\nto = \"out\"\nmode = \"" +
           std::string(mode) +
           "\"\n[pipeline.main.failsafe]\nhold = \"10ms\"\nrecover = \"10ms\"\n"
           "power_on = \"0ms\"\npreset = { other = 1234 }\n";
}

/// What an observer sees of the output after a step.
struct Seen {
    OutputStage stage = OutputStage::failsafe;
    bool good = false;
    std::optional<std::size_t> input;
};

struct Unheard final : StationObserver {
    void wrote(Station /*station*/, Instant /*at*/, const Transmission& /*sent*/) override {}
};

/// One engine, from its start.
class Machine {
  public:
    explicit Machine(const Configuration& configuration)
        : engine_(build_engine(configuration)), loop_(*engine_, nobody_, Instant(kStep)) {
        for (const InputConfig& input : configuration.inputs) {
            encoders_.emplace_back(input.protocol->make_encoder(input.settings));
        }
    }

    /// Performs one act at each input, then a step of time.
    Seen step(std::span<const Act> acts) {
        for (std::size_t i = 0; i < acts.size(); ++i) {
            if (acts[i] != Act::silence) {
                say(i, acts[i]);
            }
        }
        now_ = later(now_, kStep);
        loop_.run_until(now_);
        const Output& output = engine_->outputs()[0];
        return {output.stage(), output.latest().good(),
                output.stage() == OutputStage::control ? output.controlling_input() : std::nullopt};
    }

  private:
    void say(std::size_t input, Act act) {
        ChannelFrame frame;
        frame.failsafe = act == Act::failsafe;
        frame.frame_lost = act == Act::frame_lost;
        for (std::size_t channel = 0; channel < 16; ++channel) {
            // The inputs agree, so a median rejects none of them.
            frame.set(channel, Pulse::from_microseconds(1500 + number_ % 2));
        }
        ++number_;
        loop_.receive(input_station(input), encoders_[input].encode(frame, now_).bytes(), now_);
    }

    Unheard nobody_;
    std::unique_ptr<Engine> engine_;
    VirtualLoop loop_;
    std::vector<FrameEncoder> encoders_;
    Instant now_{kStep};
    int number_ = 0;
};

/// What an observer knows about one input, in steps.
class Known {
  public:
    void take(Act act) {
        ++since_good_;
        ++since_frame_;
        ++since_first_;
        if (since_good_ >= kTimeoutSteps) {
            end_run();
        }
        run_steps_ += run_frames_ > 0 ? 1 : 0;
        if (act == Act::silence) {
            return;
        }
        since_frame_ = 0;
        says_failsafe_ = act == Act::failsafe;
        lost_run_ = act == Act::frame_lost ? lost_run_ + 1 : 0;
        // An SBUS decoder accepts its first frame only when the second one proves it.
        ++frames_;
        if (frames_ == 1) {
            first_was_good_ = act == Act::good;
            since_first_ = 0;
            return;
        }
        if (frames_ == 2 && first_was_good_) {
            since_good_ = since_first_;
            ++run_frames_;
        }
        if (since_good_ >= kTimeoutSteps) {
            end_run();
        }
        if (act == Act::good) {
            since_good_ = 0;
            ++run_frames_;
        }
        if (act == Act::failsafe) {
            end_run();
        }
    }
    int since_good() const { return since_good_; }
    /// Whether its run is so long that it must be in control: it has three good frames, never one
    /// that was older than the timeout, and lasts for `recover`.
    bool is_back() const {
        return run_frames_ >= kProofFrames && run_steps_ > kRecoverSteps + 2 * kPeriodSteps &&
               since_good_ + kPeriodSteps < kTimeoutSteps;
    }
    bool says_failsafe() const { return says_failsafe_; }
    /// Text that differs between any two states that an observer can tell apart.
    std::string key() const {
        constexpr int kCap = kTimeoutSteps + kHoldSteps + kRecoverSteps + 2 * kPeriodSteps;
        return fmt::format("{},{},{},{},{},{},{};", std::min(since_good_, kCap),
                           std::min(since_frame_, kCap), std::min(run_steps_, kCap),
                           std::min(run_frames_, kProofFrames), std::min(lost_run_, kCap),
                           says_failsafe_, std::min(frames_, 3));
    }

  private:
    void end_run() {
        run_steps_ = 0;
        run_frames_ = 0;
    }

    int since_good_ = 1000;
    int since_frame_ = 1000;
    int since_first_ = 0;
    int run_steps_ = 0;   ///< since the first good frame of the run
    int run_frames_ = 0;  ///< good frames of the run
    int lost_run_ = 0;
    int frames_ = 0;
    bool first_was_good_ = false;
    bool says_failsafe_ = false;  ///< the newest frame is marked failsafe
};

void check(const Seen& seen, const std::vector<Known>& known, int step) {
    const int freshest = std::ranges::min(known, {}, &Known::since_good).since_good();
    if (seen.good) {
        EXPECT_LE(freshest, kTimeoutSteps) << "stale values are not marked";
    }
    // A loss counts at once if the input flags it, or after the timeout if the input is silent.
    if (seen.input) {
        const Known& input = known[*seen.input];
        EXPECT_LE(input.since_good(), kTimeoutSteps + kPeriodSteps) << "a lost input is in control";
        EXPECT_FALSE(input.says_failsafe() && input.since_good() > kPeriodSteps)
            << "an input that says failsafe is in control";
    }
    if (freshest > kTimeoutSteps + kHoldSteps + kPeriodSteps) {
        EXPECT_EQ(seen.stage, OutputStage::failsafe) << "held for longer than hold";
    }
    constexpr int kInStep = 3;
    const bool one_is_back = std::ranges::any_of(known, &Known::is_back);
    if (one_is_back && step > kInStep + kRecoverSteps + kPeriodSteps) {
        EXPECT_EQ(seen.stage, OutputStage::control) << "a good input is not in control";
    }
}

/// The acts of all inputs, step after step.
using History = std::vector<Act>;

class ModelCheck : public testing::Test {
  protected:
    void set_up(std::size_t inputs, std::string_view mode, std::vector<Act> acts) {
        inputs_ = inputs;
        acts_ = std::move(acts);
        configuration_ = configuration_of(job(inputs, mode));
        choices_ = 1;
        for (std::size_t i = 0; i < inputs; ++i) {
            choices_ *= acts_.size();
        }
    }
    /// Extends histories, the shortest first, until none leads to a new state. Without TRIBUS_LONG
    /// in the environment it stops when `enough` states are known. Returns the number of states.
    std::size_t explore_states(std::size_t enough) {
        if (std::getenv("TRIBUS_LONG") != nullptr) {
            enough = SIZE_MAX;
        }
        std::set<std::string> states;
        std::deque<History> open{{}};
        while (!open.empty() && states.size() < enough && !HasFailure()) {
            const History history = std::move(open.front());
            open.pop_front();
            for (std::size_t choice = 0; choice < choices_; ++choice) {
                History longer = history;
                add_step(longer, choice);
                if (states.insert(play(longer)).second) {
                    open.push_back(std::move(longer));
                }
            }
        }
        return states.size();
    }
    /// Tries every history of `steps` steps.
    void explore_histories(std::size_t steps) {
        std::size_t histories = 1;
        for (std::size_t i = 0; i < steps; ++i) {
            histories *= choices_;
        }
        for (std::size_t number = 0; number < histories && !HasFailure(); ++number) {
            History history;
            std::size_t rest = number;
            for (std::size_t step = 0; step < steps; ++step) {
                add_step(history, rest % choices_);
                rest /= choices_;
            }
            play(history);
        }
    }

  private:
    void add_step(History& history, std::size_t choice) const {
        for (std::size_t i = 0; i < inputs_; ++i) {
            history.push_back(acts_[choice % acts_.size()]);
            choice /= acts_.size();
        }
    }
    /// Returns the state after this history. Only its last step is checked: the earlier ones were
    /// the last steps of shorter histories.
    std::string play(const History& history) const {
        Machine machine(configuration_);
        std::vector<Known> known(inputs_);
        Seen seen;
        int steps_in_stage = 0;
        for (std::size_t at = 0; at < history.size(); at += inputs_) {
            const std::span<const Act> acts = std::span(history).subspan(at, inputs_);
            for (std::size_t i = 0; i < inputs_; ++i) {
                known[i].take(acts[i]);
            }
            const OutputStage before = seen.stage;
            seen = machine.step(acts);
            steps_in_stage = seen.stage == before ? steps_in_stage + 1 : 0;
            check(seen, known, static_cast<int>(at / inputs_));
        }
        if (HasFailure()) {
            ADD_FAILURE() << "after " << testing::PrintToString(history);
        }
        std::string key = fmt::format("{},{},{},{};", static_cast<int>(seen.stage), seen.good,
                                      seen.input.value_or(inputs_),
                                      std::min(steps_in_stage, kHoldSteps + kRecoverSteps));
        for (const Known& input : known) {
            key += input.key();
        }
        return key;
    }

    std::size_t inputs_ = 0;
    std::size_t choices_ = 0;
    std::vector<Act> acts_;
    Configuration configuration_;
};

const std::vector<Act> kAllActs{Act::good, Act::silence, Act::failsafe, Act::frame_lost};

TEST_F(ModelCheck, EveryStateOfOneLink) {
    set_up(1, "priority", kAllActs);
    const std::size_t states = explore_states(SIZE_MAX);
    EXPECT_GT(states, 200U);
    RecordProperty("states", static_cast<int>(states));
}

TEST_F(ModelCheck, EveryShortHistoryOfOneLink) {
    set_up(1, "priority", kAllActs);
    explore_histories(6);
}

class ModelCheckOfModes : public ModelCheck, public testing::WithParamInterface<const char*> {};

TEST_P(ModelCheckOfModes, EveryStateOfTwoLinks) {
    set_up(2, GetParam(), {Act::good, Act::silence, Act::failsafe});
    const std::size_t states = explore_states(1000);
    EXPECT_GE(states, 1000U);
    RecordProperty("states", static_cast<int>(states));
}

INSTANTIATE_TEST_SUITE_P(Modes, ModelCheckOfModes,
                         testing::Values("priority", "sticky", "freshest"));

/// A median needs three inputs.
TEST_F(ModelCheck, EveryStateOfAMedian) {
    set_up(3, "median", {Act::good, Act::silence});
    const std::size_t states = explore_states(1000);
    EXPECT_GE(states, 1000U);
    RecordProperty("states", static_cast<int>(states));
}

}  // namespace
}  // namespace tribus::test::model_check_test
