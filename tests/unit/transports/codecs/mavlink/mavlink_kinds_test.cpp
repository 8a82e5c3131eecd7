#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/wire.h"

namespace tribus::test::mavlink_kinds_test {
namespace {

struct Field {
    std::string_view type;
    std::string_view name;
    std::uint8_t items = 0;  ///< of an array
};

/// A message as MAVLink's XML files describe it, its fields in the order of the wire: the longest
/// types first. Extension fields do not count.
struct Described {
    std::uint32_t id = 0;
    std::string_view name;
    std::vector<Field> fields;
};

std::vector<Field> words(std::size_t count, std::vector<Field> before, std::vector<Field> after) {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (int channel = 1; channel <= 18; ++channel) {
            all.push_back("chan" + std::to_string(channel) + "_raw");
        }
        return all;
    }();
    for (std::size_t i = 0; i < count; ++i) {
        before.push_back({"uint16_t", names[i]});
    }
    before.insert(before.end(), after.begin(), after.end());
    return before;
}

const std::vector<Described> kDescribed{
    {0,
     "HEARTBEAT",
     {{"uint32_t", "custom_mode"},
      {"uint8_t", "type"},
      {"uint8_t", "autopilot"},
      {"uint8_t", "base_mode"},
      {"uint8_t", "system_status"},
      {"uint8_t", "mavlink_version"}}},
    {1,
     "SYS_STATUS",
     {{"uint32_t", "onboard_control_sensors_present"},
      {"uint32_t", "onboard_control_sensors_enabled"},
      {"uint32_t", "onboard_control_sensors_health"},
      {"uint16_t", "load"},
      {"uint16_t", "voltage_battery"},
      {"int16_t", "current_battery"},
      {"uint16_t", "drop_rate_comm"},
      {"uint16_t", "errors_comm"},
      {"uint16_t", "errors_count1"},
      {"uint16_t", "errors_count2"},
      {"uint16_t", "errors_count3"},
      {"uint16_t", "errors_count4"},
      {"int8_t", "battery_remaining"}}},
    {24,
     "GPS_RAW_INT",
     {{"uint64_t", "time_usec"},
      {"int32_t", "lat"},
      {"int32_t", "lon"},
      {"int32_t", "alt"},
      {"uint16_t", "eph"},
      {"uint16_t", "epv"},
      {"uint16_t", "vel"},
      {"uint16_t", "cog"},
      {"uint8_t", "fix_type"},
      {"uint8_t", "satellites_visible"}}},
    {30,
     "ATTITUDE",
     {{"uint32_t", "time_boot_ms"},
      {"float", "roll"},
      {"float", "pitch"},
      {"float", "yaw"},
      {"float", "rollspeed"},
      {"float", "pitchspeed"},
      {"float", "yawspeed"}}},
    {65, "RC_CHANNELS",
     words(18, {{"uint32_t", "time_boot_ms"}}, {{"uint8_t", "chancount"}, {"uint8_t", "rssi"}})},
    {69,
     "MANUAL_CONTROL",
     {{"int16_t", "x"},
      {"int16_t", "y"},
      {"int16_t", "z"},
      {"int16_t", "r"},
      {"uint16_t", "buttons"},
      {"uint8_t", "target"}}},
    {70, "RC_CHANNELS_OVERRIDE",
     words(8, {}, {{"uint8_t", "target_system"}, {"uint8_t", "target_component"}})},
    {74,
     "VFR_HUD",
     {{"float", "airspeed"},
      {"float", "groundspeed"},
      {"float", "alt"},
      {"float", "climb"},
      {"int16_t", "heading"},
      {"uint16_t", "throttle"}}},
    {109,
     "RADIO_STATUS",
     {{"uint16_t", "rxerrors"},
      {"uint16_t", "fixed"},
      {"uint8_t", "rssi"},
      {"uint8_t", "remrssi"},
      {"uint8_t", "txbuf"},
      {"uint8_t", "noise"},
      {"uint8_t", "remnoise"}}},
    {147,
     "BATTERY_STATUS",
     {{"int32_t", "current_consumed"},
      {"int32_t", "energy_consumed"},
      {"int16_t", "temperature"},
      {"uint16_t", "voltages", 10},
      {"int16_t", "current_battery"},
      {"uint8_t", "id"},
      {"uint8_t", "battery_function"},
      {"uint8_t", "type"},
      {"int8_t", "battery_remaining"}}},
    {420,
     "RADIO_RC_CHANNELS",
     {{"uint32_t", "time_last_update_ms"},
      {"uint16_t", "flags"},
      {"uint8_t", "target_system"},
      {"uint8_t", "target_component"},
      {"uint8_t", "count"}}},
};

std::size_t bytes_of(std::string_view type) {
    return type == "uint64_t"                                           ? 8
           : type == "uint32_t" || type == "int32_t" || type == "float" ? 4
           : type == "uint16_t" || type == "int16_t"                    ? 2
                                                                        : 1;
}

/// The rule of MAVLink's generator: the CRC of "NAME type name type name ..." with blanks, and of
/// the number of items behind an array, both of its bytes as XOR.
std::uint8_t crc_extra_of(const Described& message) {
    const auto add = [](Bytes& bytes, std::string_view text) {
        append(bytes, Bytes(text.begin(), text.end()));
        bytes.push_back(' ');
    };
    Bytes bytes;
    add(bytes, message.name);
    for (const Field& field : message.fields) {
        add(bytes, field.type);
        add(bytes, field.name);
        if (field.items != 0) {
            bytes.push_back(field.items);
        }
    }
    const std::uint16_t crc = plain_crc(bytes);
    return static_cast<std::uint8_t>((crc & 0xFFU) ^ crc >> 8U);
}

TEST(MavlinkKinds, HaveTheCrcExtraAndTheLengthOfTheirFields) {
    EXPECT_EQ(kDescribed.size(), mavlink_wire::kMessageKinds.size());
    for (const Described& message : kDescribed) {
        const mavlink_wire::MessageKind* kind = mavlink_wire::find_kind(message.id);
        ASSERT_NE(kind, nullptr) << message.name;
        EXPECT_EQ(int{kind->crc_extra}, int{crc_extra_of(message)}) << message.name;
        std::size_t length = 0;
        std::size_t before = 8;
        for (const Field& field : message.fields) {
            length += bytes_of(field.type) * std::max<std::size_t>(field.items, 1);
            EXPECT_LE(bytes_of(field.type), before) << message.name << ": " << field.name;
            before = bytes_of(field.type);
        }
        EXPECT_EQ(std::size_t{kind->length_1}, length) << message.name;
        EXPECT_GE(kind->length, kind->length_1);
        EXPECT_LE(kind->length, mavlink_wire::kMostPayload);
    }
}

}  // namespace
}  // namespace tribus::test::mavlink_kinds_test
