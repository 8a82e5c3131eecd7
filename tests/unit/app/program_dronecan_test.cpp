#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/shell.h"

/// The built program over logs of a DroneCAN bus.
namespace tribus::program_dronecan_test {
namespace {

using test::Ended;
using test::run_in_shell;
using test::TemporaryFolder;

/// NodeStatus of node 42 and a command of node 10 to four ESCs (docs/protocols/can.md, "DroneCAN:
/// worked examples", 5 and 4), and RCInput of two channels.
constexpr std::string_view kLog =
    "(1.000000) can0 1801552A#D2040000000000CC\n"
    "(1.010000) can0 0804060A#0003FDF0080010C9\n"
    "(1.020000) can0 0804742A#0000000DC5DC50C5\n";

class ProgramDroneCan : public testing::Test {
  protected:
    void SetUp() override { folder.write("bus.log", std::string(kLog)); }
    Ended run(const std::string& command) const {
        return run_in_shell("cd '" + folder / "" + "'; " + command);
    }
    TemporaryFolder folder;
};

TEST_F(ProgramDroneCan, AutoTellsALogOfNothingElse) {
    const Ended result = run("\"$TRIBUS\" decode bus.log");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.output.find("uavcan.protocol.NodeStatus  uptime_sec 1234 s, health 0"),
              std::string::npos)
        << result.output;
    EXPECT_NE(result.output.find("\n3 transfers in 3 CAN frames"), std::string::npos);
}

TEST_F(ProgramDroneCan, EveryTransferOfANamedProtocolIsExplainedFromAFileAndAPipe) {
    for (const std::string_view command :
         {"\"$TRIBUS\" decode --protocol dronecan bus.log",
          "cat bus.log | \"$TRIBUS\" decode --protocol dronecan"}) {
        const Ended result = run(std::string(command));
        EXPECT_EQ(result.status, 0);
        EXPECT_NE(result.output.find("uavcan.equipment.esc.RawCommand  cmd [0 8191 -8192 4096]"),
                  std::string::npos)
            << result.output;
        EXPECT_NE(result.output.find("\n3 transfers in 3 CAN frames"), std::string::npos);
    }
}

TEST_F(ProgramDroneCan, ChannelsGoOnToEncode) {
    const Ended result =
        run("\"$TRIBUS\" decode --protocol dronecan --format json bus.log | "
            "\"$TRIBUS\" encode --protocol ibus --format hex");
    EXPECT_EQ(result.status, 0);
    EXPECT_EQ(result.output.substr(0, 18), "20 40 dc 05 dc 05 ") << result.output;
}

TEST_F(ProgramDroneCan, BytesAndBadLinesAreRefusedAsByOtherCanProtocols) {
    const Ended raw = run("printf '\\017\\000\\000\\000' | \"$TRIBUS\" decode --protocol dronecan");
    EXPECT_EQ(raw.status, 2);
    EXPECT_EQ(raw.output,
              "tribus: standard input: bytes of a serial line, but dronecan is read from CAN "
              "frames: lines such as (1436509052.249713) can0 123#1122, as candump -L writes "
              "them\n");
    const Ended line = run("(cat bus.log; echo rubbish) | \"$TRIBUS\" decode --protocol dronecan");
    EXPECT_EQ(line.status, 1);
    EXPECT_NE(line.output.find("standard input:4:1: "), std::string::npos) << line.output;
    EXPECT_NE(line.output.find("\n3 transfers in 3 CAN frames"), std::string::npos);
}

TEST_F(ProgramDroneCan, SeveralInterfacesNeedAName) {
    const Ended unnamed =
        run("sed 's/can0 18/can1 18/' bus.log > two.log; "
            "\"$TRIBUS\" decode --protocol dronecan two.log");
    EXPECT_EQ(unnamed.status, 1);
    EXPECT_NE(unnamed.output.find("--interface NAME"), std::string::npos) << unnamed.output;
    const Ended named = run("\"$TRIBUS\" decode --protocol dronecan --interface can1 two.log");
    EXPECT_EQ(named.status, 0);
    EXPECT_NE(named.output.find("\n1 transfer in 1 CAN frame"), std::string::npos);
}

}  // namespace
}  // namespace tribus::program_dronecan_test
