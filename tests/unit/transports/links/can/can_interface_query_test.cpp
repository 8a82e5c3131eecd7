#include "transports/links/can/can_interface.h"

#include <string>

#include <gtest/gtest.h>

#include "tests/support/fewer_descriptors.h"

/// Questions that the kernel of this machine answers.
namespace tribus::can_interface_query_test {
namespace {

constexpr const char* kNames =
    ": names of network interfaces have 1 to 15 characters, such as can0";

TEST(CanInterfaceQuery, SaysThatThereIsNoSuchInterface) {
    const auto answer = query_can_interface("no-such-can");
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().rfind("no-such-can: there is no such network interface; ", 0), 0U)
        << answer.error();
}

TEST(CanInterfaceQuery, SaysThatAnInterfaceIsNotCan) {
    const auto answer = query_can_interface("lo");
    ASSERT_FALSE(answer);
    EXPECT_EQ(answer.error().rfind("lo: this network interface is not a CAN interface; ", 0), 0U)
        << answer.error();
}

TEST(CanInterfaceQuery, RefusesNamesThatNoInterfaceCanHave) {
    EXPECT_EQ(query_can_interface("").error(), kNames);
    EXPECT_EQ(query_can_interface("sixteen-letters-").error(),
              std::string("sixteen-letters-") + kNames);
    EXPECT_EQ(query_can_interface("fifteen-letters")
                  .error()
                  .rfind("fifteen-letters: there is no such network interface; ", 0),
              0U);
}

TEST(CanInterfaceQuery, SaysWhyTheKernelCouldNotBeAsked) {
    const test::FewerDescriptors none(0);
    EXPECT_EQ(query_can_interface("lo").error(),
              "lo: cannot read it from the kernel: Too many open files");
    EXPECT_EQ(restart_can_interface("can0").error(),
              "can0: cannot restart the controller: Too many open files");
}

TEST(CanInterfaceQuery, ANameThatNoInterfaceHasIsMissing) {
    EXPECT_TRUE(is_can_interface_missing("no-such-can"));
    EXPECT_TRUE(is_can_interface_missing("fifteen-letters"));
    EXPECT_FALSE(is_can_interface_missing("lo"));
}

TEST(CanInterfaceQuery, ANameThatNoInterfaceCanHaveIsNotMissing) {
    EXPECT_FALSE(is_can_interface_missing(""));
    EXPECT_FALSE(is_can_interface_missing("sixteen-letters-"));
}

TEST(CanInterfaceQuery, NothingIsMissingWhereTheKernelCouldNotBeAsked) {
    const test::FewerDescriptors none(0);
    EXPECT_FALSE(is_can_interface_missing("no-such-can"));
}

}  // namespace
}  // namespace tribus::can_interface_query_test
