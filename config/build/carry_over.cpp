#include "config/build/carry_over.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "config/build/dronecan.h"
#include "config/schema/value_catalog.h"

namespace tribus {
namespace {

/// For each part in `fresh`, the index of the matching part in `running`: the one with the same
/// name, or else one that is alike and has no other match.
template <class Part, class Alike>
std::vector<CarriedFrom> match(const std::vector<Part>& running, const std::vector<Part>& fresh,
                               Alike alike) {
    std::vector<CarriedFrom> from(fresh.size());
    std::vector<bool> taken(running.size(), false);
    for (const bool by_name : {true, false}) {
        for (std::size_t i = 0; i < fresh.size(); ++i) {
            for (std::size_t j = 0; j < running.size() && !from[i]; ++j) {
                if (!taken[j] && (!by_name || running[j].name == fresh[i].name) &&
                    alike(running[j], fresh[i])) {
                    from[i] = j;
                    taken[j] = true;
                }
            }
        }
    }
    return from;
}

std::vector<std::size_t> left_over(std::size_t count, const std::vector<CarriedFrom>& from) {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < count; ++i) {
        if (std::ranges::find(from, CarriedFrom(i)) == from.end()) {
            left.push_back(i);
        }
    }
    return left;
}

SettingValues without_keys(const SettingValues& settings) {
    SettingValues others;
    for (const auto& [key, value] : settings) {
        if (!std::holds_alternative<KeyFile>(value)) {
            others.set(key, value);
        }
    }
    return others;
}

/// Whether a key counts before and after: the link goes on while keys are changed.
bool have_common_key(const InputConfig& a, const InputConfig& b) {
    const auto before = link_with_key(a);
    const auto after = link_with_key(b);
    if (!before || !after) {
        return false;
    }
    const auto counts = [&](const SecretKey& secret) {
        return secret == after->secret || secret == after->old_secret;
    };
    return counts(before->secret) || (before->old_secret && counts(*before->old_secret));
}

bool alike_inputs(const InputConfig& a, const InputConfig& b) {
    return a.protocol == b.protocol && same_device(a.port, b.port) && a.port.line == b.port.line &&
           (a.settings == b.settings ||
            (without_keys(a.settings) == without_keys(b.settings) && have_common_key(a, b)));
}

bool alike_outputs(const OutputConfig& a, const OutputConfig& b) {
    return a.protocol == b.protocol && same_device(a.port, b.port) &&
           (a.protocol->shape == WireShape::bytes || a.settings == b.settings);
}

/// The pipeline of an output and the output's index in it.
struct Feed {
    const PipelineConfig* pipeline = nullptr;
    std::size_t place = 0;
};

Feed feed_of(const Configuration& configuration, std::size_t output) {
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        const auto found = std::ranges::find(pipeline.outputs, output);
        if (found != pipeline.outputs.end()) {
            return {&pipeline, static_cast<std::size_t>(found - pipeline.outputs.begin())};
        }
    }
    return {};
}

std::vector<OutputCarry> carry_outputs(const Configuration& running, const Configuration& fresh) {
    const auto from = match(running.outputs, fresh.outputs, alike_outputs);
    std::vector<OutputCarry> carries(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
        OutputCarry& carry = carries[i];
        carry.from = from[i];
        if (!from[i]) {
            continue;
        }
        const Feed before = feed_of(running, *from[i]);
        const Feed after = feed_of(fresh, i);
        const bool fed = before.pipeline != nullptr && after.pipeline != nullptr;
        carry.same_schedule = running.outputs[*from[i]].schedule == fresh.outputs[i].schedule;
        carry.same_channels = fed && before.pipeline->channels == after.pipeline->channels;
        carry.same_failsafe =
            fed && before.pipeline->failsafe[before.place] == after.pipeline->failsafe[after.place];
    }
    return carries;
}

std::vector<InputCarry> carry_inputs(const Configuration& running, const Configuration& fresh) {
    const auto from = match(running.inputs, fresh.inputs, alike_inputs);
    std::vector<InputCarry> carries(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) {
        carries[i].from = from[i];
        carries[i].same_channels =
            from[i] && running.inputs[*from[i]].channels == fresh.inputs[i].channels;
        carries[i].new_keys =
            from[i] && running.inputs[*from[i]].settings != fresh.inputs[i].settings;
    }
    return carries;
}

bool alike_nodes(const NodePlan& a, const NodePlan& b) {
    return a.port.device == b.port.device && a.settings.id == b.settings.id &&
           a.settings.dynamic == b.settings.dynamic && a.settings.name == b.settings.name &&
           a.settings.unique_id == b.settings.unique_id;
}

std::vector<CarriedFrom> carry_nodes(const Configuration& running, const Configuration& fresh,
                                     std::vector<std::size_t>& leaving) {
    const auto before = plan_nodes(running, {});
    const auto after = plan_nodes(fresh, {});
    std::vector<CarriedFrom> from(after.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
        const auto known = std::ranges::find_if(
            before, [&](const NodePlan& node) { return alike_nodes(node, after[i]); });
        if (known != before.end()) {
            from[i] = static_cast<std::size_t>(known - before.begin());
        }
    }
    leaving = left_over(before.size(), from);
    return from;
}

std::vector<const ValuesConfig*> messages_of(const Configuration& configuration) {
    std::vector<const ValuesConfig*> messages;
    for (const ValuesConfig& values : configuration.values) {
        if (std::holds_alternative<ValueMessageConfig>(values.source)) {
            messages.push_back(&values);
        }
    }
    return messages;
}

std::vector<NamedValue> values_of(const Configuration& configuration) {
    return catalog_of(value_sources(configuration)).settings.values;
}

ValueCarry carry_values(const Configuration& running, const Configuration& fresh) {
    ValueCarry carry;
    carry.buses.resize(fresh.sensor_buses.size());
    carry.messages.resize(messages_of(fresh).size());
    carry.values.resize(values_of(fresh).size());
    if (!needs_values(running) || !needs_values(fresh)) {
        return carry;
    }
    std::vector<std::string> carried;
    const bool same_types = running.sensor_types == fresh.sensor_types;
    for (std::size_t i = 0; i < fresh.sensor_buses.size(); ++i) {
        const auto known = std::ranges::find(running.sensor_buses, fresh.sensor_buses[i]);
        if (same_types && known != running.sensor_buses.end()) {
            carry.buses[i] = static_cast<std::size_t>(known - running.sensor_buses.begin());
            carried.push_back(known->name + ".");
        }
    }
    const auto messages = messages_of(running);
    const auto fresh_messages = messages_of(fresh);
    for (std::size_t i = 0; i < fresh_messages.size(); ++i) {
        const auto known = std::ranges::find_if(
            messages, [&](const ValuesConfig* values) { return *values == *fresh_messages[i]; });
        if (known != messages.end()) {
            carry.messages[i] = static_cast<std::size_t>(known - messages.begin());
            carried.push_back((*known)->name + ".");
        }
    }
    const auto before = values_of(running);
    const auto after = values_of(fresh);
    for (std::size_t i = 0; i < after.size(); ++i) {
        const bool source_is_carried = std::ranges::any_of(
            carried, [&](const std::string& source) { return after[i].name.starts_with(source); });
        const auto known = std::ranges::find(before, after[i].name, &NamedValue::name);
        if (source_is_carried && known != before.end()) {
            carry.values[i] = static_cast<std::size_t>(known - before.begin());
        }
    }
    return carry;
}

/// GPIO lines refer to inputs and outputs by their indices.
bool same_places(const Configuration& running, const Configuration& fresh) {
    const auto same_name = [](const auto& a, const auto& b) { return a.name == b.name; };
    return std::ranges::equal(running.inputs, fresh.inputs, same_name) &&
           std::ranges::equal(running.outputs, fresh.outputs, same_name);
}

std::vector<std::string> obstacles(const Configuration& running, const Configuration& fresh) {
    std::vector<std::string> found;
    const RuntimeConfig& before = running.runtime;
    const RuntimeConfig& after = fresh.runtime;
    if (before.realtime != after.realtime || before.priority != after.priority ||
        before.cpu != after.cpu) {
        found.emplace_back("[runtime] changes the scheduling of the data thread");
    }
    for (const OutputConfig& was : running.outputs) {
        for (const OutputConfig& becomes : fresh.outputs) {
            const std::string& device = becomes.port.device;
            if (was.port.medium != becomes.port.medium && was.port.device == device &&
                device.starts_with("/dev/")) {
                found.emplace_back(device + " is used in another way, and must be closed first");
            }
        }
    }
    if (running.lines != fresh.lines) {
        found.emplace_back(
            "the GPIO lines have changed, and the program must release the old ones first");
    } else if (!fresh.lines.empty() && !same_places(running, fresh)) {
        found.emplace_back("inputs or outputs that GPIO lines refer to were added or removed");
    }
    return found;
}

}  // namespace

bool same_device(const PortConfig& a, const PortConfig& b) {
    return a.medium == b.medium && (a.device == b.device || a.medium->identity_of(a.device) ==
                                                                b.medium->identity_of(b.device));
}

CarryOver plan_carry_over(const Configuration& running, const Configuration& fresh) {
    CarryOver plan;
    plan.engine.inputs = carry_inputs(running, fresh);
    plan.engine.outputs = carry_outputs(running, fresh);
    plan.engine.nodes = carry_nodes(running, fresh, plan.leaving.nodes);
    plan.values = carry_values(running, fresh);
    std::vector<CarriedFrom> outputs;
    for (const OutputCarry& carry : plan.engine.outputs) {
        outputs.push_back(carry.from);
    }
    plan.leaving.outputs = left_over(running.outputs.size(), outputs);
    plan.obstacles = obstacles(running, fresh);
    return plan;
}

}  // namespace tribus
