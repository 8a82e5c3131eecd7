#include <algorithm>
#include <map>
#include <utility>

#include "app/changes/change_journal.h"
#include "app/state_text/cause_text.h"
#include "app/state_text/part_text.h"
#include "config/build/dronecan.h"

/// The parts of the present configuration, and what a change of it means for them.
namespace tribus {

void ChangeJournal::take_names(const Appliance& appliance) {
    take_values(appliance);
    const Configuration& configuration = appliance.configuration();
    input_names_ = input_names(configuration);
    output_names_.clear();
    inputs_of_.clear();
    for (std::size_t i = 0; i < configuration.outputs.size(); ++i) {
        output_names_.push_back(configuration.outputs[i].name);
        const auto inputs = appliance.inputs_of(i);
        inputs_of_.emplace_back(inputs.begin(), inputs.end());
    }
    ports_.clear();
    for (const PortPlan& port : appliance.ports()) {
        ports_.push_back(port.config.device);
        if (port.config.medium->shape == WireShape::can_frames) {
            words_.try_emplace({"bus", port.config.device}, kCanStateWords.front());
        }
    }
    nodes_.clear();
    for (const NodePlan& plan : plan_nodes(configuration, {})) {
        nodes_.emplace_back(plan.port.device, plan.settings.id);
        dronecan::NodeState first{.id = plan.settings.id};
        if (plan.settings.dynamic) {
            first.stage = dronecan::NodeStage::allocating;
        }
        words_.try_emplace({"node", plan.port.device}, node_word(first));
    }
    for (const Appliance::DeviceEvent& device : appliance.devices()) {
        const bool told = !device.back && !appliance.waits_for().empty();
        if (words_.try_emplace({"device", device.name}, told ? "gone" : "there").second && told) {
            never_there_.insert(device.name);
        }
    }
}

/// Known values of the same name go on.
void ChangeJournal::take_values(const Appliance& appliance) {
    const std::vector<ValueMemory> before = std::exchange(values_, {});
    for (std::size_t i = 0; i < appliance.value_count(); ++i) {
        const NamedValue& value = appliance.value(i);
        if (is_of_part(value.name)) {
            continue;
        }
        const auto known = std::ranges::find(before, value.name, &ValueMemory::name);
        ValueMemory& memory =
            values_.emplace_back(known == before.end() ? ValueMemory{.name = value.name} : *known);
        memory.index = i;
        memory.lasts = value.lasts;
    }
}

ToldChange ChangeJournal::of_bus(std::size_t port, CanBusState state) const {
    return {.part = "bus",
            .name = ports_[port],
            .now = std::string(kCanStateWords[static_cast<std::size_t>(state)]),
            .text = can_bus_text(state, ports_[port]),
            .level = state == CanBusState::ready ? LogLevel::info : LogLevel::warning,
            .kind = "interface"};
}

ToldChange ChangeJournal::of_node(std::size_t node, const dronecan::NodeState& state) const {
    return {.part = "node",
            .name = nodes_[node].first,
            .now = node_word(state),
            .text = node_text(state, nodes_[node].second),
            .level = state.stage == dronecan::NodeStage::online     ? LogLevel::info
                     : state.stage == dronecan::NodeStage::conflict ? LogLevel::error
                                                                    : LogLevel::warning};
}

/// Another socket, or another node, has replaced one of the configuration before, and begins anew.
void ChangeJournal::compare_buses_and_nodes(const Appliance& appliance, Wall wall) {
    for (std::size_t port = 0; port < ports_.size(); ++port) {
        if (appliance.ports()[port].config.medium->shape == WireShape::can_frames &&
            appliance.port_present(port)) {
            note(of_bus(port, appliance.can_status(port).state), wall.now, wall);
        }
    }
    for (std::size_t node = 0; node < nodes_.size(); ++node) {
        note(of_node(node, appliance.node_report(node).state), wall.now, wall);
    }
}

void ChangeJournal::begin(const Appliance& appliance, Instant now, Duration wall_now) {
    std::erase_if(words_, [](const auto& word) {
        return word.first.first != "input" && word.first.first != "output";
    });
    never_there_.clear();
    values_.clear();
    taken_ = 0;
    take_names(appliance);
    outputs_.assign(output_names_.size(), {});
    for (OutputMemory& memory : outputs_) {
        memory.text = output_text({}, {});
    }
    tell_restarted({now, wall_now});
    add(appliance.devices(), now, wall_now);
}

/// Inputs and outputs that go on after a stop begin anew.
void ChangeJournal::tell_restarted(Wall wall) {
    const auto tell = [&](std::string_view part, const std::string& name, std::string_view word,
                          std::string text) {
        const auto known = words_.find({part, name});
        if (known != words_.end() && known->second != word) {
            add({.at = wall.now,
                 .wall_time = wall.wall_now,
                 .part = part,
                 .name = name,
                 .field = part == "input" ? "cause" : "state",
                 .was = known->second,
                 .now = std::string(word),
                 .text = std::move(text),
                 .state = word,
                 .level = LogLevel::info,
                 .kind = part});
            known->second = word;
        }
    };
    for (const std::string& name : output_names_) {
        tell("output", name, "failsafe", "begins anew, in failsafe");
    }
    for (const std::string& name : input_names_) {
        tell("input", name, word_of(LinkCause::never_seen), "begins anew: never seen");
    }
}

void ChangeJournal::go_on_with(const Appliance& appliance, const CarryOver& carry_over, Instant now,
                               Duration wall_now) {
    const Wall wall{now, wall_now};
    const std::vector<std::string> inputs_before = input_names_;
    const std::vector<std::string> outputs_before = output_names_;
    take_names(appliance);
    const auto words = std::exchange(words_, {});
    for (const auto& [part, word] : words) {
        if (part.first != "input" && part.first != "output") {
            words_.insert({part, word});
        }
    }
    const auto keep_word = [&](std::string_view part, const std::string& before,
                               const std::string& name) {
        if (const auto known = words.find({part, before}); known != words.end()) {
            words_[{part, name}] = known->second;
        }
    };
    std::map<std::string, std::string> names;
    for (std::size_t i = 0; i < input_names_.size(); ++i) {
        if (const CarriedFrom from = carry_over.engine.inputs[i].from) {
            keep_word("input", inputs_before[*from], input_names_[i]);
            names[inputs_before[*from]] = input_names_[i];
        }
    }
    std::vector<OutputMemory> outputs(output_names_.size());
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const CarriedFrom from = carry_over.engine.outputs[i].from;
        outputs[i] = from ? outputs_[*from] : OutputMemory{.text = output_text({}, {})};
        if (from) {
            keep_word("output", outputs_before[*from], output_names_[i]);
        }
    }
    outputs_ = std::move(outputs);
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        const std::string was = outputs_[i].input;
        const auto renamed = names.find(was);
        if (renamed != names.end() && renamed->second != was) {
            outputs_[i].input = renamed->second;
            tell_renamed(i, was, appliance.output_status(i), wall);
        }
    }
    compare_buses_and_nodes(appliance, wall);
}

/// The input in control has another name now.
void ChangeJournal::tell_renamed(std::size_t output, const std::string& was,
                                 const OutputStatus& status, Wall wall) {
    OutputMemory& memory = outputs_[output];
    memory.text = output_sentence(status.state, status.wait, input_names_) +
                  votes_text(output, 0, status.state.outvoted);
    ToldChange told = of_output(output, wall.now, status.state, status.sends, wall);
    told.field = "input";
    told.was = was;
    told.now = memory.input;
    told.text = memory.text;
    told.input = memory.input;
    add(std::move(told));
}

}  // namespace tribus
