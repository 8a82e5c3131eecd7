#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/setting.h"
#include "transports/codecs/protocol.h"

/// The keys of a protocol whose messages can be proved by a key.
namespace tribus::authenticated {

inline constexpr Setting kKeySetting{
    .key = "key",
    .type = SettingType::key_file,
    .absent = "no key",
    .help =
        "Key file that both ends have (`tribus key new`): only new frames of its holder count, "
        "and their age is known",
    .example = "\"/etc/tribus/keys/boat.key\""};
inline constexpr Setting kOldKeySetting{
    .key = "old_key",
    .type = SettingType::key_file,
    .absent = "only `key` counts",
    .scope = SettingScope::input,
    .help = "A second key that counts too, while the sender still has it",
    .example = "\"/etc/tribus/keys/boat-2025.key\""};
inline constexpr Setting kLinkSetting{
    .key = "link",
    .type = SettingType::text,
    .absent = "no name",
    .help =
        "With `key`: name of the link, the same at both ends; links with one key need different "
        "names",
    .example = "\"boat to shore\""};

inline constexpr Setting kEpochSetting{
    .key = "epoch",
    .type = SettingType::text,
    .absent = "receivers answer",
    .help =
        "With `key`: receivers do not answer, so that one sender can have many of them. A file "
        "of this end, in a folder that the program may write, keeps which frames were used",
    .example = "\"/var/lib/tribus/boat.epoch\""};

/// The link of these settings; nothing without `key`. `place`: what else tells it from other links,
/// the same at both ends.
std::optional<LinkWithKey> link_of(const SettingValues& settings, const std::string& place);
/// Adds a mistake for each setting that has no effect without `key`, if there is none, and for an
/// epoch file whose place depends on where the program runs.
void check_link(const SettingValues& settings, std::vector<SettingMistake>& mistakes);

}  // namespace tribus::authenticated
