#include "config/check/ports.h"

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "config/check/pairs.h"
#include "core/quotes.h"

namespace tribus {
namespace {

struct NamedPort {
    std::string_view direction;
    std::string_view name;
    const PortConfig* port = nullptr;
    /// The same for all names of one place.
    std::string identity = {};

    bool sends() const { return direction == "output"; }
};

std::vector<NamedPort> ports_of(const Draft& draft) {
    std::vector<NamedPort> ports;
    for (const InputDraft& input : draft.inputs) {
        if (input.port_sound) {
            ports.push_back({"input", input.config.name, &input.config.port});
        }
    }
    for (const OutputDraft& output : draft.outputs) {
        if (output.port_sound) {
            ports.push_back({"output", output.config.name, &output.config.port});
        }
    }
    for (const SensorBusDraft& bus : draft.sensor_buses) {
        if (bus.port_sound) {
            ports.push_back({"sensor_bus", bus.config.name, &bus.config.port});
        }
    }
    for (const ValuesDraft& values : draft.values) {
        const auto* message = std::get_if<ValueMessageConfig>(&values.config.source);
        if (message != nullptr && values.sound) {
            ports.push_back({"values", values.config.name, &message->port});
        }
    }
    for (NamedPort& each : ports) {
        each.identity = each.port->medium->identity_of(each.port->device);
    }
    return ports;
}

void doubt_path(const PortConfig& port, Mistakes& warnings) {
    if (port.medium->place_is_path && !port.device.starts_with('/')) {
        warnings.add(
            port.where,
            fmt::format("{} is {}, which counts from the folder in which the program is "
                        "started; write the whole path, such as {}",
                        in_quotes(port.medium->place.key), in_quotes(port.device),
                        in_quotes(port.device.starts_with("dev/")
                                      ? "/" + port.device
                                      : "/dev/" + port.device.substr(port.device.rfind('/') + 1))));
    }
}

void doubt_two_names(const NamedPort& earlier, const NamedPort& later, Mistakes& warnings) {
    const Medium& medium = *later.port->medium;
    if (medium.users == Users::many || earlier.identity != later.identity) {
        return;
    }
    warnings.add(
        later.port->where,
        fmt::format("{} {} is the port that [{}.{}] in line {} names {}, and only one of "
                    "the two can open it; give both the same name",
                    medium.place.key, in_quotes(later.port->device), earlier.direction,
                    earlier.name, earlier.port->where.line, in_quotes(earlier.port->device)));
}

void doubt_loop(const NamedPort& sender, const NamedPort& hearer, Mistakes& warnings) {
    const Medium& medium = *sender.port->medium;
    if (!sender.sends() || hearer.sends() || medium.reaches == nullptr ||
        !medium.reaches(sender.port->device, hearer.port->device)) {
        return;
    }
    warnings.add(hearer.port->where,
                 fmt::format("[{}.{}] hears at {} what [output.{}] in line {} sends to {}, so this "
                             "program would follow itself; give them different ports",
                             hearer.direction, hearer.name, in_quotes(hearer.port->device),
                             sender.name, sender.port->where.line, in_quotes(sender.port->device)));
}

}  // namespace

void doubt_ports(const Draft& draft, Mistakes& warnings) {
    const auto ports = ports_of(draft);
    for (const NamedPort& port : ports) {
        doubt_path(*port.port, warnings);
    }
    for_each_pair(
        ports, [](const NamedPort& port) { return port.port->where.line; },
        [&](const NamedPort& earlier, const NamedPort& later) {
            if (earlier.port->medium == later.port->medium &&
                earlier.port->device != later.port->device) {
                doubt_two_names(earlier, later, warnings);
                doubt_loop(earlier, later, warnings);
                doubt_loop(later, earlier, warnings);
            }
        });
}

}  // namespace tribus
