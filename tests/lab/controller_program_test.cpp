#include <string>

#include <gtest/gtest.h>

#include "tests/lab/two_programs.h"

/// The built program on controllers.
namespace tribus::test::controller_program_test {
namespace {

class BusFault : public TwoPrograms {};

TEST_F(BusFault, ControllerCardPulledOutAndPutBackEndsInFailsafeAndComesBack) {
    ControllerPair pair;
    const BusJob job{.sender_interface = pair.near(), .reader_interface = pair.far()};
    Program& sender = start_sender(job);
    Program& reader = start_reader(job);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    expect_times(expect_failsafe_and_recovery(
        "controller card pulled out, put back", [&] { pair.unplug(); }, [&] { pair.plug(); }));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// Log messages about an interface at the start, and their advice.
class CanStartLog : public TwoPrograms {};

TEST_F(CanStartLog, AdvisesToRestartAfterBusOff) {
    const ControllerPair pair(500'000, "restart-ms 0");
    const Program& sender = start_sender({.sender_interface = pair.near()});
    EXPECT_TRUE(sender.says(pair.near() + ": can, up, 500 kbit/s"));
    EXPECT_TRUE(sender.says("sends nothing until it is restarted by hand: `ip link set " +
                            pair.near() + " down`, `ip link set " + pair.near() +
                            " type can restart-ms 100`"));
}

TEST_F(CanStartLog, IsSilentAboutAControllerThatIsSetUpWell) {
    const ControllerPair pair;
    Program& sender = start_sender({.sender_interface = pair.near()});
    EXPECT_TRUE(sender.says("restart-ms 100"));
    EXPECT_EQ(count_of("warning", sender.errors()), 0U) << sender.errors();
}

TEST(LabCanDoctor, ControllerThatNeverRestartsIsAdvised) {
    const ControllerPair pair(500'000, "restart-ms 0");
    const ShellResult result = run_shell(std::string(TRIBUS_PROGRAM) + " doctor " + pair.near());
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_TRUE(count_of("500 kbit/s", result.output) > 0) << result.output;
    EXPECT_TRUE(count_of("[can.no_restart]", result.output) > 0) << result.output;
}

}  // namespace
}  // namespace tribus::test::controller_program_test
