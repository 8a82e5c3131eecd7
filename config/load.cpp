#include "config/load.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "config/build/machine_mistakes.h"
#include "config/check/cross_checks.h"
#include "config/language/encoding.h"
#include "config/language/typography.h"
#include "config/read/dronecan.h"
#include "config/read/header_lists.h"
#include "config/read/line.h"
#include "config/read/pipeline.h"
#include "config/read/ports.h"
#include "config/read/recorder.h"
#include "config/read/table.h"
#include "config/read/values.h"
#include "core/quotes.h"

namespace tribus {
namespace {

bool is_name(std::string_view text) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '_' || c == '-';
    });
}

/// Calls `read` for each table [kind.NAME]. Returns false if there is something other than tables.
template <class Read>
bool for_each_named(const Entry* kind, Reading reading, Read read) {
    if (kind == nullptr) {
        return true;
    }
    const auto* tables = kind->value.as<Table>();
    if (tables == nullptr) {
        const auto* list = kind->value.as<List>();
        const std::string found =
            list != nullptr && list->of_headers
                ? fmt::format("[[{}]] makes a list", kind->key)
                : fmt::format("{} is {}", in_quotes(kind->key), describe(kind->value));
        reading.mistakes.add(
            kind->value.where,
            fmt::format("{}; allowed: a table with a name, [{}.NAME]", found, kind->key));
        return false;
    }
    bool only_tables = true;
    for (const Entry& entry : tables->entries) {
        const auto* table = entry.value.as<Table>();
        if (table == nullptr) {
            reading.mistakes.add(entry.where,
                                 fmt::format("{} stands in [{}] itself; allowed: tables with a "
                                             "name, [{}.NAME]",
                                             in_quotes(entry.key), kind->key, kind->key));
            only_tables = false;
            continue;
        }
        if (!is_name(entry.key)) {
            reading.mistakes.add(entry.where,
                                 fmt::format("{} is not a name; allowed: letters, digits, \"_\" "
                                             "and \"-\", at least one",
                                             in_quotes(entry.key)));
        }
        read(entry, *table);
    }
    return only_tables;
}

RuntimeConfig read_runtime(const Entry* entry, Reading reading) {
    RuntimeConfig runtime;
    if (const auto content = read_only_table("runtime", entry, runtime_keys(), reading)) {
        content->read_into(runtime);
        runtime.cpu_where = content->where("cpu");
    }
    return runtime;
}

void read_value_tables(const TableContent& content, Draft& draft, Reading reading) {
    for_each_named(content.find("sensor_type"), reading,
                   [&](const Entry& entry, const Table& table) {
                       draft.sensor_types.push_back(read_sensor_type(entry, table, reading));
                       draft.sensor_type_places.push_back(entry.where);
                   });
    const bool values_known = for_each_named(
        content.find("values"), reading, [&](const Entry& entry, const Table& table) {
            draft.values.push_back(read_values(entry, table, reading));
        });
    const bool buses_known = for_each_named(
        content.find("sensor_bus"), reading, [&](const Entry& entry, const Table& table) {
            draft.sensor_buses.push_back(read_sensor_bus(entry, table, draft, reading));
        });
    draft.value_names_known = values_known && buses_known;
    for_each_named(content.find("dronecan"), reading, [&](const Entry& entry, const Table& table) {
        draft.dronecan.push_back(read_dronecan(entry, table, reading));
    });
}

void add_enable_lines(Draft& draft) {
    for (std::size_t i = 0; i < draft.outputs.size(); ++i) {
        if (auto line = std::exchange(draft.outputs[i].enable_line, std::nullopt)) {
            line->config.task.outputs = {i};
            draft.lines.push_back(std::move(*line));
        }
    }
}

Draft read_draft(const Document& document, Mistakes& mistakes, Mistakes& warnings) {
    const Reading reading{document.lost, mistakes, warnings};
    const TableContent content = read_table({document.root, {}, "the file"}, root_keys(), reading);
    Draft draft;
    draft.runtime = read_runtime(content.find("runtime"), reading);
    draft.recorder = read_recorder(content.find("recorder"), reading);
    draft.input_names_known =
        for_each_named(content.find("input"), reading, [&](const Entry& entry, const Table& table) {
            draft.inputs.push_back(read_input(entry, table, reading));
        });
    draft.output_names_known = for_each_named(
        content.find("output"), reading, [&](const Entry& entry, const Table& table) {
            draft.outputs.push_back(read_output(entry, table, reading));
        });
    draft.line_names_known =
        for_each_named(content.find("gpio"), reading, [&](const Entry& entry, const Table& table) {
            draft.lines.push_back(read_line(entry, table, draft, reading));
        });
    add_enable_lines(draft);
    read_value_tables(content, draft, reading);
    for_each_named(content.find("pipeline"), reading, [&](const Entry& entry, const Table& table) {
        draft.pipelines.push_back(read_pipeline(entry, table, draft, reading));
    });
    check_across(draft, reading);
    return draft;
}

Configuration finish(Draft draft, std::string_view file_name) {
    Configuration configuration;
    configuration.file = file_name;
    configuration.runtime = draft.runtime;
    configuration.recorder = std::move(draft.recorder);
    for (InputDraft& input : draft.inputs) {
        configuration.inputs.push_back(std::move(input.config));
    }
    for (OutputDraft& output : draft.outputs) {
        configuration.outputs.push_back(std::move(output.config));
    }
    configuration.pipelines = std::move(draft.pipelines);
    for (LineDraft& line : draft.lines) {
        configuration.lines.push_back(std::move(line.config));
    }
    for (SensorBusDraft& bus : draft.sensor_buses) {
        configuration.sensor_buses.push_back(std::move(bus.config));
    }
    configuration.sensor_types = std::move(draft.sensor_types);
    for (ValuesDraft& values : draft.values) {
        configuration.values.push_back(std::move(values.config));
    }
    for (DroneCanDraft& node : draft.dronecan) {
        configuration.dronecan.push_back(std::move(node.config));
    }
    return configuration;
}

}  // namespace

tl::expected<Configuration, std::vector<Mistake>> load_configuration(std::string_view text,
                                                                     std::string_view file_name) {
    Mistakes characters(file_name);
    std::string decoded_copy;
    const auto decoded = decoded_text(text, decoded_copy, characters);
    if (!decoded) {
        return tl::unexpected(characters.sorted());
    }
    Mistakes syntax(file_name);
    std::string plain_copy;
    Document document =
        read_document(with_plain_characters(*decoded, plain_copy, characters), syntax);
    if (!document.readable) {
        characters.add(syntax);
        return tl::unexpected(characters.sorted());
    }
    Mistakes meaning(file_name);
    replace_header_lists(document.root, meaning);
    Mistakes warnings(file_name);
    Draft draft = read_draft(document, meaning, warnings);
    Mistakes all = std::move(characters);
    all.add(syntax);
    // On a line with a mistake of syntax, only that counts.
    all.add(meaning.without_lines_of(syntax));
    if (!all.empty()) {
        return tl::unexpected(all.sorted());
    }
    Configuration configuration = finish(std::move(draft), file_name);
    for (Mistake& warning : warnings.sorted()) {
        configuration.warnings.push_back({warning.where, std::move(warning.text)});
    }
    return configuration;
}

tl::expected<Configuration, std::vector<Mistake>> load_configuration_file(
    const std::filesystem::path& path, FileKinds kinds) {
    const auto text = read_configuration_text(path, kinds);
    return text ? load_configuration_draft(*text, path) : tl::unexpected(text.error());
}

tl::expected<Configuration, std::vector<Mistake>> load_configuration_draft(
    std::string_view text, const std::filesystem::path& path) {
    auto configuration = load_configuration(text, path.string());
    if (configuration) {
        if (auto mistakes = mistaken_devices(*configuration); !mistakes.empty()) {
            return tl::unexpected(std::move(mistakes));
        }
    }
    return configuration;
}

tl::expected<std::string, std::vector<Mistake>> read_configuration_text(
    const std::filesystem::path& path, FileKinds kinds) {
    // One byte more shows that the file is too long.
    constexpr std::size_t kMostRead = kMostConfigurationBytes + 1;
    auto text = read_file(path, kMostRead, kinds);
    if (!text) {
        return tl::unexpected(std::vector<Mistake>{
            {path.string(),
             {},
             fmt::format("cannot be read: {}; give the path of a configuration file", text.error()),
             true}});
    }
    return *std::move(text);
}

}  // namespace tribus
