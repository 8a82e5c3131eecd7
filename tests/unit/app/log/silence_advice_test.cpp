#include <algorithm>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/links/evdev/evdev_medium.h"
#include "transports/links/medium.h"
#include "transports/links/udp/udp_medium.h"
#include "transports/registry/registry.h"

/// What the log advises where nothing comes, or nothing of use.
namespace tribus::test::silence_advice_test {
namespace {

bool has_inputs(const Medium& medium) {
    return std::ranges::any_of(protocols(), [&](const Protocol* protocol) {
        return carries(medium, *protocol) && protocol->goes(SettingScope::input);
    });
}

TEST(SilenceAdvice, IsGivenForEveryMediumThatHasInputs) {
    for (const Medium* medium : media()) {
        if (has_inputs(*medium)) {
            EXPECT_NE(medium->silence.nothing, "") << medium->name;
            EXPECT_NE(medium->silence.no_frame, "") << medium->name;
            EXPECT_NE(medium->silence.not_good, "") << medium->name;
        }
    }
}

TEST(SilenceAdvice, SpeaksOfWiresOnlyWhereThereAreWires) {
    for (const Medium* medium : {&kUdpMedium, &kEvdevMedium}) {
        for (const std::string_view text : {medium->silence.nothing, medium->silence.no_frame}) {
            EXPECT_EQ(text.find("wire"), std::string_view::npos) << text;
            EXPECT_EQ(text.find("inverter"), std::string_view::npos) << text;
            EXPECT_EQ(text.find("ground"), std::string_view::npos) << text;
        }
    }
}

TEST(SilenceAdvice, NamesDoctorWhereDoctorKnowsThePlace) {
    for (const Medium* medium : media()) {
        const bool known = has_inputs(*medium) && medium != &kUdpMedium;
        EXPECT_EQ(!medium->silence.doctor.empty(), known) << medium->name;
    }
}

}  // namespace
}  // namespace tribus::test::silence_advice_test
