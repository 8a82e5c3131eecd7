#include "config/read/line.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/language/nearest.h"
#include "config/read/doubts.h"
#include "config/read/rules.h"
#include "config/schema/choices.h"
#include "core/quotes.h"
#include "pipelines/engine/output.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 1> kShowingKeys{"output"};
constexpr std::array<std::string_view, 2> kFreshKeys{"output", "period"};
constexpr std::array<std::string_view, 3> kForceKeys{"bias", "debounce", "output"};
constexpr std::array<std::string_view, 3> kSelectKeys{"bias", "debounce", "input"};
constexpr std::array<std::string_view, 2> kButtonKeys{"bias", "debounce"};
constexpr std::array<std::string_view, 5> kSwitchKeys{"output", "channel", "below", "above",
                                                      "between"};
constexpr std::array<std::string_view, 9> kRoleKeys{
    "bias", "debounce", "output", "input", "period", "channel", "below", "above", "between"};

std::span<const std::string_view> keys_of_role(LineRole role) {
    switch (role) {
        case LineRole::link:
        case LineRole::failsafe:
            return kShowingKeys;
        case LineRole::fresh:
            return kFreshKeys;
        case LineRole::force_failsafe:
            return kForceKeys;
        case LineRole::select:
            return kSelectKeys;
        case LineRole::inverter:
            return {};
        case LineRole::button:
            return kButtonKeys;
        case LineRole::channel_switch:
            return kSwitchKeys;
    }
    return {};
}

std::string roles_with(std::string_view key) {
    std::vector<std::string_view> roles;
    for (const std::string_view role : ChoiceWords<LineRole>::kAll) {
        if (role_has(*choice_named<LineRole>(role), key)) {
            roles.push_back(role);
        }
    }
    return in_quotes_all(roles);
}

void check_keys(const TableContent& content, LineRole role, Mistakes& mistakes) {
    for (const std::string_view key : kRoleKeys) {
        if (content.given(key) && !role_has(role, key)) {
            mistakes.add(content.find(key)->where,
                         fmt::format("{} has no effect with role {}: it is for {}; leave it out",
                                     in_quotes(key), in_quotes(word_of(role)), roles_with(key)));
        }
    }
}

/// Reports a missing key that only some roles require, which the key table cannot express.
void needs(const TableContent& content, std::string_view title, LineRole role, std::string_view key,
           std::string_view example, Reading reading) {
    if (!content.given(key) && !reading.lost.affects(content.where(key))) {
        reading.mistakes.add(content.where(key),
                             fmt::format("{} lacks {}; required with role {}, such as {}", title,
                                         in_quotes(key), in_quotes(word_of(role)), example));
    }
}

/// Absent if the place is not valid; then a mistake was added.
std::optional<GpioPlace> read_place(const TableContent& content, Mistakes& mistakes) {
    const Entry* line = content.find("line");
    if (line == nullptr) {
        return std::nullopt;
    }
    GpioPlace place{content.values().get_or<std::string>("chip", {}), {}};
    const auto* number = line->value.as<std::int64_t>();
    const auto* name = line->value.as<std::string>();
    if (name != nullptr && !name->empty() && content.given("chip")) {
        place.line = *name;
        return content.sound("chip") ? std::optional(std::move(place)) : std::nullopt;
    }
    if (name != nullptr && !name->empty()) {
        auto parsed = parse_gpio_place(*name);
        if (!parsed) {
            mistakes.add(line->value.where, "\"line\": " + parsed.error());
        }
        return parsed ? std::optional(std::move(*parsed)) : std::nullopt;
    }
    if (number == nullptr || *number < 0 || *number > std::numeric_limits<std::int32_t>::max()) {
        mistakes.add(line->value.where,
                     fmt::format("\"line\" is {}; allowed: the number of a line on its chip, from "
                                 "0, or a name, such as \"GPIO17\"",
                                 describe(line->value)));
        return std::nullopt;
    }
    if (!content.given("chip")) {
        mistakes.add(line->value.where,
                     fmt::format("\"line\" is {}, a number without a chip; add \"chip\", such as "
                                 "chip = \"gpiochip0\", or give the line's name",
                                 *number));
        return std::nullopt;
    }
    place.line = static_cast<unsigned>(*number);
    return content.sound("chip") ? std::optional(std::move(place)) : std::nullopt;
}

/// The input or output that the key names, or the nearest name.
template <class Drafts>
std::optional<std::size_t> read_name(const TableContent& content, std::string_view key,
                                     const Drafts& drafts, bool names_known, Reading reading) {
    const auto* name = content.values().find_as<std::string>(key);
    if (name == nullptr) {
        return std::nullopt;
    }
    if (const auto index = index_of(drafts, *name)) {
        return index;
    }
    const auto names = names_in(drafts);
    if (names_known && !reading.lost.mentions(*name)) {
        reading.mistakes.add(
            content.where(key),
            fmt::format("no {} is named {}; {}", key, in_quotes(*name), suggestion(*name, names)));
    }
    const auto near = nearest(*name, names);
    return near ? index_of(drafts, *near) : std::nullopt;
}

std::vector<std::size_t> read_outputs(const TableContent& content, const Draft& draft,
                                      Reading reading) {
    const auto named =
        read_name(content, "output", draft.outputs, draft.output_names_known, reading);
    if (named) {
        return {*named};
    }
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < draft.outputs.size() && !content.given("output"); ++i) {
        // Outputs that send only values have no failsafe.
        if (draft.outputs[i].needs_pipeline) {
            all.push_back(i);
        }
    }
    return all;
}

void check_switch_rule(const TableContent& content, std::string_view title, Reading reading) {
    constexpr std::string_view kExample = "channel = 9, above = 1700";
    needs(content, title, LineRole::channel_switch, "output", "output = \"servos\"", reading);
    needs(content, title, LineRole::channel_switch, "channel", kExample, reading);
    if (!has_value_limit(content) && !reading.lost.affects(content.where("above"))) {
        reading.mistakes.add(content.where("above"),
                             fmt::format("{} has no limit; at least one of {} is required with "
                                         "role \"switch\", such as {}",
                                         title, in_quotes_all(kValueLimits), kExample));
    }
    check_limits(content, "below", "above", "it would always be on", reading.mistakes);
}

void read_task(const TableContent& content, LineTask& task, std::string_view title,
               const Draft& draft, Reading reading) {
    const LineRole role = task.role;
    check_keys(content, role, reading.mistakes);
    if (role_has(role, "output")) {
        task.outputs = read_outputs(content, draft, reading);
    }
    if (role == LineRole::select) {
        needs(content, title, role, "input", "input = \"backup\"", reading);
        task.input = read_name(content, "input", draft.inputs, draft.input_names_known, reading)
                         .value_or(kNoInput);
    }
    if (role == LineRole::channel_switch) {
        check_switch_rule(content, title, reading);
        doubt_rule(task.rule, RuleUse::on, title, kWireReach, content.where("channel"),
                   reading.warnings);
    }
}

}  // namespace

bool role_has(LineRole role, std::string_view key) {
    const auto own = keys_of_role(role);
    return std::ranges::find(kRoleKeys, key) == kRoleKeys.end() ||
           std::ranges::find(own, key) != own.end();
}

std::optional<LineDraft> read_enable_line(const OutputConfig& output, Location where,
                                          Mistakes& mistakes) {
    const std::string_view key = output.port.medium->enable_key;
    const auto* text = output.port.settings.find_as<std::string>(key);
    if (text == nullptr) {
        return std::nullopt;
    }
    auto place = parse_gpio_place(*text);
    if (!place) {
        mistakes.add(where, fmt::format("{}: {}", in_quotes(key), place.error()));
        return std::nullopt;
    }
    LineDraft line;
    line.where = where;
    line.config.name = fmt::format("{}.{}", output.name, key);
    line.config.of_output = true;
    line.config.where = where;
    line.config.place = std::move(place).value();
    line.config.task.role = LineRole::fresh;
    line.config.task.period = std::min(4 * output.schedule.period, kMostWavePeriod);
    return line;
}

LineDraft read_line(const Entry& entry, const Table& table, const Draft& draft, Reading reading) {
    const std::string title = fmt::format("[gpio.{}]", entry.key);
    const TableContent content =
        read_table({table, entry.value.where, title}, line_keys(), reading);
    LineDraft line;
    line.where = entry.where;
    line.config.name = entry.key;
    line.config.where = content.where("line");
    content.read_into(line.config);
    auto place = read_place(content, reading.mistakes);
    line.place_sound = place.has_value();
    line.config.place = std::move(place).value_or(GpioPlace{});
    line.period = content.given("period") ? std::optional(content.where("period")) : std::nullopt;
    line.period_sound = content.sound("period");
    line.role_sound = content.given("role") && content.sound("role");
    if (line.role_sound) {
        read_task(content, line.config.task, title, draft, reading);
    }
    return line;
}

}  // namespace tribus
