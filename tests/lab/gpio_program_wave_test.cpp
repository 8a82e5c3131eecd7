#include <csignal>
#include <ctime>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/gpio_program_bench.h"

/// The square wave of a `fresh` line of the built program: 100 ms, with frames every 20 ms. Only
/// the edges that the kernel traces count.
namespace tribus::test::gpio_program_wave_test {
namespace {

class GpioWave : public GpioProgram {
  protected:
    static std::string gate() {
        return line("gate", 0, "fresh", "period = \"100ms\"") +
               "[pipeline.main.failsafe]\nrecover = \"0s\"\n";
    }
    bool runs() {
        const auto start = Clock::now();
        return while_sending([&] { return trace_.edges_after(start) >= 10; });
    }
    /// Returns the number of edges from `event` on. `event` has just happened; the function waits
    /// for 20 periods, in which a running wave has 40 edges.
    std::size_t edges_after(Clock::time_point event) const {
        const timespec pause{.tv_sec = 2, .tv_nsec = 0};
        ::nanosleep(&pause, nullptr);
        return trace_.edges_after(event);
    }
    /// Two periods have four edges.
    static constexpr std::size_t kTwoPeriods = 4;

    LevelTrace trace_;
};

TEST_F(GpioWave, RunsUnderControlOnly) {
    Program& program = run(config(gate()));
    EXPECT_EQ(edges_after({}), 0U) << "edges before the first frame";
    EXPECT_TRUE(runs()) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioWave, EndsWithinTwoPeriodsOfSigstopAndGoesOnAfterSigcont) {
    Program& program = run(config(gate()));
    EXPECT_TRUE(runs()) << program.errors();
    program.signal(SIGSTOP);
    EXPECT_LE(edges_after(Clock::now()), kTwoPeriods);
    program.signal(SIGCONT);
    EXPECT_TRUE(runs()) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioWave, EndsWithinTwoPeriodsOfSigkill) {
    Program& program = run(config(gate()));
    EXPECT_TRUE(runs()) << program.errors();
    program.signal(SIGKILL);
    EXPECT_LE(edges_after(Clock::now()), kTwoPeriods);
    EXPECT_EQ(program.end(), 128 + SIGKILL);
}

TEST_F(GpioWave, EndsWithinTwoPeriodsOfADataThreadThatHangs) {
    Program program = start_to_hang(config(gate()));
    EXPECT_TRUE(program.says("started")) << program.errors();
    EXPECT_TRUE(runs()) << program.errors();
    program.signal(SIGUSR2);
    EXPECT_LE(edges_after(Clock::now()), kTwoPeriods);
    EXPECT_TRUE(program.runs()) << "the process itself has ended";
    servos_.listen();
    EXPECT_TRUE(spins(program));
    EXPECT_TRUE(servos_.listen().empty()) << "a frame was sent";
}

TEST_F(GpioWave, EndsWithinTwoPeriodsOfAFailsafeThatIsMeant) {
    Program& program =
        run(config(gate() + line("stop", 1, "force_failsafe", "bias = \"pull_down\"")));
    EXPECT_TRUE(runs()) << program.errors();
    bank_.pull(1, true);
    EXPECT_LE(edges_after(Clock::now()), kTwoPeriods);
    EXPECT_TRUE(is_in_failsafe());
    bank_.pull(1, false);
    EXPECT_TRUE(runs()) << program.errors();
    expect_clean_end(program);
}

TEST_F(GpioWave, EndsWithoutAPortToWriteTo) {
    Program& program = run(config(gate()));
    EXPECT_TRUE(runs()) << program.errors();
    servo_wire_.pull();
    EXPECT_LE(edges_after(Clock::now()), kTwoPeriods);
    servo_wire_.plug_in();
    EXPECT_TRUE(runs()) << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::gpio_program_wave_test
