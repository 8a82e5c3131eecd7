#include "config/schema/configured_names.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/schema/schema.h"

namespace tribus::test::configured_names_test {
namespace {

TEST(ConfiguredNames, AreInTheOrderOfTheParts) {
    std::vector<OutputConfig> outputs(3);
    outputs[0].name = "servos";
    outputs[1].name = "bus";
    outputs[2].name = "autopilot";
    EXPECT_EQ(configured_names(outputs), (std::vector<std::string>{"servos", "bus", "autopilot"}));
    EXPECT_EQ(configured_names(std::vector<InputConfig>{}), std::vector<std::string>{});
}

}  // namespace
}  // namespace tribus::test::configured_names_test
