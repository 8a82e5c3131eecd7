#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/schema.h"
#include "core/channel_frame.h"
#include "core/time.h"

namespace tribus {

/// What an input of a running daemon receives just now.
struct LiveInput {
    ChannelFrame frame;
    Duration interval{};
};

/// Of each input of `running` whose link is good, as the daemon's `status` has it; nothing for the
/// others, nor where the object is no status. Pure.
std::vector<std::optional<LiveInput>> live_inputs(const Configuration& running,
                                                  const nlohmann::json& status);

/// What the outputs would say otherwise if `fresh` took the place of `running` while the inputs go
/// on with those frames: both engines hear them, under virtual time, until they are settled. A line
/// for each channel and each state that differs. What decides at a loss or a start only (re-arm
/// rules, frozen sticks) is left aside. Pure.
std::string live_difference(const Configuration& running, const Configuration& fresh,
                            const std::vector<std::optional<LiveInput>>& inputs);

}  // namespace tribus
