#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/support/streams.h"

/// Messages of MAVLink, made without the code of the program.
namespace tribus::test {

// Vectors of docs/protocols/mavlink.md, whose CRCs come from another program.
inline constexpr std::string_view kOverride =
    "fd22000000ffbe460000dc05dc05e803dc05e803e803d007dc0501014c04b00414057805dc054006a4060807c954";
inline constexpr std::string_view kOverride1 =
    "fe1200ffbe46dc05dc05e803dc05e803e803d007dc0501018e2b";
inline constexpr std::string_view kReleaseAll =
    "fd26000000ffbe46000000000000000000000000000000000000 0101"
    "fefffefffefffefffefffefffefffefffefffeff2b3d";
inline constexpr std::string_view kManual = "fd0b000000ffbe450000e80318fcf40100000300016a61";
inline constexpr std::string_view kHeartbeatOfAStation =
    "fd09000000ffbe0000000000000006080004033d48";
inline constexpr std::string_view kRadioFailsafe =
    "fd130000003344a4010040e2010001000100100000000080f30000800c6aa5";
inline constexpr std::string_view kRadioGood =
    "fd130000003344a4010040e2010000000100100000000080f30000800c7a2b";
inline constexpr std::string_view kRcChannelsOfAnAutopilot =
    "fd2a0000000101410000e8030000dc05dc05e803dc05e803e803d007dc054c04b00414057805dc054006a4060807"
    "ffffffff10fe6bd4";
inline const std::vector<double> kEightPulses{1500, 1500, 1000, 1500, 1000, 1000, 2000, 1500};
inline const std::vector<double> kSixteenPulses{1500, 1500, 1000, 1500, 1000, 1000, 2000, 1500,
                                                1100, 1200, 1300, 1400, 1500, 1600, 1700, 1800};

/// CRC-16/MCRF4XX, a bit at a time.
inline std::uint16_t plain_crc(const Bytes& bytes) {
    unsigned crc = 0xFFFF;
    for (const std::uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc & 1U) != 0 ? crc >> 1U ^ 0x8408U : crc >> 1U;
        }
    }
    return static_cast<std::uint16_t>(crc);
}

struct MessageHead {
    std::uint8_t system = 1;
    std::uint8_t component = 1;
    std::uint8_t flags = 0;  ///< with bit 0 a signature of zeros follows
};

/// A frame of version 2.
inline Bytes message_2(std::uint32_t id, std::uint8_t crc_extra, const Bytes& payload,
                       const MessageHead& head = {}) {
    Bytes covered{static_cast<std::uint8_t>(payload.size()),
                  head.flags,
                  0,
                  0,
                  head.system,
                  head.component,
                  static_cast<std::uint8_t>(id),
                  static_cast<std::uint8_t>(id >> 8U),
                  static_cast<std::uint8_t>(id >> 16U)};
    append(covered, payload);
    Bytes frame{0xFD};
    append(frame, covered);
    covered.push_back(crc_extra);
    const std::uint16_t crc = plain_crc(covered);
    frame.push_back(static_cast<std::uint8_t>(crc));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
    if ((head.flags & 1U) != 0) {
        frame.resize(frame.size() + 13);
    }
    return frame;
}

/// HEARTBEAT of a copter with ArduPilot, or of another MAV_TYPE and MAV_AUTOPILOT.
inline Bytes heartbeat_message(const MessageHead& head = {}, std::uint8_t vehicle = 2,
                               std::uint8_t autopilot = 3) {
    Bytes payload = from_hex("00000000 02 03 51 04 03");
    payload[4] = vehicle;
    payload[5] = autopilot;
    return message_2(0, 50, payload, head);
}

/// RC_CHANNELS of an autopilot with these pulses, in whole microseconds.
inline Bytes rc_channels_message(const std::vector<double>& pulses, const MessageHead& head = {}) {
    Bytes payload(42);
    for (std::size_t i = 0; i < pulses.size(); ++i) {
        const auto word = static_cast<unsigned>(pulses[i]);
        payload[4 + 2 * i] = static_cast<std::uint8_t>(word);
        payload[5 + 2 * i] = static_cast<std::uint8_t>(word >> 8U);
    }
    payload[40] = static_cast<std::uint8_t>(pulses.size());
    payload[41] = 255;
    return message_2(65, 118, payload, head);
}

}  // namespace tribus::test
