#include "config/read/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "config/language/nearest.h"
#include "config/read/doubts.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::size_t kLeastMedianInputs = 3;

std::optional<HandoverSettings> read_handover(const Value& value, std::string_view title,
                                              const SelectionSettings& selection,
                                              const Draft& draft, Reading reading) {
    const auto* table = value.as<Table>();
    if (table == nullptr) {
        reading.mistakes.add(value.where,
                             fmt::format("\"handover\" is {}; allowed: a table, such as {{ input "
                                         "= \"main\", channel = 8 }}",
                                         describe(value)));
        return std::nullopt;
    }
    const TableContent content =
        read_table({*table, value.where, "\"handover\""}, handover_keys(), reading);
    const auto name = content.values().get_or<std::string>("input", {});
    std::vector<std::string_view> names;
    for (const std::size_t index : selection.inputs) {
        names.emplace_back(draft.inputs[index].config.name);
    }
    const auto place = std::ranges::find(names, name);
    if (place != names.end()) {
        HandoverSettings handover{.input = static_cast<std::size_t>(place - names.begin())};
        content.read_into(handover);
        return handover;
    }
    if (content.given("input") && content.sound("input") && !draft.inputs_uncertain) {
        reading.mistakes.add(
            content.where("input"),
            fmt::format("{} has no input {}; {}", title, in_quotes(name), suggestion(name, names)));
    }
    return std::nullopt;
}

/// Reports keys that only apply to several inputs.
void check_use(const TableContent& content, std::string_view title,
               const SelectionSettings& selection, Mistakes& mistakes) {
    const std::size_t count = selection.inputs.size();
    if (count > kMostPipelineInputs) {
        mistakes.add(content.where("from"), fmt::format("{} has {} inputs; allowed: at most {}",
                                                        title, count, kMostPipelineInputs));
    }
    if (selection.mode == SelectionMode::median && content.sound("mode") &&
        count < kLeastMedianInputs) {
        mistakes.add(content.where("mode"),
                     fmt::format("\"mode\" is \"median\", but {} has {} input{}: a wrong one could "
                                 "not be outvoted; allowed: three or more inputs, or another mode",
                                 title, count, count == 1 ? "" : "s"));
    }
    if (content.given("tolerance") && selection.mode != SelectionMode::median &&
        content.sound("mode")) {
        mistakes.add(content.find("tolerance")->where,
                     "\"tolerance\" has no effect: it is for mode = \"median\"; leave it out");
    }
    if (content.given("changeover") && selection.mode == SelectionMode::freshest &&
        content.sound("mode")) {
        mistakes.add(content.find("changeover")->where,
                     "\"changeover\" has no effect with mode \"freshest\", where each frame may "
                     "come from another input, so every movement would be slowed; leave it out");
    }
    for (const std::string_view key : {"handover", "changeover"}) {
        if (content.given(key) && count < 2) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} has no effect: {} has one input; leave it out, or name "
                                     "further inputs in \"from\"",
                                     in_quotes(key), title));
        }
    }
}

}  // namespace

void read_selection(const TableContent& content, std::string_view title,
                    SelectionSettings& selection, const Draft& draft, Reading reading) {
    content.read_into(selection);
    doubt_slew(selection.changeover_us_per_second, "changeover", content.where("changeover"),
               reading.warnings);
    if (const Entry* handover = content.find("handover")) {
        selection.handover = read_handover(handover->value, title, selection, draft, reading);
    }
    if (!draft.inputs_uncertain && content.given("from")) {
        check_use(content, title, selection, reading.mistakes);
    }
}

}  // namespace tribus
