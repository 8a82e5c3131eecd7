#include "config/check/can.h"

#include <fmt/format.h>

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/quotes.h"
#include "transports/links/can/can_link.h"

namespace tribus {
namespace {

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

void check_pair(const CanUse& earlier, const CanUse& later, Mistakes& mistakes) {
    const bool both_listen = !earlier.sends && !later.sends;
    if (both_listen || earlier.port->device != later.port->device) {
        return;
    }
    if (const auto id = shared_id(earlier, later)) {
        mistakes.add(
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

void check_can_ids(const Draft& draft, Mistakes& mistakes) {
    const auto uses = can_uses(draft);
    for (std::size_t i = 0; i < uses.size(); ++i) {
        for (std::size_t j = i + 1; j < uses.size(); ++j) {
            const bool in_order = uses[i].port->where.line <= uses[j].port->where.line;
            check_pair(uses[in_order ? i : j], uses[in_order ? j : i], mistakes);
        }
    }
    check_lane_counts(uses, mistakes);
}

}  // namespace tribus
