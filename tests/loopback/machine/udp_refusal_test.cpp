#include <cerrno>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/device_stand_in.h"
#include "tests/support/fewer_descriptors.h"
#include "transports/links/udp/udp_link.h"

/// A UDP link meets errors of the kernel.
namespace tribus::test::udp_refusal_test {
namespace {

/// A socket that cannot send (udp_sendmsg in net/ipv4/udp.c).
class Deaf : public DeviceStandIn {
  public:
    Deaf(int descriptor, int failure) : DeviceStandIn(descriptor), failure_(failure) {}
    Answer write(std::span<const std::uint8_t> /*bytes*/) override { return -failure_; }

  private:
    int failure_;
};

TEST(UdpRefusal, IsBusyWhereTheKernelHasNoRoomAndUnavailableOtherwise) {
    const std::vector<std::uint8_t> frame{1};
    for (const auto& [failure, status] :
         {std::pair(EAGAIN, WriteStatus::busy), std::pair(ENOBUFS, WriteStatus::busy),
          std::pair(EINTR, WriteStatus::busy), std::pair(ENETUNREACH, WriteStatus::unavailable),
          std::pair(EPERM, WriteStatus::unavailable)}) {
        const auto link = UdpLink::open("127.0.0.1:9", SettingScope::output);
        ASSERT_TRUE(link.has_value());
        const Deaf deaf((*link)->descriptor(), failure);
        EXPECT_EQ((*link)->write(frame), status) << failure;
    }
}

TEST(UdpRefusal, SaysThatThereIsNoDescriptorLeft) {
    const FewerDescriptors fewer(0);
    const auto link = UdpLink::open("127.0.0.1:9", SettingScope::output);
    ASSERT_FALSE(link.has_value());
    EXPECT_EQ(link.error(), "127.0.0.1:9: cannot make a socket: Too many open files");
}

}  // namespace
}  // namespace tribus::test::udp_refusal_test
