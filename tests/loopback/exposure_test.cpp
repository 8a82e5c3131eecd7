#include <filesystem>
#include <fstream>
#include <regex>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/pages.h"
#include "tests/support/shell.h"
#include "tests/support/temporary_folder.h"

/// The unit of the service, alone and with each drop-in of docs/service.md, as systemd itself rates
/// it without running it.
namespace tribus::test::exposure_test {
namespace {

const std::string kPage = "docs/service.md";
constexpr const char* kUnit = "tribus@servos.service";
constexpr const char* kBridge = "tribus-mqtt.service";

/// The drop-in of a section: all blocks of code in it that are unit files.
std::string drop_in(const std::string& heading) {
    const std::string page = source_text(kPage);
    const std::string title = "\n## " + heading + "\n";
    const std::size_t section = page.find(title);
    const std::size_t end = page.find("\n## ", section + title.size());
    const std::string begin = "```ini\n";
    std::string text;
    for (std::size_t block = page.find(begin, section); block < end;
         block = page.find(begin, block)) {
        block += begin.size();
        text += page.substr(block, page.find("```", block) - block);
    }
    if (section == std::string::npos || text.empty()) {
        ADD_FAILURE() << kPage << " has no drop-in in \"" << heading << "\"";
    }
    return text;
}

class Exposure : public testing::Test {
  protected:
    Exposure() {
        add(kUnit, source_text("deploy/systemd/tribus@.service"));
        add(kBridge, source_text("deploy/mqtt/tribus-mqtt.service"));
    }
    void SetUp() override {
        // Later versions of systemd judge by more, and a board for trials has none.
        if (!run_in_shell("systemd-analyze --version").output.starts_with("systemd 252 ")) {
            GTEST_SKIP() << "the figures are those of systemd 252, Debian 12";
        }
    }
    void with_drop_in(const std::string& heading) const {
        add(std::string(kUnit) + ".d/override.conf", drop_in(heading));
    }
    /// Nothing that systemd complains about, and at most so many tenths of exposure.
    void rated(int tenths, const char* name = kUnit) const {
        const std::string unit = folder_ / name;
        const Ended verified = run_in_shell("systemd-analyze verify --man=no " + unit);
        EXPECT_EQ(verified.status, 0);
        EXPECT_EQ(verified.output, "");
        const Ended rated = run_in_shell(fmt::format(
            "systemd-analyze security --offline=yes --no-pager --threshold={} {}", tenths, unit));
        EXPECT_EQ(rated.status, 0) << rated.output;
        const std::string said = fmt::format("{}: {}.{} ", name, tenths / 10, tenths % 10);
        EXPECT_NE(rated.output.find(said), std::string::npos)
            << "the page says so: " << rated.output;
    }

  private:
    /// systemd looks whether programs are there; the package is not installed here.
    void add(const std::string& name, const std::string& unit) const {
        static const std::regex installed("/usr/bin/tribus(-mqtt)?");
        const std::string text = std::regex_replace(unit, installed, "/bin/true");
        const std::filesystem::path path = folder_ / name;
        std::filesystem::create_directories(path.parent_path());
        std::ofstream(path) << text;
    }

    TemporaryFolder folder_;
};

TEST_F(Exposure, IsWhatThePageSaysForTheMqttBridge) {
    EXPECT_NE(source_text(kPage).find("that of `tribus-mqtt.service` 1.3"), std::string::npos);
    rated(13, kBridge);
}

TEST_F(Exposure, IsWhatThePageSaysForTheUnit) {
    EXPECT_NE(source_text(kPage).find("| none | 1.9 |"), std::string::npos);
    rated(19);
}

TEST_F(Exposure, WithInputDevicesIsNoGreater) {
    EXPECT_NE(source_text(kPage).find("(#joysticks-in-the-service) | 1.9 |"), std::string::npos);
    with_drop_in("Joysticks in the service");
    rated(19);
}

TEST_F(Exposure, WithPwmIsWhatThePageSays) {
    EXPECT_NE(source_text(kPage).find("(#pwm-in-the-service) | 2.1,"), std::string::npos);
    with_drop_in("PWM in the service");
    rated(21);
}

TEST_F(Exposure, WithUdpIsWhatThePageSays) {
    EXPECT_NE(source_text(kPage).find("(#udp-in-the-service) | 2.2,"), std::string::npos);
    with_drop_in("UDP in the service");
    rated(22);
}

}  // namespace
}  // namespace tribus::test::exposure_test
