#include "tests/captures/receivers.h"

#include <array>

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

/// One idle bit between two bytes: 11 bits at 115200 baud.
constexpr auto kIbusByteDistance = 95'500ns;
/// 12 bits at 100000 baud.
constexpr auto kSbusByteDistance = 120us;

/// FlySky AFHDS3 surface receiver, LANE's recording. The steering goes to one end, to the other one
/// and back, then the throttle does; channel 3 is switched once. Channel 4 does not move.
Receiver afhds3_surface() {
    const Course steering{1, {{11, 1500},  {12, 1507},  {24, 1652},  {35, 1745},  {45, 1928},
                              {51, 1994},  {55, 2000},  {180, 1996}, {187, 1920}, {199, 1727},
                              {214, 1619}, {224, 1505}, {238, 1500}, {245, 1468}, {303, 1000},
                              {377, 1002}, {400, 1131}, {416, 1344}, {431, 1424}, {440, 1500}}};
    const Course throttle{2,
                          {{526, 1500},
                           {534, 1594},
                           {546, 1817},
                           {561, 1990},
                           {586, 2000},
                           {674, 1996},
                           {683, 1912},
                           {694, 1750},
                           {710, 1630},
                           {719, 1500},
                           {743, 1499},
                           {756, 1294},
                           {772, 1138},
                           {781, 1000},
                           {850, 1007},
                           {855, 1085},
                           {858, 1159},
                           {866, 1415},
                           {870, 1500}}};
    const Course switched{3, {{1100, 2000}, {1101, 1500}}};
    std::vector<int> channels(18, 1500);
    channels[3] = 1000;
    return {.name = "ibus_servo18_afhds3",
            .endings = {".timed.txt", ".channels.csv"},
            .byte_distance = kIbusByteDistance,
            .rhythm = {.first = 1146us,
                       .period = 4'000'806ns,
                       .early = 4us,
                       .late = 4us,
                       .one_in = 25,
                       .periods = 1231},
            .wire = ServoFrames{.channels = channels,
                                .moves = {steering, throttle, switched},
                                .cut_first_bytes = 2,
                                .torn_byte = {},
                                .cut_first_at = 13us}};
}

/// FlySky FS-iA6B, povlhp's recordings, with the sticks at rest. Its sensor bus has the same clock.
ServoFrames ia6b_at_rest() {
    ServoFrames wire;
    wire.channels = {1498, 1501, 1018, 1501, 1000, 1000, 1500,
                     2000, 1500, 1500, 1500, 1500, 1500, 1500};
    return wire;
}

constexpr Rhythm ia6b(std::chrono::nanoseconds first, std::size_t periods) {
    return {.first = first,
            .period = 7'700'790ns,
            .early = 1us,
            .late = 2us,
            .one_in = 20,
            .periods = periods};
}

Receiver ia6b_beside_two_sensors() {
    ServoFrames wire = ia6b_at_rest();
    wire.cut_first_bytes = 11;
    wire.torn_byte = 0xAF;
    wire.cut_first_at = 6us;
    return {.name = "ibus_servo14_ia6b_2sensors",
            .endings = {".timed.txt"},
            .byte_distance = kIbusByteDistance,
            .rhythm = ia6b(5743us, 651),
            .wire = wire};
}

Receiver ia6b_beside_one_sensor() {
    return {.name = "ibus_servo14_ia6b_rpmsensor",
            .endings = {".timed.txt"},
            .byte_distance = kIbusByteDistance,
            .rhythm = ia6b(4101us, 718),
            .wire = ia6b_at_rest()};
}

/// A speed sensor that stands still and a voltage sensor whose input is open: -0.01 V.
Receiver two_sensors() {
    return {.name = "ibus_sensor_ia6b_2sensors",
            .endings = {".timed.txt", ".saleae.csv"},
            .byte_distance = kIbusByteDistance,
            .rhythm = ia6b(1892us, 652),
            .wire = SensorExchanges{.sensors = {{1, {{0, 0}}}, {2, {{0, 0xFFFF}}}},
                                    .first_probe = 47,
                                    .missed = {1, 59, 158, 265, 290, 364, 455, 529},
                                    .answer_least = 997us,
                                    .answer_most = 1016us}};
}

Receiver one_sensor() {
    return {.name = "ibus_sensor_ia6b_rpmsensor",
            .endings = {".timed.txt"},
            .byte_distance = kIbusByteDistance,
            .rhythm = ia6b(250us, 719),
            .wire = SensorExchanges{.sensors = {{1, {{0, 0}}}},
                                    .first_probe = 34,
                                    .missed = {147, 155, 180, 312, 353, 411, 477},
                                    .answer_least = 997us,
                                    .answer_most = 1011us,
                                    .cut_last_bytes = 2}};
}

/// The wire between the two sensors: the first one keeps its answers to itself. The open input
/// gives -0.01 to -0.03 V.
Receiver between_two_sensors() {
    return {.name = "ibus_sensor_ia6b_tap_between",
            .endings = {".timed.txt"},
            .byte_distance = kIbusByteDistance,
            .rhythm = ia6b(5162us, 651),
            .wire = SensorExchanges{.sensors = {{1, {}},
                                                {2,
                                                 {{0, 0xFFFE},
                                                  {8, 0xFFFF},
                                                  {75, 0xFFFD},
                                                  {143, 0xFFFF},
                                                  {413, 0xFFFE},
                                                  {482, 0xFFFF}}}},
                                    .first_sensor = 1,
                                    .first_probe = 39,
                                    .missed = {323, 455, 589, 645},
                                    .answer_least = 1004us,
                                    .answer_most = 1017us}};
}

/// Futaba R7008SB in FASSTest 14CH with SBUS2, PX4's recording, with the sticks at rest.
Receiver r7008sb() {
    return {
        .name = "sbus2_r7008SB",
        .endings = {".timed.txt", ".saleae.csv"},
        .byte_distance = kSbusByteDistance,
        .rhythm = {.period = 15'000'976ns, .early = 7us, .late = 11us, .one_in = 2, .periods = 85},
        .wire = Sbus2Frames{.raw = {1041, 1024, 1696, 1024, 352, 1696, 1024, 1024, 1024, 1024, 1024,
                                    1024, 1024, 1024, 1024, 1024},
                            .footers = {0x04, 0x14, 0x24, 0x34},
                            .slot_after = 5030us,
                            .slots = {{0x03, 0xC4, 0x00}, {0x03, 0xC0, 0x2E}}},
    };
}

}  // namespace

std::span<const Receiver> receivers() {
    static const std::array<Receiver, 7> kReceivers{afhds3_surface(),
                                                    ia6b_beside_two_sensors(),
                                                    ia6b_beside_one_sensor(),
                                                    two_sensors(),
                                                    one_sensor(),
                                                    between_two_sensors(),
                                                    r7008sb()};
    return kReceivers;
}

}  // namespace tribus::test
