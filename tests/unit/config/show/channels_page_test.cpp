#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "pipelines/rules/channel_map.h"
#include "tests/support/shell.h"
#include "tests/unit/config/main_job.h"

/// The worked examples of docs/channels.md are true. A table has pulses in its head, and in each
/// row a rule of the map with what it makes of them; or it follows a block of TOML, and each row
/// has pulses that come in and those that go out.
namespace tribus::test::channels_page_test {
namespace {

using Cells = std::vector<std::string>;

struct ExampleTable {
    std::string section;  ///< the heading above it
    std::string toml;     ///< the block before it
    Cells head;
    std::vector<Cells> rows;
};

/// Returns "a" and "b" for `| a | b |`.
Cells cells_of(const std::string& line) {
    Cells cells;
    std::istringstream text(line.substr(1));
    for (std::string cell; std::getline(text, cell, '|');) {
        const std::size_t begin = cell.find_first_not_of(" `");
        const std::size_t end = cell.find_last_not_of(" `");
        cells.push_back(begin == std::string::npos ? "" : cell.substr(begin, end - begin + 1));
    }
    return cells;
}

std::vector<ExampleTable> tables_of_page() {
    std::ifstream page(std::filesystem::path(TRIBUS_SOURCE_DIR) / "docs" / "channels.md");
    std::vector<ExampleTable> tables;
    ExampleTable next;
    bool fenced = false;
    bool in_table = false;
    for (std::string line; std::getline(page, line);) {
        const bool row = !fenced && line.starts_with('|');
        if (row && !in_table) {
            next.head = cells_of(line);
            tables.push_back(next);
        } else if (row && !line.starts_with("|--")) {
            tables.back().rows.push_back(cells_of(line));
        } else if (line.starts_with("```")) {
            fenced = !fenced;
            next.toml = fenced ? "" : next.toml;
        } else if (fenced) {
            next.toml += line + "\n";
        } else if (line.starts_with('#')) {
            next.section = line.substr(line.find(' ') + 1);
        }
        in_table = row;
    }
    return tables;
}

std::optional<Pulse> pulse_in(const std::string& cell) {
    char* end = nullptr;
    const double microseconds = std::strtod(cell.c_str(), &end);
    return cell.empty() || *end != '\0'
               ? std::nullopt
               : std::optional(Pulse::from_fractional_microseconds(microseconds));
}

/// The map in a piece of TOML, which is of the pipeline unless it says that it is of an input.
ChannelMap map_in(std::string toml) {
    constexpr std::string_view kInputMap = "[input.tail.map]";
    const bool of_input = toml.starts_with(kInputMap);
    if (of_input) {
        toml = "[input.receiver.map]" + toml.substr(kInputMap.size());
    } else if (!toml.starts_with('[')) {
        toml = "[pipeline.main.channels]\n" + toml;
    }
    const Configuration configuration = loaded(main_job_with(10, toml));
    if (configuration.pipelines.empty()) {
        return ChannelMap({});
    }
    return ChannelMap(of_input ? configuration.inputs[0].channels
                               : configuration.pipelines[0].channels);
}

ChannelFrame centred() {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, kCentrePulse);
    }
    return frame;
}

ChannelFrame all_at(Pulse pulse) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        frame.set(channel, pulse);
    }
    return frame;
}

/// Counted from 0, of "in 1" or "out 17".
std::optional<std::size_t> channel_in(const std::string& head, std::string_view word) {
    return head.starts_with(word)
               ? std::optional<std::size_t>(std::stoul(head.substr(word.size())) - 1)
               : std::nullopt;
}

std::size_t expect_rules(const ExampleTable& table) {
    std::size_t compared = 0;
    for (const Cells& row : table.rows) {
        ChannelMap map = map_in(row[0]);
        const std::size_t output = std::stoul(row[0]) - 1;
        for (std::size_t i = 1; i < row.size(); ++i) {
            const auto in = pulse_in(table.head[i]);
            EXPECT_TRUE(in && pulse_in(row[i])) << row[0];
            EXPECT_EQ(map.apply(all_at(in.value_or(Pulse{})), Instant{}).channel(output),
                      pulse_in(row[i]))
                << row[0] << " with " << table.head[i];
            ++compared;
        }
    }
    return compared;
}

std::size_t expect_block(const ExampleTable& table) {
    std::size_t compared = 0;
    ChannelMap map = map_in(table.toml);
    for (const Cells& row : table.rows) {
        ChannelFrame input = centred();
        Instant now{};
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (const auto channel = channel_in(table.head[i], "in ")) {
                input.set(*channel, pulse_in(row[i]).value_or(Pulse{}));
            } else if (table.head[i] == "ms") {
                now += std::chrono::milliseconds(std::stoul(row[i]));
            }
        }
        const ChannelFrame output = map.apply(input, now);
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (const auto channel = channel_in(table.head[i], "out ")) {
                EXPECT_EQ(output.channel(*channel), pulse_in(row[i]))
                    << table.toml << table.head[i] << " of row " << row[0] << " " << row[1];
                ++compared;
            }
        }
    }
    return compared;
}

bool has_inputs(const ExampleTable& table) {
    return table.head[0].starts_with("in ") || table.head[0] == "ms";
}

TEST(ChannelsPage, EveryWorkedExampleIsTrue) {
    std::map<std::string, std::size_t> compared;
    for (const ExampleTable& table : tables_of_page()) {
        if (table.head[0] == "TOML") {
            compared[table.section] += expect_rules(table);
        } else if (has_inputs(table)) {
            compared[table.section] += expect_block(table);
        }
    }
    for (const char* section :
         {"Reorder", "Reverse, trim, limits", "Expo, deadband", "Scale: a mix of one channel",
          "Mix", "Switch, constant", "Slew", "All steps together", "A map of one receiver"}) {
        EXPECT_GE(compared[section], 4U) << section;
    }
}

/// Channels 1 to 4 of the last frame for which `wanted` holds, as `tribus decode` tells it.
Cells last_of(const std::string& decoded, bool failsafe) {
    Cells found;
    std::istringstream lines(decoded);
    for (std::string line; std::getline(lines, line);) {
        const auto frame = nlohmann::json::parse(line);
        if (frame.contains("channels") && frame["failsafe"] == failsafe) {
            found.clear();
            for (std::size_t i = 0; i < 4; ++i) {
                found.push_back(frame["channels"][i].dump());
            }
        }
    }
    return found;
}

TEST(ChannelsPage, TheExampleOfPresetsIsTrue) {
    const auto tables = tables_of_page();
    const auto table = std::ranges::find_if(tables, [](const ExampleTable& candidate) {
        return candidate.section == "Presets" && !candidate.rows.empty();
    });
    ASSERT_NE(table, tables.end());
    const test::TemporaryFolder folder;
    folder.write("t.toml", main_job_with(10, table->toml));
    const test::Ended ended = test::run_in_shell(
        "cd '" + folder.path().string() +
        "'; for t in $(seq 0 7700 1540000); do "
        "echo \"{\\\"t_us\\\":$t,\\\"channels\\\":[1600,1600,1600,1600]}\"; done | "
        "\"$TRIBUS\" encode --protocol ibus --format timed > in.txt && "
        "\"$TRIBUS\" simulate t.toml --in receiver=in.txt --out servos=out.txt > log 2>&1 && "
        "\"$TRIBUS\" decode --protocol sbus --format json out.txt");
    ASSERT_EQ(ended.status, 0) << ended.output << folder.read("log");
    for (const Cells& row : table->rows) {
        EXPECT_EQ(last_of(ended.output, row[0] == "in failsafe"), Cells(row.begin() + 1, row.end()))
            << row[0];
    }
}

}  // namespace
}  // namespace tribus::test::channels_page_test
