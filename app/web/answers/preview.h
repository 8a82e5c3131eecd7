#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/schema/schema.h"

namespace tribus::web {

/// The channels that a draft changes while the sticks are as they are:
/// `[{"output", "channels": [{"channel", "now_us", "then_us"}]}]`, null for none. Maps of inputs
/// and pipelines are applied to the frames in `status`; GPIO lines count as not active, and a
/// pipeline has the first of its inputs that is good. Pure.
nlohmann::ordered_json channels_changed_by(const Configuration& running, const Configuration& draft,
                                           const nlohmann::json& status);

}  // namespace tribus::web
