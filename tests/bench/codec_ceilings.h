#pragma once

#include <array>
#include <cstddef>
#include <string_view>

/// What is counted, and the upper limit of its instructions. A ceiling is the figure that was
/// reached, rounded up. README.md shows it next to the bound that is the goal.
namespace tribus::bench {

inline constexpr std::size_t kGarbageBlock = 32;

struct Row {
    std::string_view name;
    std::string_view workload;
    double most_x86 = 0;
    double most_arm = 0;
    std::string_view pattern = "random";
    std::size_t bytes_a_unit = 1;  ///< 1 if the count is one of frames
    bool engine = false;           ///< of count_engine, counted on x86 only
};

/// From the bytes of a frame to those of the frame that the output sends.
inline constexpr std::array kEngineRows{
    Row{.name = "Ibus18ToSbus", .workload = "ibus_18", .most_x86 = 1180, .engine = true},
    Row{.name = "Ibus14ToSbus", .workload = "ibus_14", .most_x86 = 1250, .engine = true},
    Row{.name = "Ibus18ToSbusThroughAMap",
        .workload = "ibus_18_map",
        .most_x86 = 1340,
        .engine = true},
    Row{.name = "Ibus14ToSbusThroughAMap",
        .workload = "ibus_14_map",
        .most_x86 = 1480,
        .engine = true},
    Row{.name = "SbusToIbus18", .workload = "sbus_to_ibus_18", .most_x86 = 1150, .engine = true},
};
/// User instructions a frame of all threads of `tribus run`, 18 channels of i.Bus through a map to
/// SBUS. The number of wake-ups differs a little from run to run, so this has some room.
inline constexpr double kMostOfDaemon = 2600;

inline constexpr std::array kFrameRows{
    Row{"DecodeSbusInOneRead", "decode_sbus_read", 106, 122},
    Row{"DecodeIbusInOneRead", "decode_ibus_read", 148, 179},
    Row{"DecodeSbusByteByByte", "decode_sbus_bytes", 430, 582},
    Row{"DecodeIbusByteByByte", "decode_ibus_bytes", 600, 765},
    Row{"EncodeSbus", "encode_sbus", 80, 82},
    Row{"EncodeIbus", "encode_ibus", 65, 84},
    Row{"EncodeSbusWithAbsentChannels", "encode_sbus_absent", 119, 117},
};

constexpr Row garbage(std::string_view name, std::string_view workload, std::string_view pattern,
                      double most_x86, double most_arm) {
    return {name, workload, most_x86, most_arm, pattern, kGarbageBlock};
}

/// "!!" is a byte that the line damaged.
inline constexpr std::array kGarbageRows{
    garbage("SbusRandom", "garbage_sbus_read", "random", 6, 7),
    garbage("SbusHeaders", "garbage_sbus_read", "0f", 17, 18),
    garbage("SbusHeadersAndFlags", "garbage_sbus_read", "0f0f00", 13, 14),
    garbage("SbusAlmostFrames", "garbage_sbus_read",
            "0f000000000000000000000000000000000000000000000001", 7, 8),
    garbage("SbusFramesThenRubbish", "garbage_sbus_read",
            "0f00000000000000000000000000000000000000000000000400"
            "0f00000000000000000000000000000000000000000000000403000003",
            31, 29),
    garbage("SbusHeadersDamaged", "garbage_sbus_read", "0f!!", 105, 110),
    garbage("SbusHeadersByteByByte", "garbage_sbus_bytes", "0f", 111, 115),
    garbage("SbusRandomByteByByte", "garbage_sbus_bytes", "random", 51, 63),
    garbage("IbusRandom", "garbage_ibus_read", "random", 14, 15),
    garbage("IbusLengths", "garbage_ibus_read", "20", 33, 32),
    garbage("IbusHeaders", "garbage_ibus_read", "2040", 115, 141),
    garbage("IbusHeadersOfTheOtherKind", "garbage_ibus_read", "550501", 18, 24),
    garbage("Ibus2Shortest", "garbage_ibus_read", "08", 83, 100),
    garbage("Ibus2Longest", "garbage_ibus_read", "0825", 86, 121),
    garbage("IbusAlmostFrames", "garbage_ibus_read",
            "2040dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc050000", 19, 21),
    garbage("IbusHeadersDamaged", "garbage_ibus_read", "2040!!", 133, 125),
    garbage("IbusHeadersByteByByte", "garbage_ibus_bytes", "2040", 343, 358),
    garbage("IbusRandomByteByByte", "garbage_ibus_bytes", "random", 103, 104),
};

}  // namespace tribus::bench
