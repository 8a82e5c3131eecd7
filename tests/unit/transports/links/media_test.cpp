#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"
#include "transports/links/evdev/evdev_medium.h"
#include "transports/links/pulse_line/pulse_line_medium.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/links/udp/udp_medium.h"
#include "transports/links/uinput/uinput_medium.h"

/// Each medium describes itself and places.
namespace tribus::test::media_test {
namespace {

struct Said {
    const Medium* medium;
    bool only_own_protocols;
    bool place_is_path;
    bool has_line;
    bool has_datagrams;
    Users users;
};

class MediumOf : public ::testing::TestWithParam<Said> {};

TEST_P(MediumOf, SaysWhatItIs) {
    const auto& [medium, only_own, is_path, line, datagrams, users] = GetParam();
    EXPECT_EQ(medium->only_own_protocols, only_own);
    EXPECT_EQ(medium->place_is_path, is_path);
    EXPECT_EQ(medium->has_line, line);
    EXPECT_EQ(medium->has_datagrams, datagrams);
    EXPECT_EQ(medium->users, users);
    EXPECT_TRUE(medium->place.required);
}

INSTANTIATE_TEST_SUITE_P(
    Links, MediumOf,
    ::testing::Values(Said{&kSerialMedium, false, true, true, false, Users::one_each_way},
                      Said{&kUdpMedium, false, false, false, true, Users::one},
                      Said{&kEvdevMedium, true, true, false, true, Users::one},
                      Said{&kPulseLineMedium, true, false, false, true, Users::one},
                      Said{&kUinputMedium, true, false, false, false, Users::one}),
    [](const auto& said) {
        std::string name(said.param.medium->name);
        std::erase(name, ' ');
        return name;
    });

TEST(SerialPlace, IsRefusedWhereItCanNeverBeAPort) {
    const TemporaryFolder folder;
    EXPECT_EQ(kSerialMedium.refusal(folder.path()),
              "this is a folder; give a serial device, such as /dev/ttyUSB0");
    EXPECT_EQ(kSerialMedium.refusal("/dev/null"),
              "this is not a serial device; give a serial device, such as /dev/ttyUSB0");
    EXPECT_EQ(kSerialMedium.refusal("/dev/ttyNO0"), "") << "it may be plugged in later";
    EXPECT_EQ(kSerialMedium.refusal("/dev/tty"), "") << "a terminal";
}

TEST(Place, HasTheIdentityOfItsDeviceOrItsOwnName) {
    const TemporaryFolder folder;
    const std::string device = folder.write("ttyUSB0", "");
    std::filesystem::create_symlink(device, folder / "by-id");
    for (const Medium* medium : {&kSerialMedium, &kEvdevMedium}) {
        EXPECT_EQ(medium->identity_of(folder / "by-id"), medium->identity_of(device));
    }
    EXPECT_EQ(kUdpMedium.identity_of("127.0.0.1:1"), "127.0.0.1:1");
}

TEST(Place, IsMissingWhereNothingHasItsName) {
    const TemporaryFolder folder;
    const std::string device = folder.write("event0", "");
    EXPECT_FALSE(kEvdevMedium.is_missing(device));
    EXPECT_TRUE(kEvdevMedium.is_missing(folder / "event1"));
    EXPECT_FALSE(kPulseLineMedium.is_missing("/dev/null"));
    EXPECT_TRUE(kPulseLineMedium.is_missing("/dev/spidev-of-a-test"));
    EXPECT_FALSE(kPulseLineMedium.is_missing("")) << "it can never be there";
}

TEST(Place, SaysWhyItCannotBeOpened) {
    for (const auto& [medium, place] :
         std::map<const Medium*, std::string>{{&kSerialMedium, "/dev/ttyNO0"},
                                              {&kEvdevMedium, "/dev/input/event-of-a-test"},
                                              {&kUdpMedium, "127.0.0.1"},
                                              {&kPulseLineMedium, "/dev/spidev-of-a-test"}}) {
        const auto link = medium->open(place, {});
        ASSERT_FALSE(link.has_value()) << place;
        EXPECT_TRUE(link.error().starts_with(place + ": ")) << link.error();
    }
}

std::vector<SettingMistake> mistakes(const Medium& medium, const std::string& place,
                                     SettingScope way) {
    return medium.check(place, {}, way, KeyUse::impossible);
}

TEST(PulseLinePlace, IsAGpioLineForAnInputAndAnSpiPortForAnOutput) {
    for (const std::string line : {"GPIO17", "gpiochip0:17", "/dev/gpiochip0:17"}) {
        EXPECT_TRUE(mistakes(kPulseLineMedium, line, SettingScope::input).empty()) << line;
        EXPECT_EQ(mistakes(kPulseLineMedium, line, SettingScope::output).size(), 1U) << line;
    }
    EXPECT_TRUE(mistakes(kPulseLineMedium, "/dev/spidev0.0", SettingScope::output).empty());
    EXPECT_EQ(mistakes(kPulseLineMedium, "/dev/spidev0.0", SettingScope::input).size(), 1U);
    EXPECT_EQ(mistakes(kPulseLineMedium, "", SettingScope::input).size(), 1U);
    EXPECT_EQ(mistakes(kPulseLineMedium, "spidev0.0", SettingScope::output).size(), 1U);
}

TEST(UdpPlace, IsOnThisMachineUnlessAllowedOrProvedByAKey) {
    const auto mistakes_with = [](const SettingValues& settings, KeyUse key) {
        return kUdpMedium.check("192.0.2.7:5501", settings, SettingScope::input, key).size();
    };
    SettingValues allowed;
    allowed.set("public", true);
    EXPECT_EQ(mistakes_with({}, KeyUse::impossible), 1U);
    EXPECT_EQ(mistakes_with(allowed, KeyUse::impossible), 0U);
    EXPECT_EQ(mistakes_with({}, KeyUse::possible), 1U);
    EXPECT_EQ(mistakes_with(allowed, KeyUse::possible), 1U);
    EXPECT_EQ(mistakes_with({}, KeyUse::given), 0U);
    EXPECT_TRUE(mistakes(kUdpMedium, "127.0.0.1:5501", SettingScope::input).empty());
}

TEST(JoystickName, Has1To79Bytes) {
    const auto wrong = [](const std::string& name) {
        return mistakes(kUinputMedium, name, SettingScope::output).size();
    };
    EXPECT_EQ(wrong("x"), 0U);
    EXPECT_EQ(wrong(std::string(79, 'x')), 0U);
    EXPECT_EQ(wrong(""), 1U);
    EXPECT_EQ(wrong(std::string(80, 'x')), 1U);
}

}  // namespace
}  // namespace tribus::test::media_test
