#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/web/server/ports_command.h"

namespace tribus::web::ports_command_test {
namespace {

using Words = std::vector<std::string>;

std::optional<Words> asked(const std::string& request) {
    return program_for(request, "/etc/tribus");
}

TEST(PortsHelper, BecomesDoctorOfAllPortsOrOfOne) {
    EXPECT_EQ(asked(R"({"verb":"doctor"})"), (Words{"doctor", "--format", "json", "--for", "3s"}));
    EXPECT_EQ(asked(R"({"verb":"doctor","device":null,"seconds":5})"),
              (Words{"doctor", "--format", "json", "--for", "5s"}));
    EXPECT_EQ(
        asked(R"({"verb":"doctor","device":"/dev/serial/by-id/usb-FTDI-if00"})"),
        (Words{"doctor", "--format", "json", "--for", "3s", "/dev/serial/by-id/usb-FTDI-if00"}));
    EXPECT_EQ(asked(R"({"verb":"doctor","device":"can0"})")->back(), "can0");
}

TEST(PortsHelper, ListensForAtMostHalfAMinute) {
    EXPECT_EQ(asked(R"({"verb":"doctor","seconds":86400})")->back(), "30s");
    EXPECT_EQ(asked(R"({"verb":"doctor","seconds":-1})")->back(), "1s");
}

TEST(PortsHelper, BecomesLearnOfAnInputOfAConfiguration) {
    EXPECT_EQ(asked(R"({"verb":"learn","daemon":"boat","input":"receiver_2"})"),
              (Words{"learn", "--format", "json", "/etc/tribus/boat.toml:receiver_2"}));
}

TEST(PortsHelper, LearnsWithAConfigurationWhoseNameHasBlanksAndUmlauts) {
    EXPECT_EQ(asked(R"({"verb":"learn","daemon":"mein Böötchen+","input":"receiver"})"),
              (Words{"learn", "--format", "json", "/etc/tribus/mein Böötchen+.toml:receiver"}));
}

/// Whoever took the page's server over says what it likes.
TEST(PortsHelper, DoesNothingElse) {
    for (const char* request : {"",
                                "{",
                                "[]",
                                "null",
                                R"({})",
                                R"({"verb":"run"})",
                                R"({"verb":["doctor"]})",
                                R"({"verb":"doctor","device":"/etc/shadow"})",
                                R"({"verb":"doctor","device":"/dev/../etc/shadow"})",
                                R"({"verb":"doctor","device":"/dev//x"})",
                                R"({"verb":"doctor","device":""})",
                                R"({"verb":"doctor","device":"--format"})",
                                R"({"verb":"doctor","device":"a b"})",
                                R"({"verb":"learn","daemon":"boat"})",
                                R"({"verb":"learn","input":"receiver"})",
                                R"({"verb":"learn","daemon":"../boat","input":"receiver"})",
                                R"({"verb":"learn","daemon":"boat","input":"--recording"})",
                                R"({"verb":"learn","daemon":"-boat","input":"receiver"})",
                                R"({"verb":"learn","daemon":".boat","input":"receiver"})",
                                R"({"verb":"learn","daemon":"","input":"receiver"})",
                                R"({"verb":"learn","daemon":"a/b","input":"receiver"})",
                                R"({"verb":"learn","daemon":"a:b","input":"receiver"})",
                                R"({"verb":"learn","daemon":"a\u0000b","input":"receiver"})",
                                R"({"verb":"learn","daemon":"a\nb","input":"receiver"})",
                                R"({"verb":"learn","daemon":"boat","input":"a:b"})"}) {
        EXPECT_EQ(asked(request), std::nullopt) << request;
    }
}

}  // namespace
}  // namespace tribus::web::ports_command_test
