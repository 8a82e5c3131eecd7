#include "app/learn/loss_study.h"

#include <chrono>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

/// tests/sim/known_receivers_test.cpp has what is learned of all known receivers.
namespace tribus::test::loss_study_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kHandsOff = Instant(4s);
constexpr LossStudyTimes kTimes{.off = Instant(6s), .back = Instant(10s)};
constexpr Instant kEnd = Instant(12s);

/// Returns frames every 10 ms with first channel `value`, or no frame where `value` is 0.
template <class Value>
std::vector<StudiedFrame> frames(Value value) {
    std::vector<StudiedFrame> made;
    for (Instant at{}; at < kEnd; at += 10ms) {
        const int microseconds = value(at);
        if (microseconds != 0) {
            ChannelFrame frame;
            frame.set(0, Pulse::from_microseconds(microseconds));
            frame.frame_lost = frame.failsafe = false;
            made.push_back({at, frame});
        }
    }
    return made;
}
bool is_off(Instant at) {
    return at >= kTimes.off && at < kTimes.back;
}
/// From 1000 to 2000 and back, then still except for a tremble.
int flown(Instant at) {
    const auto step = static_cast<int>(at.time_since_epoch() / 10ms);
    return at < kHandsOff ? 1000 + step * 37 % 1001 : 1500 + step % 2;
}

InputConfig ibus_input() {
    return load_configuration(test::main_job_with(0, ""), "t.toml")->inputs[0];
}

TEST(LossStudy, SendsThePersonToTheWireIfFramesNeverCame) {
    const LossStudyResult result = study_loss(ibus_input(), {}, kTimes);
    EXPECT_FALSE(result.recognised);
    ASSERT_EQ(result.findings.size(), 1U);
    EXPECT_EQ(result.findings[0], "no frame came while the transmitter was on");
}

TEST(LossStudy, PutsTheLimitHalfWayToAValueBelowWhatIsFlown) {
    const auto studied = frames([](Instant at) { return is_off(at) ? 900 : flown(at); });
    const LossStudyResult result = study_loss(ibus_input(), studied, kTimes);
    EXPECT_TRUE(result.recognised);
    EXPECT_EQ(result.lines,
              std::vector<std::string>{"failsafe_when = [{ channel = 1, below = 950 }]"});
    EXPECT_EQ(result.time_to_loss, Duration(0));
    EXPECT_EQ(result.time_to_return, Duration(0));
}

TEST(LossStudy, PutsTheLimitHalfWayToAValueAboveWhatIsFlown) {
    const auto studied = frames([](Instant at) { return is_off(at) ? 2101 : flown(at); });
    EXPECT_EQ(study_loss(ibus_input(), studied, kTimes).lines,
              std::vector<std::string>{"failsafe_when = [{ channel = 1, above = 2050 }]"});
}

TEST(LossStudy, NamesTheRangeForAValueBetweenTwoPositionsOfASwitch) {
    const auto studied = frames([](Instant at) {
        return is_off(at) ? 1300 : at.time_since_epoch() / 1s % 2 == 0 ? 1000 : 2000;
    });
    EXPECT_EQ(
        study_loss(ibus_input(), studied, kTimes).lines,
        std::vector<std::string>{"failsafe_when = [{ channel = 1, between = [1150, 1650] }]"});
}

TEST(LossStudy, PrintsNoRuleOnAValueHardlyBeyondWhatIsFlown) {
    const auto studied = frames([](Instant at) { return is_off(at) ? 990 : flown(at); });
    for (const std::string& line : study_loss(ibus_input(), studied, kTimes).lines) {
        EXPECT_EQ(line.find("failsafe_when"), std::string::npos) << line;
    }
}

TEST(LossStudy, NeedsNothingForSilence) {
    const auto studied = frames([](Instant at) { return is_off(at) ? 0 : flown(at); });
    const LossStudyResult result = study_loss(ibus_input(), studied, kTimes);
    EXPECT_TRUE(result.recognised);
    EXPECT_TRUE(result.lines.empty());
    EXPECT_EQ(result.time_to_loss, Duration(90ms)) << "the last frame came 10 ms before";
}

TEST(LossStudy, MakesTheTimeoutLongerForFramesFurtherApart) {
    const auto studied = frames([](Instant at) {
        const bool pause = at > Instant(2s) && at < Instant(2150ms);
        return pause || is_off(at) ? 0 : flown(at);
    });
    const LossStudyResult result = study_loss(ibus_input(), studied, kTimes);
    EXPECT_TRUE(result.recognised);
    EXPECT_EQ(result.lines, std::vector<std::string>{"timeout = \"300ms\""});
}

TEST(LossStudy, TellsWhatToSetForValuesThatAnybodyCouldFly) {
    const auto studied = frames([](Instant at) {
        const auto step = static_cast<int>(at.time_since_epoch() / 10ms);
        return is_off(at) ? 1500 + step % 2 : flown(at);
    });
    const LossStudyResult result = study_loss(ibus_input(), studied, kTimes);
    EXPECT_FALSE(result.recognised);
    EXPECT_TRUE(result.lines.empty());
    ASSERT_FALSE(result.advice.empty());
    EXPECT_NE(result.advice[0].find("about 900 us"), std::string::npos);
}

TEST(LossStudy, UsesARuleThatTheConfigurationHasAlready) {
    InputConfig input = ibus_input();
    input.supervision.failsafe_when.push_back(
        {.channel = 0, .below = Pulse::from_microseconds(950)});
    const auto studied = frames([](Instant at) { return is_off(at) ? 900 : flown(at); });
    const LossStudyResult result = study_loss(input, studied, kTimes);
    EXPECT_TRUE(result.recognised);
    EXPECT_TRUE(result.lines.empty());
}

}  // namespace
}  // namespace tribus::test::loss_study_test
