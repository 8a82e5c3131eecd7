#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "transports/codecs/dronecan/signature.h"
#include "transports/codecs/dronecan/types.h"

/// A signature is right only if the name, the fields, their types, their order and all nested types
/// are those of the DSDL file.
namespace tribus::dronecan::signature_test {
namespace {

struct TypeFact {
    std::uint16_t id;
    std::uint64_t signature;
};

/// Facts of docs/protocols/can.md, "DroneCAN: RCInput" to "DroneCAN: telemetry". Those of
/// GetTransportStats, LogMessage and KeyValue are from headers that dronecan_dsdlc generated, and
/// from the C# bindings of Mission Planner.
const std::map<std::string_view, TypeFact> kFacts = {
    {"dronecan.sensors.rc.RCInput", {1140, 0x771555E596AAB4CF}},
    {"uavcan.equipment.actuator.ArrayCommand", {1010, 0xD8A7486238EC3AF3}},
    {"uavcan.equipment.esc.RawCommand", {1030, 0x217F5C87D7EC951D}},
    {"uavcan.equipment.safety.ArmingStatus", {1100, 0x8700F375556A8003}},
    {"ardupilot.indication.SafetyState", {20000, 0xE965701A95A1A6A1}},
    {"ardupilot.indication.NotifyState", {20007, 0x631F2A9C1651FDEC}},
    {"uavcan.protocol.NodeStatus", {341, 0x0F0868D0C1A7C6F1}},
    {"uavcan.protocol.GetNodeInfo", {1, 0xEE468A8121C46A9E}},
    {"uavcan.protocol.dynamic_node_id.Allocation", {1, 0x0B2A812620A11D40}},
    {"uavcan.protocol.RestartNode", {5, 0x569E05394A3017F0}},
    {"uavcan.protocol.GetTransportStats", {4, 0xBE6F76A7EC312B04}},
    {"uavcan.protocol.param.GetSet", {11, 0xA7B622F939D1A4D5}},
    {"uavcan.protocol.param.ExecuteOpcode", {10, 0x3B131AC5EB69D2CD}},
    {"uavcan.protocol.debug.LogMessage", {16383, 0xD654A48E0C049D75}},
    {"uavcan.protocol.debug.KeyValue", {16370, 0xE02F25D6E0C98AE0}},
    {"uavcan.equipment.power.BatteryInfo", {1092, 0x249C26548A711966}},
    {"uavcan.equipment.power.CircuitStatus", {1091, 0x8313D33D0DDDA115}},
    {"ardupilot.equipment.power.BatteryCells", {20012, 0x5C8B1ABD15890EA4}},
    {"ardupilot.equipment.power.BatteryInfoAux", {20004, 0x7D7F49FC75484882}},
    {"uavcan.equipment.esc.Status", {1034, 0xA9AF28AEA2FBB254}},
    {"uavcan.equipment.esc.StatusExtended", {1036, 0x02DC203C50960EDC}},
    {"uavcan.equipment.device.Temperature", {1110, 0x70261C28A94144C6}},
    {"uavcan.equipment.air_data.StaticPressure", {1028, 0xCDC7C43412BDC89A}},
    {"uavcan.equipment.air_data.StaticTemperature", {1029, 0x49272A6477D96271}},
    {"uavcan.equipment.ice.FuelTankStatus", {1129, 0x286B4A387BA84BC4}},
    {"dronecan.sensors.rpm.RPM", {1045, 0x140707C09274F6E7}},
    {"uavcan.equipment.gnss.Fix2", {1063, 0xCA41E7000F37435F}},
};

class DefinitionText {
  public:
    void add(std::string_view text) { text_ += text; }
    const std::string& text() const { return text_; }

  private:
    std::string text_;
};

template <class T>
std::string definition() {
    DefinitionText text;
    DefinitionWriter(text).template type<T>();
    return text.text();
}

TEST(DroneCanSignature, TheHashIsCrc64We) {
    SignatureHash hash;
    hash.add("123456789");
    EXPECT_EQ(hash.value(), 0x62EC59E3F1A4F00AU);  // the check value of the specification
}

TEST(DroneCanSignature, WhatIsDescribedIsEveryTypeAsItIsKnown) {
    std::size_t types = 0;
    for_each_type([&]<class T>() {
        ++types;
        const auto fact = kFacts.find(T::kName);
        ASSERT_NE(fact, kFacts.end()) << T::kName;
        EXPECT_EQ(T::kId, fact->second.id) << T::kName;
        EXPECT_EQ(T::kSignature, fact->second.signature) << T::kName;
        EXPECT_EQ(computed_signature<T>(), fact->second.signature) << definition<T>();
    });
    EXPECT_EQ(types, kFacts.size());
}

TEST(DroneCanSignature, ItIsKnownAtCompileTime) {
    static_assert(computed_signature<NodeStatus>() == NodeStatus::kSignature);
    static_assert(computed_signature<ParamGetSet>() == ParamGetSet::kSignature);
}

TEST(DroneCanSignature, AMessageIsItsNameAndItsFields) {
    EXPECT_EQ(definition<FuelTankStatus>(),
              "uavcan.equipment.ice.FuelTankStatus\n"
              "void9\n"
              "saturated uint7 available_fuel_volume_percent\n"
              "saturated float32 available_fuel_volume_cm3\n"
              "saturated float32 fuel_consumption_rate_cm3pm\n"
              "saturated float16 fuel_temperature\n"
              "saturated uint8 fuel_tank_id");
    EXPECT_EQ(definition<Timestamp>(), "uavcan.Timestamp\ntruncated uint56 usec");
}

TEST(DroneCanSignature, AServiceHasALineBetweenItsRequestAndItsResponse) {
    EXPECT_EQ(definition<ParamExecuteOpcode>(),
              "uavcan.protocol.param.ExecuteOpcode\n"
              "saturated uint8 opcode\n"
              "saturated int48 argument\n"
              "---\n"
              "saturated int48 argument\n"
              "saturated bool ok");
    EXPECT_EQ(definition<GetNodeInfo>(),
              "uavcan.protocol.GetNodeInfo\n"
              "---\n"
              "uavcan.protocol.NodeStatus status\n"
              "uavcan.protocol.SoftwareVersion software_version\n"
              "uavcan.protocol.HardwareVersion hardware_version\n"
              "saturated uint8[<=80] name");
}

TEST(DroneCanSignature, AUnionSaysSo) {
    EXPECT_EQ(definition<ParamNumericValue>(),
              "uavcan.protocol.param.NumericValue\n"
              "@union\n"
              "uavcan.protocol.param.Empty empty\n"
              "saturated int64 integer_value\n"
              "saturated float32 real_value");
}

TEST(DroneCanSignature, ArraysOfFixedSizeAndOfAnySizeDiffer) {
    EXPECT_EQ(definition<HardwareVersion>(),
              "uavcan.protocol.HardwareVersion\n"
              "saturated uint8 major\n"
              "saturated uint8 minor\n"
              "saturated uint8[16] unique_id\n"
              "saturated uint8[<=255] certificate_of_authenticity");
}

}  // namespace
}  // namespace tribus::dronecan::signature_test
