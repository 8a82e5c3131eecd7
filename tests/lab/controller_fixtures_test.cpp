#include <cerrno>
#include <string>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/program.h"

/// Checks that the emulated controllers behave as the other tests expect.
namespace tribus::test::controller_fixtures_test {
namespace {

TEST(LabControllerPair, CarriesFramesBothWaysAndRefusesFd) {
    const ControllerPair pair;
    RawCan near(pair.near());
    RawCan far(pair.far());
    ASSERT_EQ(near.send(make_frame(0x123, {1, 2, 3})), 0);
    ASSERT_EQ(far.send(make_frame(0x12345678, {4})), 0);
    const auto at_far = far.receive();
    const auto at_near = near.receive();
    ASSERT_TRUE(at_far && at_near);
    EXPECT_EQ(at_far->frame, make_frame(0x123, {1, 2, 3}));
    EXPECT_EQ(at_near->frame, make_frame(0x12345678, {4}));
    EXPECT_EQ(near.send(make_frame(0x123, {1}, true)), EINVAL);
}

TEST(LabControllerPair, HasTheBitRateThatItWasGiven) {
    const ControllerPair pair(250'000, "restart-ms 200");
    const std::string details = shell("ip -details link show dev " + pair.near());
    EXPECT_NE(details.find("bitrate 250000"), std::string::npos) << details;
    EXPECT_NE(details.find("restart-ms 200"), std::string::npos) << details;
    EXPECT_NE(details.find("ERROR-ACTIVE"), std::string::npos) << details;
}

TEST(LabControllerPair, CanBeUnpluggedAndPluggedAgain) {
    ControllerPair pair;
    RawCan before(pair.near());
    pair.unplug();
    EXPECT_TRUE(eventually([&] { return before.send(make_frame(1, {})) == ENXIO; }));
    pair.plug();
    RawCan after(pair.near());
    RawCan far(pair.far());
    EXPECT_EQ(after.send(make_frame(0x321, {9})), 0);
    const auto sight = far.receive();
    ASSERT_TRUE(sight);
    EXPECT_EQ(sight->frame.id, 0x321U);
}

}  // namespace
}  // namespace tribus::test::controller_fixtures_test
