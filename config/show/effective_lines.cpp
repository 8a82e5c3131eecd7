#include "config/show/effective_lines.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/keys/rows_lines.h"
#include "config/read/line.h"
#include "config/show/effective_channels.h"

namespace tribus {
namespace {

using Json = nlohmann::ordered_json;

Json place_json(const GpioPlace& place) {
    Json json = Json::object();
    if (!place.chip.empty()) {
        json["chip"] = place.chip;
    }
    if (const auto* name = std::get_if<std::string>(&place.line)) {
        json["line"] = *name;
    } else {
        json["line"] = std::get<unsigned>(place.line);
    }
    return json;
}

}  // namespace

Json line_json(const LineConfig& line, const Configuration& configuration) {
    const LineTask& task = line.task;
    const auto has = [&](std::string_view key) {
        return std::ranges::find(keys_of_role(task.role), key) != keys_of_role(task.role).end();
    };
    SettingValues values;
    values.set("role", std::string(name_of(task.role)));
    values.set("active_low", line.active_low);
    if (has("bias")) {
        const auto bias = static_cast<std::size_t>(line.bias);
        values.set("bias", std::string(key_rows::kBiasChoices[bias]));
        values.set("debounce", task.debounce);
    }
    if (has("output") && task.outputs.size() == 1) {
        values.set("output", configuration.outputs[task.outputs.front()].name);
    }
    if (has("input")) {
        values.set("input", configuration.inputs[task.input].name);
    }
    if (has("period")) {
        values.set("period", task.period);
    }
    Json json = place_json(line.place);
    json.update(values_json(values, line_keys()));
    if (task.role == LineRole::channel_switch) {
        json.update(value_rule_json(task.rule));
    }
    return json;
}

}  // namespace tribus
