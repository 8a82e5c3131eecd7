#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/log/state_log.h"
#include "config/load.h"
#include "tests/loopback/machine/teller.h"
#include "tests/support/far_end.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/sbus_frames.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"

/// What the log says of an autopilot at a pty that answers. SBUS frames of 1500 us steer it.
namespace tribus::test::state_log_answers_test {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kAdvice =
    "output drone: autopilot 1 answers, but none of its RC_CHANNELS has these channels; it takes "
    "overrides only from its ground station: its MAV_GCS_SYSID (before 4.7 SYSID_MYGCS) must be "
    "255, the `system` of this output; and it must send RC_CHANNELS (SRn_RC_CHAN 2 or more)\n";

class StateLogOfAnAutopilot : public testing::Test {
  protected:
    StateLogOfAnAutopilot() {
        auto started = Appliance::start(configuration());
        if (!started) {
            throw std::runtime_error(started.error().front());
        }
        appliance_ = std::move(*started);
        teller_ = std::make_unique<Teller>(*appliance_, Instant(0s));
    }

    void steer() {
        ASSERT_TRUE(seen_within([&] {
            receiver_.send(from_hex(kAll992));
            autopilot_.receive();
            return appliance_->output_status(0).state.stage == OutputStage::control;
        }));
    }
    /// Sends so many heartbeats, while the output is steered or not, and returns what the log says.
    std::string after_heartbeats(std::uint32_t count) {
        const std::uint32_t before = heard();
        for (std::uint32_t i = 0; i < count; ++i) {
            autopilot_.send(heartbeat_message());
        }
        EXPECT_TRUE(seen_within([&] {
            autopilot_.receive();
            return heard() == before + count;
        }));
        return said();
    }
    /// The same with heartbeats of another autopilot.
    std::string after_heartbeats_of(std::uint8_t system, std::uint32_t count) {
        const auto others = [&] { return appliance_->output_status(0).answers.heard_others; };
        const std::uint32_t before = others();
        for (std::uint32_t i = 0; i < count; ++i) {
            autopilot_.send(heartbeat_message({.system = system}));
        }
        EXPECT_TRUE(seen_within([&] {
            autopilot_.receive();
            return others() == before + count;
        }));
        return said();
    }
    std::uint32_t heard() const { return appliance_->output_status(0).answers.heard; }
    std::string after_channels(double pulse) {
        autopilot_.send(rc_channels_message(std::vector<double>(16, pulse)));
        return after_heartbeats(1);
    }
    /// What the log says of the output's answers when it looks.
    std::string said() {
        teller_->look(*appliance_, Instant(1s));
        return logged_.take_lines(
            [](const std::string& line) { return line.find("answer") != std::string::npos; });
    }

  private:
    Configuration configuration() const {
        return load_configuration(
                   "[input.receiver]\nprotocol = \"sbus\"\ntimeout = \"10s\"\ndevice = \"" +
                       receiver_.path() +
                       "\"\n[output.drone]\nprotocol = \"mavlink\"\n"
                       "message = \"rc_channels_override\"\nbaud = 115200\ndevice = \"" +
                       autopilot_.path() +
                       "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"drone\"\n"
                       "[runtime]\nrealtime = \"off\"\n",
                   "test.toml")
            .value();
    }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd autopilot_{folder_ / "autopilot"};
    LogInMemory logged_{"%v"};
    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<Teller> teller_;
};

TEST_F(StateLogOfAnAutopilot, SaysOnceThatTenAnswersShowNoEffect) {
    steer();
    EXPECT_EQ(said(), "");
    EXPECT_EQ(after_heartbeats(9), "");
    EXPECT_EQ(after_heartbeats(1), kAdvice);
    EXPECT_EQ(after_heartbeats(20), "");
}

TEST_F(StateLogOfAnAutopilot, SaysNothingWhereAnAnswerShowsTheChannels) {
    steer();
    EXPECT_EQ(after_channels(1500), "");
    EXPECT_EQ(after_heartbeats(20), "");
}

TEST_F(StateLogOfAnAutopilot, SaysThatAnEffectCameAfterAll) {
    steer();
    EXPECT_EQ(after_channels(1100), "");
    EXPECT_EQ(after_heartbeats(10), kAdvice);
    EXPECT_EQ(after_channels(1501), "output drone: an answer shows its channels now\n");
    EXPECT_EQ(after_heartbeats(20), "");
}

TEST_F(StateLogOfAnAutopilot, SaysThatTheTargetIsWrong) {
    EXPECT_EQ(after_heartbeats_of(2, 20), "");
    steer();
    EXPECT_EQ(after_heartbeats_of(2, 9), "");
    EXPECT_EQ(after_heartbeats_of(2, 1),
              "output drone: autopilot 2 answers, and none with system id 1, the `target` of this "
              "output; set target to the id of the autopilot, its MAV_SYSID (before 4.7 "
              "SYSID_THISMAV)\n");
    EXPECT_EQ(after_heartbeats_of(2, 20), "");
    EXPECT_EQ(after_channels(1500), "output drone: an answer shows its channels now\n");
}

TEST_F(StateLogOfAnAutopilot, CountsOnlyAnswersToWhatIsSent) {
    EXPECT_EQ(after_heartbeats(20), "");
    steer();
    EXPECT_EQ(after_heartbeats(9), "");
    EXPECT_EQ(after_heartbeats(1), kAdvice);
}

}  // namespace
}  // namespace tribus::test::state_log_answers_test
