#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "transports/codecs/dbc/map.h"

/// A DBC file with a message of each kind, and maps of its signals.
namespace tribus::map_bus {

using Lines = std::vector<std::string>;

inline const std::string kBus = R"(
BO_ 304 Command: 8 A
 SG_ Mode : 0|8@1+ (1,0) [0|0] "" B
 SG_ Speed : 16|8@1- (1,0) [-100|100] "%" B
 SG_ Pulse : 24|12@1+ (1,0) [0|0] "us" B
 SG_ Short : 24|8@1+ (1,0) [0|0] "us" B
 SG_ Plain : 36|4@1+ (1,0) [0|0] "" B
 SG_ Magnitude : 40|8@1+ (1,0) [0|100] "%" B
 SG_ Minus : 48|2@1+ (1,0) [0|0] "" B
 SG_ Count : 50|6@1+ (1,0) [0|0] "" B
 SG_ Check : 56|8@1+ (1,0) [0|0] "" B
BO_ 305 Paged: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" B
 SG_ First m0 : 8|8@1+ (1,0) [0|100] "" B
 SG_ Second m1 : 8|8@1+ (1,0) [0|100] "" B
 SG_ SecondSign m1 : 16|1@1+ (1,0) [0|0] "" B
 SG_ SecondCheck m1 : 24|8@1+ (1,0) [0|0] "" B
BO_ 306 Wide: 8 A
 SG_ Intel16 : 0|16@1+ (1,0) [0|0] "" B
 SG_ Motorola16 : 7|16@0+ (1,0) [0|0] "" B
 SG_ Byte0 : 0|8@1+ (1,0) [0|0] "" B
 SG_ Value : 16|8@1+ (1,0) [0|100] "" B
 SG_ Float : 32|32@1- (1,0) [0|0] "" B
BO_ 2365512958 Joystick: 8 A
 SG_ X : 0|8@1+ (1,0) [0|100] "" B
BO_ 2365512755 OneJoystick: 8 A
 SG_ X1 : 0|8@1+ (1,0) [0|100] "" B
BO_ 2566852608 Long: 20 A
 SG_ L : 0|8@1+ (1,0) [0|100] "" B
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_ "GenMsgCycleTime" BO_ 304 20;
BA_ "GenMsgCycleTime" BO_ 305 50;
SIG_VALTYPE_ 306 Float : 1;
)" + test::j1939_frames({2365512958, 2365512755, 2566852608});

inline Lines mistakes_of_signals(std::string_view dbc, std::string_view signals,
                                 SettingScope scope = SettingScope::output,
                                 std::string_view cycles = {}) {
    const auto map = build_dbc_map(test::dbc_settings(dbc, signals, cycles), scope);
    return map ? Lines{} : test::told(map.error());
}

inline Lines mistakes(std::string_view signals, SettingScope scope = SettingScope::output,
                      std::string_view cycles = {}) {
    return mistakes_of_signals(kBus, signals, scope, cycles);
}

inline DbcMap map_of(std::string_view signals, SettingScope scope = SettingScope::output,
                     std::string_view cycles = {}) {
    return test::dbc_map(test::dbc_settings(kBus, signals, cycles), scope);
}

inline const DbcChannel& only_channel(const DbcMap& map) {
    return map.parts.at(0).channels.at(0);
}

}  // namespace tribus::map_bus
