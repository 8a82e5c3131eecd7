#include <array>
#include <cstddef>

#include "app/state_text/part_text.h"
#include "app/status/field_tables.h"
#include "app/status/field_values.h"
#include "config/schema/choices.h"

namespace tribus {
namespace can_fields {
namespace {

using namespace field_values;

OrderedJson state(const StatusPart& part) {
    return can_state_word(of<PortReport>(part));
}
OrderedJson ready(const StatusPart& part) {
    return can_state_word(of<PortReport>(part)) == kCanStateWords.front();
}

constexpr StatusField kFields[]{
    {"ready",
     FieldKind::flag,
     "the interface can send without trouble",
     ready,
     {.metric = "ready", .in_status = false}},
    {"state",
     FieldKind::word,
     "what the interface can do; `gone`: it is not present",
     state,
     {.words = kCanStateWords, .metric = "state", .fleet = "bus"}},
    {"received",
     FieldKind::counter,
     "frames received",
     member<&CanCounts::received>,
     {.metric = "received_frames_total"}},
    {"sent",
     FieldKind::counter,
     "frames that the kernel took",
     member<&CanCounts::sent>,
     {.metric = "sent_frames_total"}},
    {"confirmed", FieldKind::counter, "frames that left the controller",
     member<&CanCounts::confirmed>},
    {"queue_full", FieldKind::counter, "frames for which the kernel had no room at first",
     member<&CanCounts::queue_full>},
    {"abandoned", FieldKind::counter, "snapshots of which a part was never sent",
     member<&CanCounts::abandoned>},
    {"stalls", FieldKind::counter, "times that frames waited too long for the bus",
     member<&CanCounts::stalls>},
    {"bus_offs", FieldKind::counter, "times that the controller left the bus",
     member<&CanCounts::bus_offs>},
    {"downs", FieldKind::counter, "times that the interface went down", member<&CanCounts::downs>},
    {"error_frames", FieldKind::counter, "error frames of the interface",
     member<&CanCounts::error_frames>},
    {"missing_acknowledges", FieldKind::counter,
     "error frames that report a missing acknowledgement",
     member<&CanCounts::missing_acknowledges>},
    {"receive_overflows", FieldKind::counter, "frames for which the socket had no room",
     member<&CanCounts::receive_overflows>},
    {"implausible_times", FieldKind::counter, "time stamps of the kernel that cannot be",
     member<&CanCounts::implausible_times>},
};

}  // namespace

constexpr PartKind kKind{"",
                         "can",
                         "port",
                         "",
                         kFields,
                         [](const StatusReport& all) { return all.ports.size(); },
                         [](const StatusPart& part) -> std::string_view {
                             return of<PortReport>(part).can ? of<PortReport>(part).name
                                                             : std::string_view();
                         }};

}  // namespace can_fields

namespace port_fields {
namespace {

using namespace field_values;

constexpr std::array<std::string_view, 2> kKinds{"serial", "can"};
OrderedJson text(const StatusPart& part) {
    const PortReport& port = of<PortReport>(part);
    return !port.present ? OrderedJson(kGoneText)
           : port.can    ? OrderedJson(can_bus_text(port.can->state, port.name))
                         : OrderedJson("is there");
}
OrderedJson can(const StatusPart& part) {
    return of<PortReport>(part).can ? fields_json(can_fields::kKind.fields, part)
                                    : OrderedJson(OrderedJson::value_t::discarded);
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "device or interface", member<&PortReport::name>},
    {"kind",
     FieldKind::word,
     "what it carries",
     [](const StatusPart& part) { return OrderedJson(kKinds[of<PortReport>(part).can ? 1 : 0]); },
     {.words = kKinds}},
    {"present",
     FieldKind::flag,
     "the device or interface is there",
     member<&PortReport::present>,
     {.metric = "present", .fleet = "present"}},
    {"text", FieldKind::text, "its state as the log says it", text},
    {"can",
     FieldKind::other,
     "of a CAN interface: see below",
     can,
     {.optional = true, .shape = "Can"}},
};

}  // namespace

constexpr PartKind kKind{
    "ports",
    "port",
    "port",
    "devices",
    kFields,
    [](const StatusReport& all) { return all.ports.size(); },
    [](const StatusPart& part) -> std::string_view { return of<PortReport>(part).name; }};

}  // namespace port_fields

namespace line_fields {
namespace {

using namespace field_values;

OrderedJson text(const StatusPart& part) {
    const LineReport& line = of<LineReport>(part);
    return !line.present  ? kGoneText
           : !line.active ? "is there"
           : *line.active ? "is active"
                          : "is not active";
}

constexpr StatusField kFields[]{
    {"name", FieldKind::text, "as configured", member<&LineConfig::name>},
    {"line", FieldKind::text, "as configured",
     [](const StatusPart& part) { return OrderedJson(to_text(of<LineConfig>(part).place)); }},
    {"present",
     FieldKind::flag,
     "its chip is there",
     member<&LineReport::present>,
     {.metric = "present"}},
    {"text", FieldKind::text, "its state in words", text},
    {"role",
     FieldKind::word,
     "as configured",
     [](const StatusPart& part) { return OrderedJson(word_of(of<LineConfig>(part).task.role)); },
     {.words = ChoiceWords<LineRole>::kAll}},
    {"active",
     FieldKind::flag,
     "`null`: it cannot be read, blinks, or carries a wave",
     member<&LineReport::active>,
     {.may_be_null = true, .metric = "active"}},
};

}  // namespace

constexpr PartKind kKind{
    "lines",
    "line",
    "line",
    "",
    kFields,
    [](const StatusReport& all) { return all.lines.size(); },
    [](const StatusPart& part) -> std::string_view { return of<LineConfig>(part).name; }};

}  // namespace line_fields

namespace node_fields {
namespace {

using namespace field_values;

OrderedJson state(const StatusPart& part) {
    return kNodeStageWords[static_cast<std::size_t>(of<NodeStatus>(part).report.state.stage)];
}
OrderedJson text(const StatusPart& part) {
    return node_text(of<NodeStatus>(part).report.state, of<NodeStatus>(part).wanted);
}
OrderedJson id(const StatusPart& part) {
    const dronecan::NodeId id = of<NodeStatus>(part).report.state.id;
    return id == dronecan::kNobody ? OrderedJson() : OrderedJson(id);
}

constexpr StatusField kFields[]{
    {"interface", FieldKind::text, "as configured", member<&NodeStatus::interface>},
    {"state",
     FieldKind::word,
     "`allocating`: it waits for an id; `conflict`: another node has its id, so it is silent",
     state,
     {.words = kNodeStageWords, .metric = "state"}},
    {"text", FieldKind::text, "its state as the log says it", text},
    {"id", FieldKind::amount, "its node id", id, {.may_be_null = true}},
    {"sent", FieldKind::counter, "own transfers", member<&dronecan::NodeCounts::sent>},
    {"received", FieldKind::counter, "transfers addressed to it, and allocation messages",
     member<&dronecan::NodeCounts::received>},
    {"errors", FieldKind::counter, "damaged or incomplete transfers",
     member<&dronecan::NodeCounts::errors>},
    {"requests", FieldKind::counter, "requests that it answered",
     member<&dronecan::NodeCounts::requests>},
    {"dropped", FieldKind::counter, "transfers that the bus did not take in time",
     member<&dronecan::NodeCounts::dropped>},
    {"conflicts", FieldKind::counter, "times that another node had its id",
     member<&dronecan::NodeCounts::conflicts>},
};

}  // namespace

constexpr PartKind kKind{
    "dronecan",
    "dronecan_node",
    "interface",
    "",
    kFields,
    [](const StatusReport& all) { return all.nodes.size(); },
    [](const StatusPart& part) -> std::string_view { return of<NodeStatus>(part).interface; }};

}  // namespace node_fields
}  // namespace tribus
