#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "pipelines/rules/settings.h"
#include "tests/support/pages.h"
#include "transports/registry/registry.h"

/// What pages say of all protocols comes from the table of protocols.
namespace tribus::test::protocol_pages_test {
namespace {

using Lines = std::vector<std::string>;

std::string page(const std::string& name) {
    return text_of_file(readme().parent_path() / "docs" / name);
}

/// Lines of the page that begin so.
Lines lines_with(const std::string& begin, const std::string& text) {
    std::istringstream stream(text);
    Lines found;
    for (std::string line; std::getline(stream, line);) {
        if (line.starts_with(begin)) {
            found.push_back(line);
        }
    }
    return found;
}

/// What carries the protocol, the usual one first, and the settings of its line.
std::string carriers(const Protocol& protocol) {
    std::string text;
    for (const Medium* medium : media_for(protocol)) {
        text += fmt::format("{}{}", text.empty() ? "" : "; ", medium->name);
        if (medium->name == "a serial line") {
            text += fmt::format(", {} 8{}{}", protocol.line.baud,
                                protocol.line.parity == Parity::even ? 'E' : 'N',
                                protocol.line.stop_bits);
        }
    }
    return text;
}

std::string row_of(const Protocol& protocol) {
    const auto tick = [](bool is) { return is ? "yes" : ""; };
    const bool channels = protocol.has_channels();
    return fmt::format("| `{}` | {} | {} | {} | {} | {} |", protocol.name, protocol.title,
                       tick(channels && protocol.goes(SettingScope::input)),
                       tick(channels && protocol.goes(SettingScope::output)),
                       tick(protocol.make_value_reader != nullptr), carriers(protocol));
}

TEST(ProtocolPages, ListEveryProtocolAsTheTableHasIt) {
    static const std::regex link(R"(\[(`[^\]]*`)\]\([^)]*\))");
    Lines expected;
    for (const Protocol* protocol : protocols()) {
        expected.push_back(row_of(*protocol));
    }
    Lines rows;
    for (const std::string& row : lines_with("| ", page("protocols/README.md"))) {
        const std::string plain = std::regex_replace(row, link, "$1");
        if (plain.starts_with("| `")) {
            rows.push_back(plain);
        }
    }
    EXPECT_EQ(rows, expected) << fmt::format("{}", fmt::join(expected, "\n"));
}

TEST(ProtocolPages, LeadToAPageOfEachProtocolFolder) {
    const auto folder = readme().parent_path() / "docs" / "protocols";
    const auto links = links_in(page("protocols/README.md"));
    const std::set<std::string> linked(links.begin(), links.end());
    std::size_t found = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name != "README.md") {
            ++found;
            EXPECT_TRUE(linked.contains(name)) << name;
        }
    }
    EXPECT_GE(found, 20U);
}

/// The one row of a table in docs/failsafe.md that begins so.
std::string failsafe_row(const std::string& begin) {
    const Lines rows = lines_with(begin, page("failsafe.md"));
    EXPECT_EQ(rows.size(), 1U) << begin;
    return rows.empty() ? "" : rows.front();
}

TEST(ProtocolPages, NameEveryTimeoutThatIsNotTheUsualOne) {
    using std::chrono::milliseconds;
    const Duration usual = SupervisionSettings{}.timeout;
    std::map<std::string, milliseconds::rep> expected;
    for (const Protocol* protocol : protocols()) {
        if (protocol->make_decoder != nullptr &&
            protocol->default_timeout.value_or(usual) != usual) {
            expected[std::string(protocol->name)] =
                std::chrono::duration_cast<milliseconds>(*protocol->default_timeout).count();
        }
    }
    static const std::regex group(R"(((?:(?:, | and )?`[a-z0-9-]+`)+) ([0-9]+) ms)");
    static const std::regex name("`([a-z0-9-]+)`");
    const std::string row = failsafe_row("| `timeout` |");
    std::map<std::string, milliseconds::rep> shown;
    for (std::sregex_iterator match(row.begin(), row.end(), group), none; match != none; ++match) {
        const std::string names = (*match)[1];
        for (std::sregex_iterator one(names.begin(), names.end(), name); one != none; ++one) {
            shown[(*one)[1]] = std::stol((*match)[2]);
        }
    }
    EXPECT_EQ(shown, expected);
    EXPECT_TRUE(row.starts_with(fmt::format("| `timeout` | {} ms;", usual / milliseconds(1))))
        << row;
}

/// The names in ` ` behind `words`, up to the next `end`.
std::set<std::string> names_behind(const std::string& words, char end, const std::string& row) {
    static const std::regex name("`([a-z0-9-]+)`");
    const std::size_t begin = row.find(words);
    EXPECT_NE(begin, std::string::npos) << words;
    const std::string list = row.substr(begin, row.find(end, begin) - begin);
    std::set<std::string> names;
    for (std::sregex_iterator match(list.begin(), list.end(), name), none; match != none; ++match) {
        names.insert((*match)[1]);
    }
    return names;
}

TEST(ProtocolPages, NameEveryInputWhoseSenderSaysFailsafe) {
    std::set<std::string> expected;
    for (const Protocol* protocol : protocols()) {
        if (protocol->make_decoder != nullptr && protocol->signals_failsafe(SettingValues{})) {
            expected.insert(std::string(protocol->name));
        }
    }
    EXPECT_EQ(names_behind("says failsafe:", ';', failsafe_row("| `failsafe_flag` |")), expected);
}

TEST(ProtocolPages, NameEveryInputWhoseSenderHasARawZero) {
    std::set<std::string> expected;
    for (const Protocol* protocol : protocols()) {
        if (protocol->raw_zero != nullptr) {
            expected.insert(std::string(protocol->name));
        }
    }
    EXPECT_EQ(names_behind("raw zero (", ')', failsafe_row("| `failsafe_when` |")), expected);
}

}  // namespace
}  // namespace tribus::test::protocol_pages_test
