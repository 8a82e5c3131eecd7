#include <cmath>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dronecan/known_payloads.h"

/// Payloads of known origin. Those without a named origin are from dronecan_vectors.json, on which
/// three implementations agree.
namespace tribus::dronecan::known_payloads_test {
namespace {

using test::from_hex;

std::string as_text(const FieldValue& value) {
    const std::string number = std::visit(
        []<class Value>(const Value& held) -> std::string {
            if constexpr (std::is_same_v<Value, bool>) {
                return held ? "true" : "false";
            } else if constexpr (std::is_same_v<Value, std::string_view>) {
                return "'" + std::string(held) + "'";
            } else if constexpr (std::is_same_v<Value, std::span<const std::uint8_t>>) {
                return std::to_string(held.size()) + " bytes";
            } else if constexpr (std::is_same_v<Value, NoItems>) {
                return "none";
            } else {
                return std::to_string(held);
            }
        },
        value.value);
    return std::string(value.path) + "=" + number + std::string(value.unit);
}

using Lines = std::vector<std::string>;

Lines lines(TransferKind kind, std::uint16_t id, std::string_view payload, bool fd = false) {
    const KnownPayload* known = find_known_payload(kind, id);
    if (known == nullptr) {
        return {"unknown"};
    }
    Lines found;
    const bool fits = known->visit(
        from_hex(payload), fd, [&](const FieldValue& value) { found.push_back(as_text(value)); });
    if (!fits) {
        found.emplace_back("refused");
    }
    return found;
}

TEST(DroneCanKnownPayloads, NestedStructsTextsAndBytesHaveTheirPaths) {
    EXPECT_EQ(
        lines(TransferKind::response, 1,
              "4D000000000000010201EFBEADDE0000000000000000010000112233445566778899AABBCCDDEE"
              "FF006F72672E6578616D706C652E72636777"),
        (Lines{"status.uptime_sec=77s", "status.health=0", "status.mode=0", "status.sub_mode=0",
               "status.vendor_specific_status_code=0", "software_version.major=1",
               "software_version.minor=2", "software_version.optional_field_flags=1",
               "software_version.vcs_commit=3735928559", "software_version.image_crc=0",
               "hardware_version.major=1", "hardware_version.minor=0",
               "hardware_version.unique_id=16 bytes",
               "hardware_version.certificate_of_authenticity=0 bytes", "name='org.example.rcgw'"}));
}

TEST(DroneCanKnownPayloads, ItemsOfArraysAreNumbered) {
    EXPECT_EQ(lines(TransferKind::message, 1010, "01000000 020000BC"),
              (Lines{"commands[0].actuator_id=1", "commands[0].command_type=0",
                     "commands[0].command_value=0.000000", "commands[1].actuator_id=2",
                     "commands[1].command_type=0", "commands[1].command_value=-1.000000"}));
    EXPECT_EQ(lines(TransferKind::message, 1030, "0003FDF0080010"),
              (Lines{"cmd[0]=0", "cmd[1]=8191", "cmd[2]=-8192", "cmd[3]=4096"}));
}

TEST(DroneCanKnownPayloads, AnArrayWithoutItemsIsThereAllTheSame) {
    EXPECT_EQ(lines(TransferKind::message, 1010, ""), Lines{"commands=none"});
}

TEST(DroneCanKnownPayloads, HaveWhatAUnionHolds) {
    EXPECT_EQ(lines(TransferKind::request, 11, "0001320000000000000052435F52415445"),
              (Lines{"index=0", "value.integer_value=50", "name='RC_RATE'"}));
    EXPECT_EQ(lines(TransferKind::request, 11, "0000"),
              (Lines{"index=0", "value.empty=true", "name=''"}));
}

TEST(DroneCanKnownPayloads, UnknownMeasurementsAreNoNumbersAndUnitsAreGiven) {
    bool unknown = false;
    const KnownPayload* temperature = find_known_payload(TransferKind::message, 1110);
    ASSERT_NE(temperature, nullptr);
    EXPECT_TRUE(temperature->visit(from_hex("0700FF7F00"), false, [&](const FieldValue& value) {
        if (value.path == "temperature") {
            unknown = std::isnan(std::get<double>(value.value));
            EXPECT_EQ(value.unit, "K");
        }
    }));
    EXPECT_TRUE(unknown);
}

TEST(DroneCanKnownPayloads, WhatCannotBeTheTypeIsRefused) {
    EXPECT_EQ(lines(TransferKind::message, 341, "0000000000"), Lines{"refused"});
}

TEST(DroneCanKnownPayloads, MessagesAndServicesOfTheSameIdAreDifferentAndOthersUnknown) {
    EXPECT_EQ(find_known_payload(TransferKind::message, 1)->type.name,
              "uavcan.protocol.dynamic_node_id.Allocation");
    EXPECT_EQ(find_known_payload(TransferKind::request, 1)->type.name,
              "uavcan.protocol.GetNodeInfo");
    EXPECT_EQ(find_known_payload(TransferKind::message, 2), nullptr);
    EXPECT_EQ(find_known_payload(TransferKind::request, 1140), nullptr);
}

TEST(DroneCanKnownPayloads, EveryKindAndIdIsOnlyOnceInTheList) {
    std::set<std::pair<TransferKind, std::uint16_t>> seen;
    for (const KnownPayload& one : known_payloads()) {
        EXPECT_TRUE(seen.emplace(one.type.kind, one.type.id).second) << one.type.name;
    }
    EXPECT_EQ(seen.size(), 32U);  // 22 messages, 5 services
}

}  // namespace
}  // namespace tribus::dronecan::known_payloads_test
