#include "config/check/can.h"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "config/check/pairs.h"
#include "config/schema/value_catalog.h"
#include "core/quotes.h"
#include "transports/links/can/can_link.h"

namespace tribus {
namespace {

constexpr std::string_view kOfValues = "values";

struct CanUse {
    std::string_view direction;
    std::string_view name;
    const PortConfig* port = nullptr;
    std::vector<CanIdMatch> ids;
    bool sends = false;
};

std::vector<CanIdMatch> copy(std::span<const CanIdMatch> ids) {
    return {ids.begin(), ids.end()};
}

bool on_can(const PortConfig& port, bool port_sound, bool settings_sound) {
    return port_sound && settings_sound && port.medium->shape == WireShape::can_frames;
}

std::vector<CanUse> can_uses(const Draft& draft) {
    std::vector<CanUse> uses;
    for (const InputDraft& input : draft.inputs) {
        if (on_can(input.config.port, input.port_sound, input.settings_sound)) {
            const auto decoder = make_can_decoder(*input.config.protocol, input.config.settings);
            uses.push_back(
                {"input", input.config.name, &input.config.port, copy(decoder->wanted()), false});
            if (!decoder->answered().empty()) {
                uses.push_back({"input", input.config.name, &input.config.port,
                                copy(decoder->answered()), true});
            }
        }
    }
    for (const OutputDraft& output : draft.outputs) {
        if (on_can(output.config.port, output.port_sound, output.settings_sound)) {
            const FrameEncoder encoder(
                output.config.protocol->make_encoder(output.config.settings));
            uses.push_back({"output", output.config.name, &output.config.port,
                            copy(encoder.encoder().sent()), true});
        }
    }
    for (const ValuesDraft& values : draft.values) {
        const auto* message = std::get_if<ValueMessageConfig>(&values.config.source);
        const auto reader =
            message != nullptr && values.sound ? make_reader(*message) : std::nullopt;
        const auto* on_bus =
            reader ? std::get_if<std::unique_ptr<CanValueReader>>(&*reader) : nullptr;
        if (on_bus != nullptr) {
            uses.push_back(
                {kOfValues, values.config.name, &message->port, copy((*on_bus)->wanted()), false});
        }
    }
    return uses;
}

std::optional<CanIdMatch> shared_id(const CanUse& a, const CanUse& b) {
    for (const CanIdMatch& mine : a.ids) {
        for (const CanIdMatch& other : b.ids) {
            if (mine.overlaps(other)) {
                return mine;
            }
        }
    }
    return std::nullopt;
}

/// An output and a reader of values: the value that is read may be one that is sent.
void doubt_values(const CanUse& earlier, const CanUse& later, Mistakes& warnings) {
    const CanUse& values = earlier.direction == kOfValues ? earlier : later;
    const CanUse& output = earlier.direction == kOfValues ? later : earlier;
    warnings.add(values.port->where,
                 fmt::format("[values.{}] reads on {} a message that [output.{}] in line {} sends, "
                             "so its values come from this program itself; read a message of "
                             "another node",
                             values.name, in_quotes(values.port->device), output.name,
                             output.port->where.line));
}

void check_pair(const CanUse& earlier, const CanUse& later, Reading reading) {
    const bool both_listen = !earlier.sends && !later.sends;
    if (both_listen || earlier.port->device != later.port->device) {
        return;
    }
    const auto id = shared_id(earlier, later);
    if (id && (earlier.direction == kOfValues || later.direction == kOfValues)) {
        doubt_values(earlier, later, reading.warnings);
    } else if (id) {
        reading.mistakes.add(
            later.port->where,
            fmt::format(
                "on {} the id 0x{:X}{} of [{}.{}] is also used by [{}.{}] in line {}; allowed: ids "
                "that only one output sends and no input of the same file receives",
                in_quotes(later.port->device), id->id, id->extended ? " (29 bits)" : "",
                later.direction, later.name, earlier.direction, earlier.name,
                earlier.port->where.line));
    }
}

void check_lane_counts(const std::vector<CanUse>& uses, Mistakes& mistakes) {
    std::map<std::string_view, std::size_t> outputs;
    for (const CanUse& use : uses) {
        if (use.sends && ++outputs[use.port->device] == kMostCanOutputs + 1) {
            mistakes.add(use.port->where,
                         fmt::format("{} has more outputs than an interface can serve; allowed: "
                                     "{} outputs on one interface",
                                     in_quotes(use.port->device), kMostCanOutputs));
        }
    }
}

}  // namespace

void check_can_ids(const Draft& draft, Reading reading) {
    const auto uses = can_uses(draft);
    for_each_pair(
        uses, [](const CanUse& use) { return use.port->where.line; },
        [&](const CanUse& earlier, const CanUse& later) { check_pair(earlier, later, reading); });
    check_lane_counts(uses, reading.mistakes);
}

}  // namespace tribus
