#include "config/keys/homes.h"

#include <ostream>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tribus::test::homes_test {
namespace {

struct Sought {
    std::string_view key;
    std::string_view side;
    std::string_view protocol;
    std::string_view home;
};

std::ostream& operator<<(std::ostream& out, const Sought& sought) {
    return out << sought.key << " " << sought.side << " " << sought.protocol;
}

constexpr Sought kSought[]{
    {"cpu", "", "", "[runtime]"},
    {"cpu", "output", "sbus", "[runtime]"},
    {"timeout", "", "", "[input.NAME]"},
    {"timeout", "output", "sbus", "[input.NAME]"},
    {"protocol", "", "", "[input.NAME]"},
    {"protocol", "output", "", "[output.NAME]"},
    {"period", "input", "", "[output.NAME]"},
    {"tolerance", "", "", "[pipeline.NAME]"},
    {"recover", "", "", "[pipeline.NAME.failsafe]"},
    {"trim", "", "", "[input.NAME.map]"},
    {"trim", "pipeline", "", "[pipeline.NAME.channels]"},
    {"channel", "input", "", "[input.NAME.failsafe_when]"},
    {"channel", "pipeline", "", "[pipeline.NAME.handover]"},
    {"value", "", "", "[sensor_bus.NAME.sensor]"},
    {"baud", "", "", R"([input.NAME] with protocol "ibus" and "device")"},
    {"baud", "output", "sbus", R"([output.NAME] with protocol "sbus" and "device")"},
    {"baud", "input", "crsf", R"([input.NAME] with protocol "crsf" and "device")"},
    {"scale", "", "", R"([input.NAME] with protocol "sbus")"},
    {"scale", "output", "sbus", R"([output.NAME] with protocol "sbus")"},
    {"scale", "input", "ibus", R"([input.NAME] with protocol "sbus")"},
    {"slots", "output", "", R"([input.NAME] with protocol "ibus")"},
    {"slots", "output", "ibus", R"([input.NAME] with protocol "ibus")"},
    {"dbc", "output", "sbus", R"([output.NAME] with protocol "dbc")"},
    {"interface", "pipeline", "", R"([input.NAME] with protocol "can")"},
    {"runtime", "", "", ""},
    {"sensor_type", "output", "", ""},
    {"no such key", "", "", ""},
    {"no such key", "input", "sbus", ""},
};

class HomeOfAKey : public ::testing::TestWithParam<Sought> {};

TEST_P(HomeOfAKey, IsTheNearestTableThatHasIt) {
    EXPECT_EQ(home_of_key(GetParam().key, GetParam().side, GetParam().protocol), GetParam().home);
}

INSTANTIATE_TEST_SUITE_P(Each, HomeOfAKey, ::testing::ValuesIn(kSought));

}  // namespace
}  // namespace tribus::test::homes_test
