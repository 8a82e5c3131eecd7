#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/schema/schema.h"
#include "core/channel_frame.h"
#include "core/time.h"

namespace tribus {

/// What an input of a running daemon receives at present.
struct LiveInput {
    ChannelFrame frame;
    Duration interval{};
};

/// For each input of `running` with a good link, its state from the daemon's `status`; nothing for
/// the others, or if the object is no status. Pure.
std::vector<std::optional<LiveInput>> live_inputs(const Configuration& running,
                                                  const nlohmann::json& status);

/// How the outputs would change if `fresh` replaced `running` while the inputs keep these frames.
/// Runs both engines in virtual time until they settle. One line for each channel and each state
/// that differs. Ignores what matters only at a loss or a start (release_when, frozen sticks).
/// Pure.
std::string live_difference(const Configuration& running, const Configuration& fresh,
                            const std::vector<std::optional<LiveInput>>& inputs);

}  // namespace tribus
