#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// `tribus simulate` with CAN on either side.
namespace tribus::simulate_can_test {
namespace {

using test::Ended;
using test::run_in_shell;
using test::TemporaryFolder;

constexpr const char* kFromCan = R"(
[input.cockpit]
protocol = "can"
interface = "can1"
[output.servos]
protocol = "sbus"
device = "/dev/ttyAMA3"
[pipeline.main]
from = "cockpit"
to = "servos"
)";
constexpr const char* kToCan = R"(
[input.receiver]
protocol = "ibus"
device = "/dev/ttyAMA5"
[output.bus]
protocol = "can"
interface = "vcan3"
[pipeline.main]
from = "receiver"
to = "bus"
)";

/// Returns i.Bus frames every 7 ms with this first channel.
std::string receiver_frames(int first) {
    std::string lines;
    for (int frame = 0; frame < 150; ++frame) {
        lines += "{\"t_us\":" + std::to_string(7000 * frame) + ",\"channels\":[" +
                 std::to_string(first) +
                 ",1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,1500,"
                 "1500]}\n";
    }
    return lines;
}

class SimulateCan : public testing::Test {
  protected:
    SimulateCan() {
        folder.write("from_can.toml", kFromCan);
        folder.write("to_can.toml", kToCan);
        folder.write("1234.json", receiver_frames(1234));
        folder.write("1750.json", receiver_frames(1750));
    }
    Ended run(const std::string& command) const {
        return run_in_shell("cd '" + folder / "" + "'; " + command);
    }
    /// Writes a log of native frames on an interface.
    std::string log(const std::string& frames, const std::string& interface) const {
        return run("\"$TRIBUS\" encode --protocol can --interface " + interface + " " + frames)
            .output;
    }
    TemporaryFolder folder;
};

TEST_F(SimulateCan, RecordingThatCannotBeReadIsToldWithTheReason) {
    const Ended missing =
        run("\"$TRIBUS\" simulate to_can.toml --in receiver=none.txt --out bus=can.log");
    EXPECT_EQ(missing.status, 1);
    EXPECT_EQ(missing.output, "none.txt: No such file or directory\n");
    const Ended inside = run("\"$TRIBUS\" simulate to_can.toml --in receiver=. --out bus=can.log");
    EXPECT_EQ(inside.status, 1);
    EXPECT_EQ(inside.output, ".: Is a directory\n");
}

TEST_F(SimulateCan, OutputIsALogOfItsInterface) {
    const Ended result =
        run("\"$TRIBUS\" encode --protocol ibus --format timed 1234.json > ibus.txt && "
            "\"$TRIBUS\" simulate to_can.toml --in receiver=ibus.txt --out bus=can.log && "
            "\"$TRIBUS\" decode --protocol can --interface vcan3 --format csv can.log");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find(",1234,1500,"), std::string::npos) << result.output;
    EXPECT_NE(folder.read("can.log").find(") vcan3 300#"), std::string::npos);
}

TEST_F(SimulateCan, FormatConcernsSerialOutputsOnly) {
    run("\"$TRIBUS\" encode --protocol ibus --format timed 1234.json > ibus.txt");
    run("\"$TRIBUS\" simulate to_can.toml --in receiver=ibus.txt --out bus=timed.log");
    run("\"$TRIBUS\" simulate to_can.toml --in receiver=ibus.txt --out bus=binary.log "
        "--format binary");
    EXPECT_FALSE(folder.read("timed.log").empty());
    EXPECT_EQ(folder.read("timed.log"), folder.read("binary.log"));
}

TEST_F(SimulateCan, InputTakesALog) {
    folder.write("can.log", log("1234.json", "can1"));
    const Ended result =
        run("\"$TRIBUS\" simulate from_can.toml --in cockpit=can.log --out servos=sbus.txt && "
            "\"$TRIBUS\" decode --protocol sbus --format csv sbus.txt");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find(",1233.75,"), std::string::npos) << result.output;
}

TEST_F(SimulateCan, InputTakesTheFramesOfItsOwnInterface) {
    std::istringstream other(log("1750.json", "can0"));
    std::istringstream own(log("1234.json", "can1"));
    std::string both;
    for (std::string a, b; std::getline(other, a) && std::getline(own, b);) {
        both += a + "\n" + b + "\n";
    }
    folder.write("can.log", both);
    const Ended result =
        run("\"$TRIBUS\" simulate from_can.toml --in cockpit=can.log --out servos=sbus.txt && "
            "\"$TRIBUS\" decode --protocol sbus --format csv sbus.txt");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find(",1233.75,"), std::string::npos) << result.output;
    EXPECT_EQ(result.output.find(",1750"), std::string::npos) << result.output;
}

TEST_F(SimulateCan, LogOfOneOtherInterfaceWillDo) {
    folder.write("can.log", log("1234.json", "vcan0"));
    const Ended result =
        run("\"$TRIBUS\" simulate from_can.toml --in cockpit=can.log --out servos=sbus.txt");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find("input cockpit: 6000 bytes, 148 frames, "), std::string::npos)
        << result.output;
}

TEST_F(SimulateCan, LogOfSeveralOtherInterfacesIsRefused) {
    folder.write("can.log", "(1.000000) can0 300#\n(1.000000) vcan0 300#\n");
    const Ended result = run("\"$TRIBUS\" simulate from_can.toml --in cockpit=can.log");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "can.log: has frames of \"can0\", \"vcan0\", but none of \"can1\", the interface of "
              "input \"cockpit\"; set one of them there\n");
}

TEST_F(SimulateCan, BytesForACanInputAreRefused) {
    folder.write("bytes.txt", "20 40 dc 05\n");
    const Ended result = run("\"$TRIBUS\" simulate from_can.toml --in cockpit=bytes.txt");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "bytes.txt: this is not a log of CAN frames, but input \"cockpit\" has the protocol "
              "can; it takes lines such as (1436509052.249713) can0 123#1122, as candump -L writes "
              "them\n");
}

TEST_F(SimulateCan, LogForASerialInputIsRefused) {
    folder.write("can.log", "(1.000000) can0 300#\n");
    const Ended result = run("\"$TRIBUS\" simulate to_can.toml --in receiver=can.log");
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(result.output,
              "can.log: this is a log of CAN frames, but input \"receiver\" has the protocol ibus; "
              "it takes recorded bytes: raw, hex, timed hex or the CSV of a Saleae serial "
              "decoder\n");
}

}  // namespace
}  // namespace tribus::simulate_can_test
