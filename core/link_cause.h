#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tribus {

/// Why the frames of an input are used, or why not. The numbers are sent on a CAN bus.
enum class LinkCause : std::uint8_t {
    good,
    never_seen,        ///< no byte since the start
    wire_silent,       ///< no more bytes
    garbled,           ///< bytes, but no frames
    radio_lost,        ///< frames, but the receiver has lost the transmitter
    stale,             ///< frames that no longer change
    implausible,       ///< frames with values that no transmitter sends
    channels_missing,  ///< frames that lack a channel that was present, or have no channels
    no_key,            ///< messages, but not of a link with a key
    forged,            ///< messages that nobody with the key has made
    replayed,          ///< messages of the key's holder, but not new ones
    late,              ///< frames whose values are older than the timeout when they come
    unproved,          ///< good frames, but no output can use them yet
};
inline constexpr std::size_t kLinkCauseCount = 13;

/// Text for users, such as "radio lost".
constexpr std::string_view name_of(LinkCause cause) {
    constexpr std::array<std::string_view, kLinkCauseCount> kNames{
        "good",     "never seen",  "wire silent",      "garbled", "radio lost",
        "stale",    "implausible", "channels missing", "no key",  "forged",
        "replayed", "late",        "unproved"};
    return kNames[static_cast<std::size_t>(cause)];
}

/// The words of all causes, as machines read them, such as "radio_lost".
inline constexpr auto kLinkCauseCharacters = [] {
    std::array<std::array<char, 16>, kLinkCauseCount> words{};
    for (std::size_t cause = 0; cause < kLinkCauseCount; ++cause) {
        const std::string_view name = name_of(static_cast<LinkCause>(cause));
        for (std::size_t i = 0; i < name.size(); ++i) {
            words.at(cause).at(i) = name[i] == ' ' ? '_' : name[i];
        }
    }
    return words;
}();
inline constexpr auto kLinkCauseWords = [] {
    std::array<std::string_view, kLinkCauseCount> words;
    for (std::size_t cause = 0; cause < kLinkCauseCount; ++cause) {
        words.at(cause) = {kLinkCauseCharacters.at(cause).data(),
                           name_of(static_cast<LinkCause>(cause)).size()};
    }
    return words;
}();
constexpr std::string_view word_of(LinkCause cause) {
    return kLinkCauseWords[static_cast<std::size_t>(cause)];
}

/// The sign by which the loss of the radio link was detected.
enum class RadioLossSign : std::uint8_t {
    none,
    failsafe_flag,
    value_rule,
    frame_lost_run,    ///< every frame for some time is marked frame lost
    frame_lost_ratio,  ///< too large a share of the frames is marked frame lost
};

}  // namespace tribus
