#include "app/status/status_json.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/status/field_values.h"
#include "app/status/fields.h"
#include "app/status/metrics_text.h"
#include "pipelines/engine/machine_facts.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson machine_json(const StatusReport& report) {
    OrderedJson json = OrderedJson::object();
    for (std::size_t fact = 0; fact < report.machine.size(); ++fact) {
        const auto& number = report.machine[fact];
        json[machine_key(kMachineFacts[fact])] =
            number ? field_values::finite(*number) : OrderedJson();
    }
    return json;
}

}  // namespace

std::string machine_key(const FactName& fact) {
    const std::string unit(fact.unit == "%" ? "percent" : fact.unit);
    return std::string(fact.name) + (unit.empty() ? "" : "_") + unit;
}

std::string status_json(const StatusReport& report) {
    ObjectText json;
    const OrderedJson program = fields_json(program_fields(), {report, 0});
    for (const auto& [name, value] : program.items()) {
        json.add(name, value);
    }
    for (const PartKind& kind : part_kinds()) {
        if (!kind.list.empty()) {
            json.add_list(kind.list, kind.count(report), [&](std::size_t index) {
                return fields_json(kind.fields, {report, index});
            });
        }
    }
    json.add("machine", machine_json(report));
    return std::move(json).end();
}

std::string metrics_json(const StatusReport& report) {
    ObjectText json;
    json.add("type", "metrics");
    json.add("text", metrics_text(report));
    return std::move(json).end();
}

}  // namespace tribus
