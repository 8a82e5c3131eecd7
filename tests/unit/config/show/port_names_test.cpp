#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "config/keys/keys.h"
#include "config/show/manual.h"
#include "tests/support/pages.h"
#include "transports/links/serial/serial_medium.h"

/// README.md, pages, examples, manual pages and the examples of keys have the same ports: those of
/// README.md's table for a Raspberry Pi 4. Pages about boards have those of each board.
namespace tribus::test::port_names_test {
namespace {

namespace fs = std::filesystem;

/// The port in README.md's table of which the last column ends so.
std::string port_of(const std::string& what) {
    const std::string text = text_of_file(readme());
    static const std::regex row(R"(\| `dtoverlay=uart[0-9]` \| `(/dev/\w+)` \| ([^|\n]*) \|)");
    for (std::sregex_iterator match(text.begin(), text.end(), row), none; match != none; ++match) {
        if ((*match)[2].str().find(what) != std::string::npos) {
            return (*match)[1];
        }
    }
    ADD_FAILURE() << "README.md has no port of " << what;
    return "";
}

struct Text {
    std::string where;
    std::string text;
};

/// Whether a page is about the ports of boards, or quotes a machine.
bool names_other_ports(const fs::path& page) {
    return page.string().find("/boards/") != std::string::npos ||
           page.filename() == "laboratory.md";
}

/// All configurations that are shown.
std::vector<Text> configurations() {
    std::vector<Text> texts{{"schema --format markdown", manual_markdown()}};
    for (const fs::path& page : manual_pages()) {
        for (const Fence& fence : fences_of(page)) {
            if (fence.language == "toml" && !names_other_ports(page)) {
                texts.push_back({fence.where, fence.text});
            }
        }
    }
    const auto examples = readme().parent_path() / "config" / "examples";
    for (const auto& entry : fs::directory_iterator(examples)) {
        if (entry.path().extension() == ".toml") {
            texts.push_back({entry.path().filename().string(), text_of_file(entry.path())});
        }
    }
    return texts;
}

/// Ports of the board in tables such as [input.NAME], in their order.
std::vector<std::string> ports_of_tables(const std::string& kind, const std::string& text) {
    static const std::regex device(R"re(^device += "(/dev/ttyAMA[0-9]+)")re");
    std::istringstream lines(text);
    std::vector<std::string> ports;
    bool inside = false;
    std::smatch match;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("[")) {
            inside = line.starts_with("[" + kind + ".");
        } else if (inside && std::regex_search(line, match, device)) {
            ports.push_back(match[1]);
        }
    }
    return ports;
}

TEST(PortNames, AreThoseOfTheReadmeForTheFirstReceiver) {
    const std::string receiver = port_of("receiver");
    const std::string servos = port_of("servos");
    std::size_t found = 0;
    for (const auto& [where, text] : configurations()) {
        const auto ports = ports_of_tables("input", text);
        for (std::size_t i = 0; i < ports.size(); ++i) {
            ++found;
            EXPECT_EQ(ports[i] == receiver, i == 0) << where << ": " << ports[i];
            EXPECT_NE(ports[i], servos) << where;
        }
    }
    EXPECT_GE(found, 25U);
}

TEST(PortNames, AreThoseOfTheReadmeForAnOutputUnlessItSharesThePortOfAnInput) {
    const std::string servos = port_of("servos");
    std::size_t found = 0;
    for (const auto& [where, text] : configurations()) {
        const auto inputs = ports_of_tables("input", text);
        const std::set<std::string> shared(inputs.begin(), inputs.end());
        for (const std::string& port : ports_of_tables("output", text)) {
            ++found;
            EXPECT_TRUE(port == servos || shared.contains(port)) << where << ": " << port;
        }
    }
    EXPECT_GE(found, 25U);
}

TEST(PortNames, AreTheSameEverywhereForASensorWire) {
    std::set<std::string> ports;
    for (const auto& [where, text] : configurations()) {
        const auto inputs = ports_of_tables("input", text);
        const std::set<std::string> shared(inputs.begin(), inputs.end());
        for (const std::string& port : ports_of_tables("sensor_bus", text)) {
            if (!shared.contains(port)) {
                ports.insert(port);
            }
        }
    }
    EXPECT_EQ(ports.size(), 1U);
    EXPECT_FALSE(ports.contains(port_of("receiver")) || ports.contains(port_of("servos")));
}

TEST(PortNames, InCommandsOfPagesAndManualPagesAreThoseOfTheReadme) {
    static const std::regex port("/dev/ttyAMA[0-9]+");
    const std::set<std::string> known{port_of("receiver"), port_of("servos"), "/dev/ttyAMA4"};
    std::vector<Text> texts{{"the key `device`", std::string(kDeviceSetting.example) + " " +
                                                     std::string(kDeviceSetting.help)}};
    for (const auto& entry : fs::directory_iterator(readme().parent_path() / "deploy" / "man")) {
        texts.push_back({entry.path().filename().string(), text_of_file(entry.path())});
    }
    for (const fs::path& page : manual_pages()) {
        if (names_other_ports(page)) {
            continue;
        }
        for (const Fence& fence : fences_of(page)) {
            if (fence.language != "toml") {
                texts.push_back({fence.where, fence.text});
            }
        }
    }
    std::size_t found = 0;
    for (const auto& [where, text] : texts) {
        for (std::sregex_iterator match(text.begin(), text.end(), port), none; match != none;
             ++match) {
            ++found;
            EXPECT_TRUE(known.contains(match->str())) << where << ": " << match->str();
        }
    }
    EXPECT_GE(found, 10U);
}

}  // namespace
}  // namespace tribus::test::port_names_test
