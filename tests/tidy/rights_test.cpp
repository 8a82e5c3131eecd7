#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/doctor/facts/input_facts.h"
#include "tests/support/pages.h"

/// Who may open which device: the package's udev rules, its groups, its units, and the pages that
/// say it.
namespace tribus::test::rights_test {
namespace {

std::string first_match(const std::string& text, const std::string& form) {
    std::smatch match;
    return std::regex_search(text, match, std::regex(form)) ? match.str(1) : std::string();
}

/// A rule of udev that gives devices to a group.
struct Rule {
    std::string devices;  ///< "gpiochip*", or the subsystem where it names no device
    std::string group;
    std::string text;
};

std::vector<Rule> rules() {
    std::istringstream lines(source_text("deploy/udev/60-tribus.rules"));
    std::vector<Rule> found;
    for (std::string line; std::getline(lines, line);) {
        const std::string group = first_match(line, "GROUP=\"([^\"]+)\"");
        if (!line.starts_with("#") && !group.empty()) {
            const std::string kernel = first_match(line, "KERNEL==\"([^\"]+)\"");
            found.push_back({kernel.empty() ? first_match(line, "SUBSYSTEM==\"([^\"]+)\"") : kernel,
                             group, line});
        }
    }
    return found;
}

/// The words of settings of a unit, without drop-ins. `names`: as in a regular expression.
std::set<std::string> words_of(const std::string& unit, const std::string& names) {
    const std::string folder = unit == "tribus-mqtt.service" ? "deploy/mqtt/" : "deploy/systemd/";
    std::istringstream lines(source_text(folder + unit));
    std::set<std::string> found;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(first_match(line, "^(?:" + names + ")=(.*)$"));
        for (std::string word; words >> word;) {
            found.insert(word);
        }
    }
    return found;
}

/// Groups of a unit's processes.
std::set<std::string> groups_of(const std::string& unit) {
    return words_of(unit, "Group|SupplementaryGroups");
}

using Words = std::set<std::string>;

/// The lines of a page, which is where a table has its rows, that have all of these words.
bool has_row(const std::string& page, const std::vector<std::string>& words) {
    std::istringstream lines(source_text(page));
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("|") && std::ranges::all_of(words, [&](const std::string& word) {
                return line.find(word) != std::string::npos;
            })) {
            return true;
        }
    }
    return false;
}

TEST(Rights, HaveAGroupThatThePackageMakesInEachRule) {
    const std::string made = source_text("deploy/sysusers/tribus.conf");
    ASSERT_GE(rules().size(), 5U);
    for (const Rule& rule : rules()) {
        const std::regex line("(^|\n)[ug] " + rule.group + " ");
        EXPECT_TRUE(std::regex_search(made, line)) << rule.text;
    }
}

TEST(Rights, StandInTheTablesOfServiceAndSecurityForEachRule) {
    for (const Rule& rule : rules()) {
        const std::string group = "`" + rule.group + "`";
        EXPECT_TRUE(has_row("docs/service.md", {"/dev/" + rule.devices, group})) << rule.text;
        EXPECT_TRUE(has_row("docs/security.md", {"| group " + group})) << rule.text;
    }
    EXPECT_TRUE(has_row("docs/security.md", {"| group `gpio`", "GPIO", "PWM"}));
    EXPECT_TRUE(has_row("docs/security.md", {"| group `spi`", "SPI", "servos"}));
    EXPECT_TRUE(has_row("docs/security.md", {"| group `uinput`", "keyboard"}));
}

TEST(Rights, ToAVirtualKeyboardAreOfAGroupThatNoUnitHas) {
    const auto all = rules();
    const auto uinput = std::ranges::find(all, "uinput", &Rule::devices);
    ASSERT_NE(uinput, all.end());
    for (const Rule& other : all) {
        EXPECT_TRUE(other.devices == "uinput" || other.group != uinput->group) << other.text;
    }
    ASSERT_TRUE(groups_of("tribus@.service").contains("gpio"));
    for (const char* unit : {"tribus@.service", "tribus-ports@.service", "tribus-web.service"}) {
        EXPECT_FALSE(groups_of(unit).contains(uinput->group)) << unit;
    }
    EXPECT_NE(source_text("docs/service.md")
                  .find("DeviceAllow=/dev/uinput rw\nSupplementaryGroups=" + uinput->group + "\n"),
              std::string::npos)
        << "the drop-in for a joystick";
}

/// It talks to the network: no control socket, no key, no recording.
TEST(Rights, AreToBeToldForTheBridge) {
    const std::string unit = "tribus-mqtt.service";
    EXPECT_EQ(groups_of(unit), Words({"tribus-look"}));
    EXPECT_EQ(words_of(unit, "User"), Words({"tribus-mqtt"}));
    EXPECT_EQ(words_of(unit, "InaccessiblePaths"),
              Words({"-/etc/tribus", "-/run/tribus", "-/run/tribus-ports", "-/var/lib/tribus",
                     "-/var/lib/tribus-web"}));
}

TEST(Rights, ToKeysAreOfTheDaemonAndOfWhatReadsItsConfigurationForIt) {
    const std::string keys = "tribus-keys";
    EXPECT_TRUE(groups_of("tribus@.service").contains(keys));
    EXPECT_TRUE(groups_of("tribus-ports@.service").contains(keys));
    EXPECT_FALSE(groups_of("tribus-web.service").contains(keys));
    EXPECT_EQ(words_of("tribus-web.service", "InaccessiblePaths"), Words({"-/etc/tribus/keys"}));
    EXPECT_TRUE(has_row("docs/security.md", {"| group `" + keys + "`"}));
}

/// The folder gives its group to what daemons make in it, which they cannot do themselves.
TEST(Rights, ToLookAreThoseOfAGroupWithItsOwnFolder) {
    const std::string made = source_text("deploy/sysusers/tribus.conf");
    EXPECT_NE(made.find("\ng tribus-look "), std::string::npos);
    EXPECT_NE(made.find("\ng tribus-keys "), std::string::npos);
    EXPECT_NE(source_text("deploy/tmpfiles/tribus.conf")
                  .find("\nd /run/tribus-look 2750 tribus tribus-look -\n"),
              std::string::npos);
    EXPECT_TRUE(words_of("tribus@.service", "ReadWritePaths").contains("-/run/tribus-look"));
    EXPECT_FALSE(words_of("tribus-web.service", "ReadWritePaths").contains("-/run/tribus-look"));
    EXPECT_TRUE(groups_of("tribus-web.service").contains("tribus-look"));
    EXPECT_TRUE(has_row("docs/security.md", {"| group `tribus-look`", "/run/tribus-look"}));
}

TEST(Rights, ToAVirtualJoystickAreSaidByDoctorAsTheRuleGivesThem) {
    const auto findings = doctor::judge_uinput({.access = {.exists = true, .group = "root"}}, true);
    ASSERT_EQ(findings.size(), 1U);
    const auto all = rules();
    const auto uinput = std::ranges::find(all, "uinput", &Rule::devices);
    ASSERT_NE(uinput, all.end());
    const std::string given = uinput->text.substr(0, uinput->text.find(", OPTIONS"));
    EXPECT_NE(findings[0].fix.find(given), std::string::npos) << findings[0].fix;
    EXPECT_NE(findings[0].fix.find("group " + uinput->group + ":"), std::string::npos);
}

/// ProtectClock= refuses the calls also to somebody who only asks.
TEST(Rights, TheDaemonMayAskWhetherTheClockIsSet) {
    EXPECT_TRUE(words_of("tribus@.service", "SystemCallFilter").contains("clock_adjtime"));
    EXPECT_TRUE(words_of("tribus@.service", "ProtectClock").empty());
}

}  // namespace
}  // namespace tribus::test::rights_test
