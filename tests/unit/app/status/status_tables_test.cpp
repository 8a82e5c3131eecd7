#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "app/status/fields.h"
#include "app/status/status_json.h"
#include "pipelines/engine/machine_facts.h"
#include "transports/registry/registry.h"

/// What is written down of the rows of a status: tables of the manual, and the types of the page.
/// Each stands in its file between two marks. With TRIBUS_WRITE_TABLES set, this writes them.
namespace tribus::status_tables_test {
namespace {

std::string kind_word(const StatusField& field) {
    switch (field.kind) {
        case FieldKind::counter:
            return "counter: ";
        case FieldKind::counters:
            return "counters: ";
        case FieldKind::distribution:
            return "distribution: ";
        default:
            return "";
    }
}

std::string code_list(std::span<const std::string_view> words) {
    std::string text;
    for (const std::string_view word : words) {
        text += fmt::format("{}`{}`", text.empty() ? "" : ", ", word);
    }
    return text;
}

std::string meaning(const StatusField& field) {
    const bool tells_null = field.help.find("`null`") != std::string_view::npos;
    std::string text = kind_word(field) + std::string(field.help);
    text += field.options.may_be_null && !tells_null ? "; or `null`" : "";
    return text + (field.options.words.empty() ? "" : ". " + code_list(field.options.words));
}

std::string field_table(std::span<const StatusField> fields) {
    std::string text = "| field | meaning |\n|---|---|\n";
    for (const StatusField& field : fields) {
        if (field.options.in_status) {
            text += fmt::format("| `{}` | {} |\n", field.name, meaning(field));
        }
    }
    return text;
}

std::string metric_labels(const PartKind& kind, const StatusField& field) {
    switch (field.kind) {
        case FieldKind::word:
            return fmt::format("`{}`, `{}`", kind.label, field.name);
        case FieldKind::counters:
            return fmt::format("`{}`, `{}`", kind.label, field.options.metric_label);
        case FieldKind::distribution:
            return fmt::format("`{}`, `quantile`", kind.label);
        default:
            return fmt::format("`{}`", kind.label);
    }
}

std::string metrics_table() {
    std::string text = "| metric | further labels | type |\n|---|---|---|\n";
    for (const StatusField& field : program_fields()) {
        if (const std::string metric = metric_of(field); !metric.empty()) {
            text += fmt::format("| `{}` | | {}: {} |\n", metric, metric_type(field), field.help);
        }
    }
    for (const PartKind& kind : part_kinds()) {
        for (const StatusField& field : kind.fields) {
            if (const std::string metric = metric_of(field); !metric.empty()) {
                text += fmt::format("| `{}_{}` | {} | {}: {} |\n", kind.word, metric,
                                    metric_labels(kind, field), metric_type(field), field.help);
            }
        }
    }
    return text;
}

std::string fleet_table() {
    std::string text = "| of | field | meaning |\n|---|---|---|\n";
    const auto add = [&text](std::string_view list, std::span<const StatusField> fields) {
        for (const StatusField& field : fields) {
            if (!field.options.fleet.empty()) {
                text +=
                    fmt::format("| {} | `{}` | {} |\n", list, field.options.fleet, meaning(field));
            }
        }
    };
    add("the daemon", program_fields());
    for (const PartKind& kind : part_kinds()) {
        add(fmt::format("`{}`", kind.fleet.empty() ? "devices" : kind.fleet), kind.fields);
    }
    return text;
}

std::string type_of(const StatusField& field) {
    if (!field.options.shape.empty()) {
        return std::string(field.options.shape);
    }
    switch (field.kind) {
        case FieldKind::word: {
            std::string text;
            for (const std::string_view word : field.options.words) {
                text += fmt::format("{}'{}'", text.empty() ? "" : " | ", word);
            }
            return text;
        }
        case FieldKind::text:
            return "string";
        case FieldKind::flag:
            return "boolean";
        case FieldKind::counters:
            return "Record<string, number>";
        case FieldKind::distribution:
            return "Distribution";
        case FieldKind::channels:
            return "(number | null)[]";
        default:
            return "number";
    }
}

std::string page_fields(std::span<const StatusField> fields) {
    std::string text;
    for (const StatusField& field : fields) {
        if (field.options.in_status) {
            text += fmt::format("    {}{}: {}{};\n", field.name, field.options.optional ? "?" : "",
                                type_of(field), field.options.may_be_null ? " | null" : "");
        }
    }
    return text;
}

/// "sensor_bus" is `SensorBus` in the page.
std::string type_name(const PartKind& kind) {
    std::string name;
    bool begins = true;
    for (const char c : kind.word) {
        if (c != '_') {
            name += begins ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
        }
        begins = c == '_';
    }
    return name;
}

std::string page_types() {
    std::string text;
    std::string lists;
    for (const PartKind& kind : part_kinds()) {
        text += fmt::format("export interface {} {{\n{}}}\n\n", type_name(kind),
                            page_fields(kind.fields));
        if (!kind.list.empty()) {
            lists += fmt::format("    {}: {}[];\n", kind.list, type_name(kind));
        }
    }
    text += "export interface Machine {\n";
    for (const auto& [name, unit] : kMachineFacts) {
        text += fmt::format("    {}?: number | null;\n", machine_key({name, unit}));
    }
    text += fmt::format("}}\n\nexport interface Status {{\n{}{}    machine: Machine;\n}}\n\n",
                        page_fields(program_fields()), lists);
    text += "export const PROTOCOL_TITLES: Record<string, string> = {\n";
    for (const Protocol* protocol : protocols()) {
        text += fmt::format("    '{}': '{}',\n", protocol->name, protocol->title);
    }
    return text + "};\n";
}

struct Place {
    std::string file;
    std::string mark;
};

/// The part of a file between its marks.
void expect_stands(const Place& place, const std::string& wanted) {
    const std::string path = std::string(TRIBUS_SOURCE_DIR "/") + place.file;
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string mark = "rows of " + place.mark;
    const std::size_t mark_at = text.find(mark);
    ASSERT_NE(mark_at, std::string::npos) << path << " has no mark \"" << mark << '"';
    const std::size_t begin = text.find('\n', mark_at) + 1;
    const std::size_t end = text.rfind('\n', text.find("end of rows", begin)) + 1;
    if (std::getenv("TRIBUS_WRITE_TABLES") != nullptr) {
        std::ofstream(path) << text.substr(0, begin) << wanted << text.substr(end);
    } else {
        EXPECT_EQ(text.substr(begin, end - begin), wanted)
            << path << " is not what the rows say. To write it: TRIBUS_WRITE_TABLES=1 "
            << "build/tests/unit_tests --gtest_filter='StatusTables.*'";
    }
}

TEST(StatusTables, StandInTheManual) {
    expect_stands({"docs/status.md", "the daemon"}, field_table(program_fields()));
    for (const PartKind& kind : part_kinds()) {
        expect_stands({"docs/status.md", std::string(kind.word)}, field_table(kind.fields));
    }
}

TEST(StatusTables, StandInTheManualOfTheMetrics) {
    expect_stands({"docs/status.md", "metrics"}, metrics_table());
}

TEST(StatusTables, StandInTheManualOfTheFleet) {
    expect_stands({"docs/fleet.md", "the payload"}, fleet_table());
}

TEST(StatusTables, AreTheTypesOfThePage) {
    expect_stands({"app/web/page/src/model/status.ts", "a status"}, page_types());
}

TEST(StatusRows, HaveEachNameOnceInAPart) {
    for (const PartKind& kind : part_kinds()) {
        for (const StatusField& field : kind.fields) {
            EXPECT_EQ(std::ranges::count(kind.fields, field.name, &StatusField::name), 1)
                << kind.word << ' ' << field.name;
        }
    }
}

}  // namespace
}  // namespace tribus::status_tables_test
