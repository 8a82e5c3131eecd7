#include "config/show/effective_lines.h"

#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json.hpp>

#include "config/read/line.h"
#include "config/show/fields_json.h"

namespace tribus {

nlohmann::ordered_json line_json(const LineConfig& line, const Configuration& configuration) {
    const LineTask& task = line.task;
    nlohmann::ordered_json json = fields_json(line, line_keys());
    std::visit([&json](const auto& place) { json["line"] = place; }, line.place.line);
    if (task.outputs.size() == 1) {
        json["output"] = configuration.outputs[task.outputs.front()].name;
    }
    if (task.role == LineRole::select) {
        json["input"] = configuration.inputs[task.input].name;
    }
    return in_order_of_rows(json, line_keys(),
                            [&](std::string_view key) { return role_has(task.role, key); });
}

}  // namespace tribus
