#include "app/bench/requirement.h"

#include <chrono>
#include <string>

#include <gtest/gtest.h>

namespace tribus::bench::bench_requirement_test {
namespace {

using namespace std::chrono_literals;

TEST(Requirement, NamesAPercentileAndATime) {
    const auto requirement = parse_requirement("p99=200us");
    ASSERT_TRUE(requirement) << requirement.error();
    EXPECT_EQ(requirement->percent, 99);
    EXPECT_EQ(requirement->most, 200us);
    EXPECT_FALSE(requirement->added);
}

TEST(Requirement, MayBeOfWhatIsAdded) {
    const auto requirement = parse_requirement("added-p50=1.5ms");
    ASSERT_TRUE(requirement) << requirement.error();
    EXPECT_EQ(requirement->percent, 50);
    EXPECT_EQ(requirement->most, 1500us);
    EXPECT_TRUE(requirement->added);
}

class WrongRequirement : public testing::TestWithParam<const char*> {};

TEST_P(WrongRequirement, IsRefusedWithWhatIsAllowed) {
    const auto requirement = parse_requirement(GetParam());
    ASSERT_FALSE(requirement);
    EXPECT_EQ(requirement.error().rfind("--require " + std::string(GetParam()), 0), 0U);
    EXPECT_NE(requirement.error().find("p50, p90 or p99"), std::string::npos);
    EXPECT_NE(requirement.error().find("p99=200us"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Texts, WrongRequirement,
                         testing::Values("", "p99", "p99=", "p99=200", "p99=-1us", "p95=200us",
                                         "added-=3us", "p99 = 200us", "=200us", "p99=fast"));

TEST(Requirement, HoldsUpToItsTime) {
    const auto requirement = parse_requirement("p99=200us");
    EXPECT_FALSE(broken(*requirement, 200us, 0us));
    const auto sentence = broken(*requirement, 201us, 0us);
    ASSERT_TRUE(sentence);
    EXPECT_EQ(*sentence, "p99=200us does not hold: the latency's p99 was 201us");
}

TEST(Requirement, OfWhatIsAddedLeavesOutTheBareRelay) {
    const auto requirement = parse_requirement("added-p90=20us");
    EXPECT_FALSE(broken(*requirement, 120us, 100us));
    EXPECT_EQ(broken(*requirement, 121us, 100us),
              "added-p90=20us does not hold: the added latency's p90 was 21.0us");
}

TEST(ShortTime, HasThreeDigitsAndTheUnitThatFits) {
    EXPECT_EQ(short_time(850ns), "850ns");
    EXPECT_EQ(short_time(42us), "42.0us");
    EXPECT_EQ(short_time(3510us), "3.51ms");
    EXPECT_EQ(short_time(1234ms), "1.23s");
    EXPECT_EQ(short_time(0ns), "0ns");
}

TEST(ShortTime, RoundsUpIntoTheNextUnit) {
    EXPECT_EQ(short_time(999'960ns), "1.00ms");
}

}  // namespace
}  // namespace tribus::bench::bench_requirement_test
