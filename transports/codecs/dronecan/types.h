#pragma once

#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/types_command.h"
#include "transports/codecs/dronecan/types_debug.h"
#include "transports/codecs/dronecan/types_gnss.h"
#include "transports/codecs/dronecan/types_node.h"
#include "transports/codecs/dronecan/types_param.h"
#include "transports/codecs/dronecan/types_power.h"
#include "transports/codecs/dronecan/types_sensor.h"

/// All data types that are known here.
namespace tribus::dronecan {

template <class... Types>
struct TypeList {};

/// Messages and services. A new type needs its struct and its line here.
using KnownTypes = TypeList<  //
    RcInput,                  //
    ArrayCommand,             //
    EscRawCommand,            //
    ArmingStatus,             //
    SafetyState,              //
    NotifyState,              //
    NodeStatus,               //
    GetNodeInfo,              //
    Allocation,               //
    RestartNode,              //
    GetTransportStats,        //
    ParamGetSet,              //
    ParamExecuteOpcode,       //
    LogMessage,               //
    KeyValue,                 //
    BatteryInfo,              //
    CircuitStatus,            //
    BatteryCells,             //
    BatteryInfoAux,           //
    EscStatus,                //
    EscStatusExtended,        //
    DeviceTemperature,        //
    StaticPressure,           //
    StaticTemperature,        //
    FuelTankStatus,           //
    Rpm,                      //
    GnssFix2>;

/// Calls `visit.operator()<T>()` for each message and each service.
template <class Visit>
constexpr void for_each_type(Visit&& visit) {
    [&]<class... Types>(TypeList<Types...>) {
        (visit.template operator()<Types>(), ...);
    }(KnownTypes{});
}

/// Calls `visit.operator()<T>()` for each message, request and response: for all types that read(),
/// write(), visit_values() and data_type_of() accept.
template <class Visit>
constexpr void for_each_payload_type(Visit&& visit) {
    for_each_type([&]<class T>() {
        if constexpr (ServiceType<T>) {
            visit.template operator()<typename T::Request>();
            visit.template operator()<typename T::Response>();
        } else {
            visit.template operator()<T>();
        }
    });
}

}  // namespace tribus::dronecan
