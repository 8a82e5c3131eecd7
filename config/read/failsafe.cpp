#include "config/read/failsafe.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "config/language/nearest.h"
#include "config/read/rules.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// Content of one failsafe table. Empty if there is no table.
struct Given {
    std::optional<TableContent> content;
    std::optional<ValueRule> release_when;
    std::optional<Presets> presets;
    Location preset_where;

    bool has(std::string_view key) const {
        return content && content->given(key) && content->sound(key);
    }
    bool has_mistaken(std::string_view key) const { return content && !content->sound(key); }
};

Given read_given(TableContent content, Reading reading) {
    Given given;
    if (const Entry* release = content.find("release_when")) {
        given.release_when =
            read_value_rule({release->value, "\"release_when\"", "{ channel = 3, below = 1050 }",
                             "every value would release", release_rule_keys()},
                            reading);
    }
    if (const Entry* preset = content.find("preset")) {
        given.presets = read_presets(preset->value, reading.mistakes);
        given.preset_where = preset->where;
    }
    given.content = std::move(content);
    return given;
}

std::vector<std::string_view> output_names(const PipelineConfig& pipeline, const Draft& draft) {
    std::vector<std::string_view> names;
    for (const std::size_t output : pipeline.outputs) {
        names.emplace_back(draft.outputs[output].config.name);
    }
    return names;
}

using GivenByOutput = std::map<std::string, Given, std::less<>>;

/// Reads all tables [pipeline.NAME.failsafe.output.NAME].
GivenByOutput read_outputs(const Value& value, const PipelineConfig& pipeline, const Draft& draft,
                           Reading reading) {
    GivenByOutput result;
    const std::string path = fmt::format("pipeline.{}.failsafe.output", pipeline.name);
    const auto* tables = value.as<Table>();
    if (tables == nullptr) {
        reading.mistakes.add(value.where,
                             fmt::format("[{}] is {}; allowed: a table for each output that "
                                         "differs, [{}.NAME]",
                                         path, describe(value), path));
        return result;
    }
    const auto names = output_names(pipeline, draft);
    for (const Entry& entry : tables->entries) {
        const bool known = std::find(names.begin(), names.end(), entry.key) != names.end();
        if (!known && !draft.outputs_uncertain && !reading.lost.mentions(entry.key)) {
            reading.mistakes.add(entry.where,
                                 fmt::format("[pipeline.{}] has no output {}; {}", pipeline.name,
                                             in_quotes(entry.key), suggestion(entry.key, names)));
        }
        const auto* table = entry.value.as<Table>();
        if (table == nullptr) {
            reading.mistakes.add(entry.value.where, fmt::format("{} in [{}] is {}; allowed: a "
                                                                "table, [{}.NAME]",
                                                                in_quotes(entry.key), path,
                                                                describe(entry.value), path));
            continue;
        }
        TableContent content =
            read_table({*table, entry.value.where, fmt::format("[{}.{}]", path, entry.key)},
                       output_failsafe_keys(), reading);
        result.emplace(entry.key, read_given(std::move(content), reading));
    }
    return result;
}

FailsafeAction default_action(const OutputConfig& output) {
    return output.protocol != nullptr && output.protocol->signals_failsafe(output.settings)
               ? FailsafeAction::preset
               : FailsafeAction::silence;
}

FailsafeSettings combine(const Given& own, const Given& shared, const OutputConfig& output) {
    FailsafeSettings settings;
    settings.action = default_action(output);
    settings.presets = default_presets();
    for (const Given* given : {&shared, &own}) {
        if (given->content) {
            given->content->read_given_into(settings);
        }
        if (given->release_when) {
            settings.release_when = given->release_when;
        }
        settings.presets = given->presets.value_or(settings.presets);
    }
    if (!own.has("power_on") && !shared.has("power_on")) {
        settings.power_on = settings.recover;
    }
    return settings;
}

/// Rule: an output is silent or says failsafe; it never repeats old values without a mark.
void check_hold(const FailsafeSettings& settings, const Given& given, const OutputConfig& output,
                Mistakes& mistakes) {
    if (settings.action == FailsafeAction::hold && output.protocol != nullptr &&
        !output.protocol->signals_failsafe(output.settings)) {
        mistakes.add(given.content->where("action"),
                     fmt::format("\"action\" is \"hold\", but {} of output {} cannot say failsafe: "
                                 "it would repeat old values unmarked; allowed there: \"preset\", "
                                 "\"silence\"",
                                 in_quotes(output.protocol->name), in_quotes(output.name)));
    }
}

/// Reports presets that are written down but never sent, because the default action of the output
/// is silence.
void check_presets(const Given& given, bool used, Mistakes& mistakes) {
    if (given.presets && !used) {
        mistakes.add(given.preset_where,
                     "\"preset\" is not sent in failsafe: without \"action\", an output whose "
                     "protocol cannot say failsafe goes silent; add action = \"preset\", or action "
                     "= \"silence\" if \"preset\" is only for channels that the input lacks");
    }
}

}  // namespace

std::vector<FailsafeSettings> read_failsafe(const Entry* entry, const PipelineConfig& pipeline,
                                            const Draft& draft, Reading reading) {
    Given shared;
    GivenByOutput own;
    const auto* table = entry == nullptr ? nullptr : entry->value.as<Table>();
    const std::string title = fmt::format("[pipeline.{}.failsafe]", pipeline.name);
    if (table != nullptr) {
        shared = read_given(
            read_table({*table, entry->value.where, title}, failsafe_keys(), reading), reading);
        if (const Entry* outputs = shared.content->find("output")) {
            own = read_outputs(outputs->value, pipeline, draft, reading);
        }
    } else if (entry != nullptr) {
        reading.mistakes.add(entry->value.where, fmt::format("{} is {}; allowed: a table", title,
                                                             describe(entry->value)));
    }
    std::vector<FailsafeSettings> result;
    // Without certainty, no mistake is reported.
    bool shared_used = shared.has("action") || shared.has_mistaken("action") ||
                       draft.outputs_uncertain || pipeline.outputs.empty();
    for (const std::size_t index : pipeline.outputs) {
        const OutputConfig& output = draft.outputs[index].config;
        const Given& mine = own[output.name];
        result.push_back(combine(mine, shared, output));
        check_hold(result.back(), mine.has("action") ? mine : shared, output, reading.mistakes);
        const bool presets_used = mine.has("action") || mine.has_mistaken("action") ||
                                  shared.has("action") || output.protocol == nullptr ||
                                  default_action(output) == FailsafeAction::preset;
        check_presets(mine, presets_used, reading.mistakes);
        shared_used = shared_used || (presets_used && !mine.presets);
    }
    check_presets(shared, shared_used, reading.mistakes);
    return result;
}

}  // namespace tribus
