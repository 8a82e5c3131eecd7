#include <chrono>
#include <csignal>
#include <cstdint>

#include <gtest/gtest.h>

#include "tests/loopback/witnessed.h"

/// Many faults happen at once around the built program. A witness checks each frame: was it ever
/// sent, how old is it, is it marked?
namespace tribus::test::faults_test {
namespace {

using namespace std::chrono_literals;

constexpr auto kTimeout = 100ms;
/// An SBUS frame has no checksum. At most one of this many damaged frames may pass for a good one.
constexpr std::uint64_t kHurtForOneWrong = 50;

class WireFaults : public Witnessed {
  protected:
    Program& begin_hurting(int lines, double share) {
        Program& program =
            begin(lines, "timeout = \"100ms\"", "recover = \"0ms\"\npower_on = \"0ms\"",
                  kTimeout + WitnessedLine::kOutputPeriod);
        for (WitnessedLine& line : lines_) {
            line.hurt_frames(share);
        }
        return program;
    }
    void plug_in_again(WitnessedLine& line, const Program& program) {
        line.plug_in();
        const std::size_t replugs = ++replugs_;
        EXPECT_TRUE(turn_until([&] { return count_of("is back", program.errors()) >= replugs; }));
        line.go_on();
    }
    void expect_the_truth() {
        for (WitnessedLine& line : lines_) {
            const Testimony& testimony = line.witness().testimony();
            const std::uint64_t may_be_wrong =
                line.has_checksum() ? 0 : 1 + line.hurt() / kHurtForOneWrong;
            EXPECT_LE(testimony.never_sent, may_be_wrong)
                << to_text(testimony) << "; hurt " << line.hurt();
            EXPECT_EQ(testimony.too_old, 0U) << to_text(testimony);
            EXPECT_EQ(testimony.strays, 0U) << to_text(testimony);
            EXPECT_GT(testimony.unmarked, testimony.marked) << to_text(testimony);
        }
    }

    std::size_t replugs_ = 0;
};

TEST_F(WireFaults, InEachTenthFrameMakeNothingOldAndHardlyAFrameThatNobodySent) {
    Program& program = begin_hurting(6, 0.1);
    go_on_for(4s);
    expect_the_truth();
    expect_clean_end(program);
}

/// Both halves belong to frames, but to different ones.
TEST_F(WireFaults, MakeNoFrameOfAReceiverThatIsPulledInOneAndComesBackInAnother) {
    Program& program = begin_hurting(2, 0);
    for (int replug = 0; replug < 6; ++replug) {
        WitnessedLine& line = lines_[static_cast<std::size_t>(replug) % 2];
        line.pull_in_a_frame();
        plug_in_again(line, program);
        EXPECT_TRUE(all_in_control());
    }
    for (WitnessedLine& line : lines_) {
        const Testimony& testimony = line.witness().testimony();
        EXPECT_EQ(testimony.never_sent, 0U) << to_text(testimony);
        EXPECT_EQ(testimony.too_old, 0U) << to_text(testimony);
    }
    expect_clean_end(program);
}

/// Damaged frames, stops of the program, receivers that fall silent or are unplugged in a frame.
TEST_F(WireFaults, AllAtOnceMakeNothingOld) {
    Program& program = begin_hurting(6, 0.05);
    for (int round = 0; round < 6; ++round) {
        any_line().silence(Clock::now() + 50ms + up_to(200ms));
        WitnessedLine& pulled = any_line();
        program.signal(SIGSTOP);
        go_on_for(up_to(50ms));
        pulled.pull_in_a_frame();
        go_on_for(up_to(300ms));
        program.signal(SIGCONT);
        go_on_for(up_to(100ms));
        plug_in_again(pulled, program);
        go_on_for(100ms + up_to(200ms));
        EXPECT_TRUE(all_in_control());
    }
    expect_the_truth();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::faults_test
