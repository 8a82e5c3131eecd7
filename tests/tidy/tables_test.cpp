#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/pages.h"

/// Tables of pages are whole: a row that stands alone, or has another number of cells than its
/// table, is not shown as one.
namespace tribus::test::tables_test {
namespace {

namespace fs = std::filesystem;

/// Cells of a row. A `\|` is no border.
std::ptrdiff_t cells_of(std::string row) {
    row = std::regex_replace(row, std::regex(R"(\\\|)"), "");
    row.erase(0, row.find('|') + 1);
    const std::size_t last = row.find_last_not_of(' ');
    if (last != std::string::npos && row[last] == '|') {
        row.erase(last);
    }
    return std::ranges::count(row, '|') + 1;
}

/// What is wrong with the tables of a page, as `LINE: what`.
std::vector<std::string> broken_rows(const std::string& page) {
    static const std::regex rule(R"(\s*\|[-:| ]+\|\s*)");
    std::istringstream lines(page);
    std::vector<std::string> wrong;
    std::vector<std::string> table;
    bool fenced = false;
    std::size_t number = 0;
    const auto end_of_table = [&] {
        const std::string where = std::to_string(number - table.size());
        if (!table.empty() && (table.size() < 3 || !std::regex_match(table[1], rule))) {
            wrong.push_back(where + ": a row without a table: no empty line may be within one");
        }
        table.clear();
    };
    for (std::string line; std::getline(lines, line);) {
        ++number;
        fenced = fenced != line.starts_with("```");
        const std::size_t first = line.find_first_not_of(' ');
        if (fenced || first == std::string::npos || line[first] != '|') {
            end_of_table();
            continue;
        }
        table.push_back(line);
        if (cells_of(line) != cells_of(table.front())) {
            wrong.push_back(std::to_string(number) + ": not as many cells as the table has");
        }
    }
    ++number;
    end_of_table();
    return wrong;
}

TEST(Tables, AreWholeOnAllPages) {
    std::size_t rows = 0;
    for (const fs::path& page : project_files()) {
        if (page.extension() != ".md") {
            continue;
        }
        const std::string text = source_text(page);
        rows += static_cast<std::size_t>(std::ranges::count(text, '|'));
        for (const std::string& wrong : broken_rows(text)) {
            ADD_FAILURE() << page << ":" << wrong;
        }
    }
    EXPECT_GT(rows, 1000U);
}

TEST(Tables, ThatAreBrokenAreFound) {
    const std::string table = "| a | b |\n|---|---|\n| c | d |\n";
    EXPECT_TRUE(broken_rows("text\n\n" + table + "\ntext\n").empty());
    EXPECT_TRUE(broken_rows(table + "| `e \\| f` | g |\n").empty());
    EXPECT_TRUE(broken_rows("```\n| a picture\n```\n").empty());
    EXPECT_EQ(broken_rows(table + "\n| e | f |\n").size(), 1U);
    EXPECT_EQ(broken_rows(table + "| e | f | g |\n").size(), 1U);
    EXPECT_EQ(broken_rows("| a | b |\n").size(), 1U);
}

}  // namespace
}  // namespace tribus::test::tables_test
