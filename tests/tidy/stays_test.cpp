#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>

#include "tests/support/pages.h"

/// The table of docs/failsafe.md, "What stays on an output": each line has its tests.
namespace tribus::test::stays_test {
namespace {

namespace fs = std::filesystem;

/// Whether a file of tests has a suite of that name.
bool is_suite(const std::string& name) {
    static const std::string all = [] {
        std::string text;
        for (const fs::path& file : project_files()) {
            if (file.extension() == ".cpp" && file.string().find("tests/") != std::string::npos) {
                text += source_text(file);
            }
        }
        return text;
    }();
    return all.find("TEST(" + name + ",") != std::string::npos ||
           all.find("TEST_F(" + name + ",") != std::string::npos ||
           all.find("TEST_P(" + name + ",") != std::string::npos;
}

TEST(Stays, EachLineOfTheTableNamesTestsThatThereAre) {
    std::istringstream page(source_text("docs/failsafe.md"));
    std::string line;
    while (std::getline(page, line) && line != "### What stays on an output") {
    }
    static const std::regex name("`([A-Z][A-Za-z]+)`");
    std::size_t rows = 0;
    while (std::getline(page, line) && !line.starts_with('#')) {
        if (!line.starts_with('|') || line.starts_with("|---") || line.ends_with("shown by |")) {
            continue;
        }
        ++rows;
        const std::string shown_by = line.substr(line.rfind('|', line.size() - 2));
        const std::sregex_iterator first(shown_by.begin(), shown_by.end(), name);
        EXPECT_NE(first, std::sregex_iterator()) << line;
        for (std::sregex_iterator suite = first; suite != std::sregex_iterator(); ++suite) {
            EXPECT_TRUE(is_suite((*suite)[1])) << (*suite)[1];
        }
    }
    EXPECT_EQ(rows, 13U);
}

}  // namespace
}  // namespace tribus::test::stays_test
