#include "config/build/machine_mistakes.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/schema/notation.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::machine_mistakes_test {
namespace {

std::vector<std::string> lines_of(const std::vector<Mistake>& mistakes) {
    std::vector<std::string> lines;
    for (const Mistake& mistake : mistakes) {
        lines.push_back(format_mistake(mistake));
    }
    return lines;
}

Configuration with_device(const std::string& path) {
    return loaded(main_job_with(3, "device = \"" + path + "\""));
}

TEST(MistakenDevice, IsOneThatIsNoTerminalLine) {
    EXPECT_EQ(
        lines_of(mistaken_devices(with_device("/dev/null"))),
        std::vector<std::string>{"t.toml:3:10: \"device\" is \"/dev/null\": this is not a "
                                 "serial device; give a serial device, such as /dev/ttyUSB0"});
    EXPECT_EQ(lines_of(mistaken_devices(with_device("/dev"))),
              std::vector<std::string>{"t.toml:3:10: \"device\" is \"/dev\": this is a folder; "
                                       "give a serial device, such as /dev/ttyUSB0"});
}

TEST(MistakenDevice, IsNoneThatMayStillCome) {
    EXPECT_TRUE(mistaken_devices(with_device("/dev/no-such-port")).empty());
    EXPECT_TRUE(mistaken_devices(with_device("/dev/tty")).empty());
}

TEST(MistakenProcessor, IsOneThatTheMachineDoesNotHave) {
    const Configuration configuration = loaded(main_job_with(10, "[runtime]\ncpu = 4"));
    EXPECT_TRUE(mistaken_processor(configuration, 5).empty());
    EXPECT_EQ(lines_of(mistaken_processor(configuration, 4)),
              std::vector<std::string>{"t.toml:11:7: \"cpu\" is 4, which this machine does not "
                                       "have; allowed: 0 to 3"});
    EXPECT_EQ(lines_of(mistaken_processor(configuration, 1)),
              std::vector<std::string>{"t.toml:11:7: \"cpu\" is 4, which this machine does not "
                                       "have; allowed: 0, its only one"});
    EXPECT_TRUE(mistaken_processor(loaded(main_job_with(10, "")), 1).empty());
}

TEST(MistakenProcessor, NumberIsOneThatNoMachineHas) {
    EXPECT_EQ(mistakes_in(main_job_with(10, "[runtime]\ncpu = 999")),
              std::vector<std::string>{"t.toml:11:7: \"cpu\" is 999; allowed: a whole number from "
                                       "0 to 255"});
}

TEST(InterfaceName, IsWhatLinuxAllows) {
    for (const char* name : {"can0", "c", "a_very-long.can", "vcan0@x"}) {
        EXPECT_TRUE(is_interface_name(name)) << name;
    }
    for (const char* name :
         {"", ".", "..", "a/b", "can 0", "can0\n", "can:0", "can\x1b[2J", "a_very-long_can0"}) {
        EXPECT_FALSE(is_interface_name(name)) << name;
    }
}

TEST(InterfaceName, ThatCannotBeOneIsAMistake) {
    const std::string text = "[input.bus]\nprotocol = \"can\"\ninterface = \"a_very-long_can0\"\n";
    const auto mistakes = mistakes_in(text);
    ASSERT_FALSE(mistakes.empty());
    EXPECT_EQ(mistakes.back(),
              "t.toml:3:13: \"interface\" is \"a_very-long_can0\"; allowed: the name of an "
              "interface, 1 to 15 characters without blanks, \"/\" and \":\"");
}

}  // namespace
}  // namespace tribus::test::machine_mistakes_test
