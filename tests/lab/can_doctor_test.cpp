#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/program.h"

/// `tribus doctor` at CAN interfaces.
namespace tribus::test::can_doctor_test {
namespace {

ShellResult doctor(const std::string& interface) {
    return run_shell(std::string(TRIBUS_PROGRAM) + " doctor " + interface);
}

bool has(const ShellResult& result, const std::string& part) {
    return result.output.find(part) != std::string::npos;
}

TEST(LabCanDoctor, VirtualBusThatIsUpIsWell) {
    const VirtualBus bus;
    const ShellResult result = doctor(bus.name());
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_TRUE(has(result, "vcan0: vcan, up")) << result.output;
}

TEST(LabCanDoctor, BusThatIsDownIsAProblem) {
    const VirtualBus bus;
    bus.down();
    const ShellResult result = doctor(bus.name());
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_TRUE(has(result, "[can.down]")) << result.output;
    EXPECT_TRUE(has(result, "sudo ip link set vcan0 up")) << result.output;
}

TEST(LabCanDoctor, ControllerInBusOffIsAProblem) {
    SlcanAdapter adapter;
    adapter.bus_off();
    EXPECT_TRUE(eventually([&] {
        return shell("ip -details link show dev " + adapter.name()).find("BUS-OFF") !=
               std::string::npos;
    }));
    const ShellResult result = doctor(adapter.name());
    EXPECT_EQ(result.status, 1) << result.output;
    EXPECT_TRUE(has(result, "[can.bus_off]")) << result.output;
}

}  // namespace
}  // namespace tribus::test::can_doctor_test
