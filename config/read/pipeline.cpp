#include "config/read/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "config/language/nearest.h"
#include "config/read/failsafe.h"
#include "config/read/rules.h"
#include "config/read/selection.h"
#include "core/quotes.h"

namespace tribus {
namespace {

struct Name {
    std::string text;
    Location where;
};

/// Reads a name or a list of names. Adds a mistake and returns `nullopt` if it is neither.
std::optional<std::vector<Name>> read_names(std::string_view key, std::string_view what,
                                            const Value& value, Mistakes& mistakes) {
    std::vector<Name> names;
    const auto refuse = [&](const Value& wrong, const std::string& found) {
        mistakes.add(wrong.where, fmt::format("{} is {}; allowed: the name of an {}, or a list of "
                                              "names",
                                              in_quotes(key), found, what));
        return std::nullopt;
    };
    if (const auto* text = value.as<std::string>()) {
        return std::vector<Name>{{*text, value.where}};
    }
    const auto* list = value.as<List>();
    if (list == nullptr) {
        return refuse(value, describe(value));
    }
    if (list->items.empty()) {
        return refuse(value, "an empty list");
    }
    for (const Value& item : list->items) {
        const auto* text = item.as<std::string>();
        if (text == nullptr) {
            return refuse(item, "a list with " + describe(item));
        }
        names.push_back({*text, item.where});
    }
    return names;
}

/// The input or output with that name, or the nearest name.
template <class Drafts>
std::optional<std::size_t> resolve(const Name& name, std::string_view what, const Drafts& drafts,
                                   bool names_known, bool& uncertain, Reading reading) {
    if (const auto index = index_of(drafts, name.text)) {
        return index;
    }
    const auto names = names_in(drafts);
    const auto near = nearest(name.text, names);
    uncertain = uncertain || !near;
    if (names_known && !reading.lost.mentions(name.text)) {
        reading.mistakes.add(name.where,
                             fmt::format("no {} is named {}; {}", what, in_quotes(name.text),
                                         suggestion(name.text, names)));
    }
    return near ? index_of(drafts, *near) : std::nullopt;
}

/// Adds an index, or a mistake if it was added before.
void add_index(std::vector<std::size_t>& indices, std::size_t index, const Name& name,
               std::string_view what, Mistakes& mistakes) {
    if (std::find(indices.begin(), indices.end(), index) == indices.end()) {
        indices.push_back(index);
    } else {
        mistakes.add(name.where, fmt::format("{} {} is listed twice; list it once", what,
                                             in_quotes(name.text)));
    }
}

void read_from(const TableContent& content, PipelineConfig& pipeline, Draft& draft,
               Reading reading) {
    const Entry* from = content.find("from");
    const auto names =
        from == nullptr ? std::nullopt : read_names("from", "input", from->value, reading.mistakes);
    draft.inputs_uncertain = draft.inputs_uncertain || !names;
    for (const Name& name : names.value_or(std::vector<Name>{})) {
        if (const auto index = resolve(name, "input", draft.inputs, draft.input_names_known,
                                       draft.inputs_uncertain, reading)) {
            draft.inputs[*index].used = true;
            add_index(pipeline.selection.inputs, *index, name, "input", reading.mistakes);
        }
    }
}

void read_to(const TableContent& content, PipelineConfig& pipeline, Draft& draft, Reading reading) {
    const Entry* to = content.find("to");
    const auto names =
        to == nullptr ? std::nullopt : read_names("to", "output", to->value, reading.mistakes);
    draft.outputs_uncertain = draft.outputs_uncertain || !names;
    for (const Name& name : names.value_or(std::vector<Name>{})) {
        if (const auto index = resolve(name, "output", draft.outputs, draft.output_names_known,
                                       draft.outputs_uncertain, reading)) {
            auto& taken = draft.outputs[*index].pipeline;
            if (taken && *taken != pipeline.name) {
                reading.mistakes.add(name.where,
                                     fmt::format("output {} is already fed by [pipeline.{}]; an "
                                                 "output belongs to one pipeline",
                                                 in_quotes(name.text), *taken));
            } else {
                taken = pipeline.name;
                add_index(pipeline.outputs, *index, name, "output", reading.mistakes);
            }
        }
    }
}

}  // namespace

PipelineConfig read_pipeline(const Entry& entry, const Table& table, Draft& draft,
                             Reading reading) {
    PipelineConfig pipeline;
    pipeline.name = entry.key;
    const std::string title = fmt::format("[pipeline.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, pipeline_keys(), reading);
    read_from(content, pipeline, draft, reading);
    read_to(content, pipeline, draft, reading);
    read_selection(content, title, pipeline.selection, draft, reading);
    if (const Entry* channels = content.find("channels")) {
        PlacedRules placed = read_channels(
            channels->value, fmt::format("[pipeline.{}.channels]", entry.key), &draft, reading);
        pipeline.channels = std::move(placed.rules);
        pipeline.channels_where = std::move(placed.where);
    }
    pipeline.failsafe = read_failsafe(content.find("failsafe"), pipeline, draft, reading);
    return pipeline;
}

}  // namespace tribus
