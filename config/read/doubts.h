#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "config/keys/keys.h"
#include "config/language/mistakes.h"
#include "config/read/draft.h"
#include "pipelines/rules/settings.h"

/// Values that are allowed one by one, but with which a part never works or never does anything.
namespace tribus {

/// What a rule about one channel decides.
enum class RuleUse : std::uint8_t {
    loss,     ///< `failsafe_when`: the link is lost
    release,  ///< `release_when`: control is given
    on,       ///< a switch is on
};

/// The lowest and the highest value that a channel can have.
struct ChannelReach {
    double low = 0;
    double high = 0;
};
/// The usual travel of a stick. Some transmitters can be set to more.
inline constexpr ChannelReach kStickReach{988, 2012};
/// Full travel: every stick gets there.
inline constexpr ChannelReach kFullTravel{1000, 2000};
/// Whatever can be received.
inline constexpr ChannelReach kWireReach{0, kMostWirePulse};

/// How far the output channel can get with these rules.
ChannelReach reach_of(std::size_t channel, const std::vector<ChannelRule>& rules);

/// Warns of a rule that no value within `reach` fulfils, or every stick.
void doubt_rule(const ValueRule& rule, RuleUse use, std::string_view title, ChannelReach reach,
                Location where, Mistakes& warnings);

/// Warns of a rate with which full travel takes more than a minute.
void doubt_slew(std::optional<double> us_per_second, std::string_view key, Location where,
                Mistakes& warnings);

/// Warns of supervision with which no live stick counts. `where_frozen`, `where_plausible`: places
/// of the values.
void doubt_supervision(const SupervisionSettings& supervision, Location where_frozen,
                       Location where_plausible, Mistakes& warnings);

}  // namespace tribus
