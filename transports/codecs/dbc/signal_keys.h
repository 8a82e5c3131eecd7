#pragma once

#include <array>
#include <string_view>

#include "core/channel_frame.h"
#include "core/setting.h"

/// What may stand behind a signal of the key `signals`, for the manual. roles.cpp reads and judges
/// it; a test compares the two.
namespace tribus {

inline constexpr std::array<std::string_view, 4> kDbcFlagChoices{"failsafe", "frame_lost", "good",
                                                                 "cause"};
inline constexpr std::array<std::string_view, 7> kDbcChecksumChoices{
    "xor", "sum", "agilex", "crc8_j1850", "crc8_2f", "p01", "p05"};

inline constexpr std::array kDbcSignalKeys{
    Setting{.key = "channel",
            .type = SettingType::integer,
            .least = 1,
            .most = kChannelCount,
            .help = "The signal carries this channel",
            .example = "3"},
    Setting{.key = "value",
            .type = SettingType::pulses,
            .absent = "of a signal in \"us\" the pulse itself, else the range in the DBC file",
            .unit = "unit of the signal",
            .help = "With `channel`: two different values of the signal that belong to the "
                    "pulses `us`",
            .example = "[-1.5, 1.5]"},
    Setting{.key = "us",
            .type = SettingType::pulses,
            .absent = "`[1000, 2000]`",
            .most = 4000,
            .help = "With `channel`: two different pulses that belong to `value`; `[2000, "
                    "1000]` reverses the direction",
            .example = "[2000, 1000]"},
    Setting{.key = "not_available",
            .type = SettingType::integer,
            .absent = "none; with `from` in a J1939 message all ones",
            .help = "With `channel` or `from`: raw code for \"no value\". It is sent for an "
                    "absent channel or a stale value; received, it is no value",
            .example = "0xFF"},
    Setting{.key = "error",
            .type = SettingType::integer,
            .help = "With `channel`: raw code for \"error\". It is sent in failsafe; received, "
                    "it is no value",
            .example = "0xFE"},
    Setting{.key = "optional",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "With `channel`, of an input: `true`: a missing value is an absent channel; "
                    "`false`: it means failsafe",
            .example = "true"},
    Setting{.key = "negative",
            .type = SettingType::text,
            .help = "With `channel`: signal of the same message that says that the direction is "
                    "negative, for joysticks that send a magnitude",
            .example = "\"LeftStatus\""},
    Setting{.key = "positive",
            .type = SettingType::text,
            .help = "With `negative`: signal that says that the direction is positive",
            .example = "\"RightStatus\""},
    Setting{.key = "neutral",
            .type = SettingType::text,
            .help = "With `negative`: signal that says that the stick is centred",
            .example = "\"NeutralStatus\""},
    Setting{.key = "flag",
            .type = SettingType::choice,
            .choices = kDbcFlagChoices,
            .help = "The signal carries the state of the link: true in failsafe, for a "
                    "frame-lost frame or for a good one. `cause`: the number of the cause of a "
                    "loss, in 3 bits or more",
            .example = "\"failsafe\""},
    Setting{.key = "fixed",
            .type = SettingType::number,
            .help = "The signal is always sent with this value; received, another value means "
                    "failsafe",
            .example = "5"},
    Setting{.key = "counter",
            .type = SettingType::boolean,
            .help = "`true`: the signal counts the messages",
            .example = "true"},
    Setting{.key = "most",
            .type = SettingType::integer,
            .absent = "the most that the signal holds",
            .help = "With `counter`: highest count, 1 or more; the next one is 0",
            .example = "14"},
    Setting{.key = "checksum",
            .type = SettingType::choice,
            .choices = kDbcChecksumChoices,
            .help = "The signal is a checksum of the message",
            .example = "\"crc8_j1850\""},
    Setting{.key = "data_id",
            .type = SettingType::integer,
            .absent = "the data id in the DBC file",
            .least = 0,
            .most = 65535,
            .help = "With the checksums `p01` and `p05`: data id that the checksum covers",
            .example = "0x1234"},
    Setting{.key = "from",
            .type = SettingType::text,
            .help = "The signal carries this named value; outputs only",
            .example = "\"battery.voltage\""},
};

}  // namespace tribus
