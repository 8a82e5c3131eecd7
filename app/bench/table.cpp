#include "app/bench/table.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace tribus::bench {
namespace {

constexpr std::size_t kFigureWidth = 9;
constexpr std::size_t kRatioWidth = 6;
constexpr std::size_t kColumns = 5;

/// Breaks at blanks; a word longer than `width` is cut.
std::vector<std::string> wrap(std::string_view text, std::size_t width) {
    std::vector<std::string> lines{""};
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(' '), text.size());
        const std::string_view word = text.substr(0, std::min(end, width));
        text.remove_prefix(word.size());
        text.remove_prefix(text.starts_with(' ') ? 1 : 0);
        std::string& line = lines.back();
        if (line.empty()) {
            line = word;
        } else if (line.size() + 1 + word.size() <= width) {
            line += fmt::format(" {}", word);
        } else {
            lines.emplace_back(word);
        }
    }
    return lines;
}

std::string cell(const std::vector<std::string>& lines, std::size_t line) {
    return line < lines.size() ? lines[line] : std::string();
}

bool is_heading(const Row& row) {
    return row.figure.empty() && row.anchor.empty() && row.reading.empty();
}

void append_row(std::string& table, const std::array<std::string, kColumns>& texts,
                const std::array<std::size_t, kColumns>& widths) {
    std::array<std::vector<std::string>, kColumns> cells;
    std::size_t height = 0;
    for (std::size_t i = 0; i < kColumns; ++i) {
        cells[i] = wrap(texts[i], widths[i]);
        height = std::max(height, cells[i].size());
    }
    for (std::size_t line = 0; line < height; ++line) {
        std::string text = fmt::format("{:<{}} ", cell(cells[0], line), widths[0]);
        for (std::size_t i = 1; i + 1 < kColumns; ++i) {
            text += fmt::format("{:>{}} ", cell(cells[i], line), widths[i]);
        }
        text += fmt::format(" {}", cell(cells.back(), line));
        text.erase(text.find_last_not_of(' ') + 1);
        table += text + "\n";
    }
}

}  // namespace

std::string draw_table(std::span<const Row> rows, std::size_t columns) {
    columns = std::max(columns, kLeastTableColumns);
    // The rest of the line is shared by the two text columns; five blanks separate columns.
    const std::size_t words = columns - 2 * kFigureWidth - kRatioWidth - kColumns;
    const std::size_t what = words * 45 / 100;
    const std::array<std::size_t, kColumns> widths{what, kFigureWidth, kFigureWidth, kRatioWidth,
                                                   words - what};
    std::string table;
    append_row(table, {"what", "figure", "beside", "ratio", "reading"}, widths);
    table += std::string(columns, '-') + "\n";
    for (const Row& row : rows) {
        if (is_heading(row)) {
            table += table.ends_with("-\n") ? "" : "\n";
            for (const std::string& line : wrap(row.what, columns)) {
                table += line + "\n";
            }
            continue;
        }
        append_row(table,
                   {row.what, row.figure, row.anchor,
                    row.ratio ? fmt::format("{:.2f}", *row.ratio) : "", row.reading},
                   widths);
    }
    return table;
}

std::string reading_of(double ratio, double noise, const std::string& peer) {
    constexpr double kAsGood = 1.10;
    constexpr double kNearly = 1.5;
    constexpr double kBetter = 0.90;
    if (ratio <= kBetter) {
        return "better than " + peer;
    }
    if (ratio <= kAsGood * noise) {
        return "as good as " + peer;
    }
    return ratio <= kNearly * noise ? "nearly as good as " + peer : "worse than " + peer;
}

}  // namespace tribus::bench
