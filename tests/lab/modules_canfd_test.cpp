#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"

namespace tribus::test::modules_canfd_test {
namespace {

TEST(LabFdControllerPair, CarriesLongFramesWithBitRateSwitchBothWays) {
    const FdControllerPair pair;
    RawCan near(pair.near());
    RawCan far(pair.far());
    CanFrame frame = make_frame(0x12345678, std::vector<std::uint8_t>(64, 0x5A), true);
    frame.bit_rate_switch = true;
    ASSERT_EQ(near.send(frame), 0);
    const auto at_far = far.receive();
    ASSERT_TRUE(at_far);
    EXPECT_EQ(at_far->frame, frame);
    ASSERT_EQ(far.send(make_frame(0x123, {1})), 0);
    const auto at_near = near.receive();
    ASSERT_TRUE(at_near);
    EXPECT_EQ(at_near->frame, make_frame(0x123, {1}));
}

TEST(LabFdControllerPair, HasTheBitRatesThatItWasGiven) {
    const FdControllerPair pair;
    const std::string details = shell("ip -details link show dev " + pair.near());
    EXPECT_NE(details.find(" bitrate 1000000"), std::string::npos) << details;
    EXPECT_NE(details.find("dbitrate 4000000"), std::string::npos) << details;
    EXPECT_NE(details.find("mtu 72"), std::string::npos) << details;
}

}  // namespace
}  // namespace tribus::test::modules_canfd_test
