#include "app/inspect/graph_model.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/screen_parts.h"
#include "app/inspect/value_text.h"
#include "config/keys/keys.h"
#include "config/schema/choices.h"
#include "config/show/effective.h"
#include "transports/links/gpio/gpio_place.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// The entries of a channel map, one line each. Null: there is no map.
void add_rules(GraphBox& box, const OrderedJson& rules) {
    for (const auto& [output, rule] : rules.items()) {
        box.lines.push_back(fmt::format("{} = {}", output, channel_text(rule)));
    }
}

/// Builds the graph of one configuration.
class Drawing {
  public:
    explicit Drawing(const Configuration& configuration)
        : configuration_(configuration),
          effective_(OrderedJson::parse(effective_json(configuration))) {}

    Graph draw() {
        add_sources();
        for (const PipelineConfig& pipeline : configuration_.pipelines) {
            add_pipeline(pipeline);
        }
        for (const OutputConfig& output : configuration_.outputs) {
            add_output(output);
        }
        for (const SensorBusConfig& bus : configuration_.sensor_buses) {
            add_sensor_bus(bus);
        }
        for (const LineConfig& line : configuration_.lines) {
            add_line(line);
        }
        join();
        return std::move(graph_);
    }

  private:
    std::size_t add(GraphColumn column, const std::string& kind, const std::string& name,
                    std::vector<std::string> lines) {
        places_[kind + "." + name] = graph_.boxes.size();
        graph_.boxes.push_back({column, name, std::move(lines)});
        return graph_.boxes.size() - 1;
    }
    std::optional<std::size_t> find(const std::string& kind, const std::string& name) const {
        const auto found = places_.find(kind + "." + name);
        return found == places_.end() ? std::nullopt : std::optional(found->second);
    }
    void arrow(std::optional<std::size_t> from, std::size_t to, std::string label,
               bool dashed = false) {
        const auto same = [&](const GraphArrow& other) {
            return other.from == *from && other.to == to;
        };
        if (from && std::ranges::none_of(graph_.arrows, same)) {
            graph_.arrows.push_back({*from, to, std::move(label), dashed});
        }
    }

    void add_sources() {
        for (const InputConfig& input : configuration_.inputs) {
            GraphBox box{GraphColumn::sources, input.name, {}};
            box.lines = {fmt::format("{} from {}", input.protocol->name, input.port.device),
                         "timeout " + short_duration(input.supervision.timeout)};
            add_rules(box, effective_["input"][input.name]["map"]);
            places_["input." + input.name] = graph_.boxes.size();
            graph_.boxes.push_back(std::move(box));
        }
        for (const ValuesConfig& values : configuration_.values) {
            const auto* message = std::get_if<ValueMessageConfig>(&values.source);
            add(GraphColumn::sources, "values", values.name,
                {message == nullptr ? std::string("a constant")
                                    : "values from " + message->port.device});
        }
    }

    void add_pipeline(const PipelineConfig& pipeline) {
        GraphBox box{GraphColumn::pipelines, pipeline.name, {}};
        if (pipeline.selection.inputs.size() > 1) {
            box.lines = selection_texts(pipeline);
        }
        add_rules(box, effective_["pipeline"][pipeline.name]["channels"]);
        const std::size_t place = graph_.boxes.size();
        places_["pipeline." + pipeline.name] = place;
        graph_.boxes.push_back(std::move(box));
        const bool several = pipeline.selection.inputs.size() > 1;
        for (std::size_t i = 0; i < pipeline.selection.inputs.size(); ++i) {
            arrow(find("input", configuration_.inputs[pipeline.selection.inputs[i]].name), place,
                  several ? fmt::format("{}", i + 1) : "");
        }
    }

    /// The keys of the pipeline itself: arrows, maps and outputs show what the others say.
    std::vector<std::string> selection_texts(const PipelineConfig& pipeline) {
        OrderedJson settings = effective_["pipeline"][pipeline.name];
        for (const char* shown : {"from", "to", "mode", "channels", "failsafe"}) {
            settings.erase(shown);
        }
        std::vector<std::string> texts = row_texts(settings, pipeline_keys());
        texts.insert(texts.begin(), "mode " + std::string(word_of(pipeline.selection.mode)));
        return texts;
    }

    void add_output(const OutputConfig& output) {
        add(GraphColumn::outputs, "output", output.name,
            {fmt::format("{} to {}", output.protocol->name, output.port.device),
             fmt::format("{} {}", output.schedule.kind == ScheduleKind::grid ? "grid" : "follow",
                         short_duration(output.schedule.period))});
    }

    void add_sensor_bus(const SensorBusConfig& bus) {
        const bool receiver = bus.role == BusRole::receiver;
        std::vector<std::string> lines{
            fmt::format("{} on {}", receiver ? "polls sensors" : "is sensors", bus.port.device)};
        for (const SensorConfig& sensor : bus.sensors) {
            lines.push_back(sensor.type.name);
        }
        add(receiver ? GraphColumn::sources : GraphColumn::outputs, "bus", bus.name,
            std::move(lines));
    }

    void add_line(const LineConfig& line) {
        add(is_input_role(line.task.role) ? GraphColumn::sources : GraphColumn::lines, "gpio",
            line.name, {fmt::format("{} {}", to_text(line.place), word_of(line.task.role))});
    }

    void join() {
        for (const PipelineConfig& pipeline : configuration_.pipelines) {
            for (std::size_t i = 0; i < pipeline.outputs.size(); ++i) {
                join_output(pipeline, i);
            }
        }
        for (const OutputConfig& output : configuration_.outputs) {
            if (output.protocol->value_names != nullptr) {
                for (const NamedUse& use : output.protocol->value_names(output.settings)) {
                    arrow(source_of(use.name), *find("output", output.name), "", true);
                }
            }
        }
        for (const SensorBusConfig& bus : configuration_.sensor_buses) {
            for (const SensorConfig& sensor : bus.sensors) {
                for (const std::string& value : sensor.values) {
                    arrow(source_of(value), *find("bus", bus.name), "", true);
                }
            }
        }
        for (const LineConfig& line : configuration_.lines) {
            join_line(line);
        }
    }

    void join_output(const PipelineConfig& pipeline, std::size_t index) {
        const FailsafeSettings& failsafe = pipeline.failsafe[index];
        const std::size_t to =
            *find("output", configuration_.outputs[pipeline.outputs[index]].name);
        arrow(find("pipeline", pipeline.name), to, "");
        std::vector<std::string>& lines = graph_.boxes[to].lines;
        lines.push_back(fmt::format("lost: {} hold, then {}", short_duration(failsafe.hold),
                                    word_of(failsafe.action)));
        const std::vector<std::string> further =
            further_failsafe_texts(pipeline, configuration_.outputs[pipeline.outputs[index]].name);
        lines.insert(lines.end(), further.begin(), further.end());
    }

    /// What happens to the channels of an output on a loss, besides hold and action.
    std::vector<std::string> further_failsafe_texts(const PipelineConfig& pipeline,
                                                    const std::string& output) {
        OrderedJson settings = effective_["pipeline"][pipeline.name]["failsafe"]["output"][output];
        settings.erase("hold");
        settings.erase("action");
        if (settings["power_on"] == settings["recover"]) {
            settings.erase("power_on");
        }
        return row_texts(settings, output_failsafe_keys());
    }

    void join_line(const LineConfig& line) {
        const std::size_t place = *find("gpio", line.name);
        if (!is_input_role(line.task.role)) {
            for (const std::size_t output : line.task.outputs) {
                arrow(find("output", configuration_.outputs[output].name), place, "", true);
            }
            return;
        }
        for (const PipelineConfig& pipeline : configuration_.pipelines) {
            if (concerns(line, pipeline)) {
                arrow(place, *find("pipeline", pipeline.name), "", true);
            }
        }
    }

    bool concerns(const LineConfig& line, const PipelineConfig& pipeline) const {
        const auto among = [](const std::vector<std::size_t>& all, std::size_t one) {
            return std::ranges::find(all, one) != all.end();
        };
        if (line.task.role == LineRole::select) {
            return among(pipeline.selection.inputs, line.task.input);
        }
        if (line.task.role == LineRole::force_failsafe) {
            return std::ranges::any_of(pipeline.outputs, [&](std::size_t output) {
                return among(line.task.outputs, output);
            });
        }
        return std::ranges::any_of(pipeline.channels, [&](const ChannelRule& rule) {
            const auto* from = std::get_if<FromLine>(&rule.source);
            return from != nullptr && configuration_.lines[from->line].name == line.name;
        });
    }

    /// The box of a named value: "battery.Voltage" belongs to the values "battery",
    /// "input.main.age" to that input.
    std::optional<std::size_t> source_of(const std::string& value) {
        const std::string first = value.substr(0, value.find('.'));
        if (first == "input" || first == "output") {
            const std::string rest = value.substr(std::min(first.size() + 1, value.size()));
            return find(first, rest.substr(0, rest.find('.')));
        }
        if (first == "machine" && !find("machine", first)) {
            add(GraphColumn::sources, "machine", first, {"measurements of the board"});
        }
        for (const char* kind : {"machine", "values", "bus"}) {
            if (const auto found = find(kind, first)) {
                return found;
            }
        }
        return std::nullopt;
    }

    const Configuration& configuration_;
    OrderedJson effective_;
    std::map<std::string, std::size_t> places_;
    Graph graph_;
};

}  // namespace

Graph graph_of(const Configuration& configuration) {
    return Drawing(configuration).draw();
}

}  // namespace tribus
