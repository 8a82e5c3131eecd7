#include "app/inspect/graph_model.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "app/cli/screen_parts.h"
#include "config/schema/choices.h"
#include "transports/links/gpio/gpio_place.h"

namespace tribus {
namespace {

/// More rules would make a box higher than a page.
constexpr std::size_t kMostRules = 18;

std::size_t number_of(std::size_t channel) {
    return channel + 1;
}

struct SourceText {
    const std::vector<LineConfig>& lines;

    std::string operator()(const FromChannel& from) const {
        return fmt::format("{}", number_of(from.channel));
    }
    std::string operator()(const Mix& mix) const {
        std::string text;
        for (const MixTerm& term : mix.terms) {
            text += fmt::format("{}{:g} x {}", text.empty() ? "" : " + ", term.weight,
                                number_of(term.channel));
        }
        return text;
    }
    std::string operator()(const Fixed& fixed) const {
        return fmt::format("{:g} us", fixed.pulse.microseconds());
    }
    std::string operator()(const Switch& limit) const {
        std::string text = fmt::format("switch {}", number_of(limit.channel));
        if (limit.above) {
            text += fmt::format(" above {:g} us", limit.above->microseconds());
        }
        if (limit.below) {
            text += fmt::format("{} below {:g} us", limit.above ? " or" : "",
                                limit.below->microseconds());
        }
        return text;
    }
    std::string operator()(const FromLine& from) const { return "line " + lines[from.line].name; }
};

std::string rule_text(const ChannelRule& rule, const std::vector<LineConfig>& lines) {
    std::string text =
        fmt::format("{} = {}", number_of(rule.output), std::visit(SourceText{lines}, rule.source));
    text += rule.reverse ? ", reversed" : "";
    if (rule.trim != Pulse{}) {
        text += fmt::format(", trim {:+g}", rule.trim.microseconds());
    }
    if (rule.expo != 0) {
        text += fmt::format(", expo {:g}", rule.expo);
    }
    if (rule.min || rule.max) {
        text += fmt::format(", {} to {} us", rule.min ? rule.min->whole_microseconds() : 0,
                            rule.max ? rule.max->whole_microseconds() : 4095);
    }
    return text;
}

void add_rules(GraphBox& box, const std::vector<ChannelRule>& rules,
               const std::vector<LineConfig>& lines) {
    for (const ChannelRule& rule : rules) {
        if (box.lines.size() == kMostRules) {
            box.lines.push_back("...");
            return;
        }
        box.lines.push_back(rule_text(rule, lines));
    }
}

/// Builds the graph of one configuration.
class Drawing {
  public:
    explicit Drawing(const Configuration& configuration) : configuration_(configuration) {}

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
            add_rules(box, input.channels, configuration_.lines);
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
            box.lines.push_back("mode " + std::string(word_of(pipeline.selection.mode)));
        }
        add_rules(box, pipeline.channels, configuration_.lines);
        const std::size_t place = graph_.boxes.size();
        places_["pipeline." + pipeline.name] = place;
        graph_.boxes.push_back(std::move(box));
        const bool several = pipeline.selection.inputs.size() > 1;
        for (std::size_t i = 0; i < pipeline.selection.inputs.size(); ++i) {
            arrow(find("input", configuration_.inputs[pipeline.selection.inputs[i]].name), place,
                  several ? fmt::format("{}", i + 1) : "");
        }
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
        graph_.boxes[to].lines.push_back(fmt::format(
            "lost: {} hold, then {}", short_duration(failsafe.hold), word_of(failsafe.action)));
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
    std::map<std::string, std::size_t> places_;
    Graph graph_;
};

}  // namespace

Graph graph_of(const Configuration& configuration) {
    return Drawing(configuration).draw();
}

}  // namespace tribus
