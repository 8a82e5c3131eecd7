#pragma once

#include <array>
#include <cstddef>
#include <string_view>

/// What is counted, and how many instructions it may take at most. A ceiling is the figure that was
/// reached, rounded up; README.md has it beside the bound that is the goal.
namespace tribus::bench {

inline constexpr std::size_t kGarbageBlock = 32;

struct Row {
    std::string_view name;
    std::string_view workload;
    double most_x86 = 0;
    double most_arm = 0;
    std::string_view pattern = "random";
    std::size_t bytes_a_unit = 1;  ///< 1 where the count is one of frames
};

inline constexpr std::array kFrameRows{
    Row{"DecodeSbusInOneRead", "decode_sbus_read", 111, 123},
    Row{"DecodeIbusInOneRead", "decode_ibus_read", 148, 183},
    Row{"DecodeSbusByteByByte", "decode_sbus_bytes", 443, 585},
    Row{"DecodeIbusByteByByte", "decode_ibus_bytes", 600, 781},
    Row{"EncodeSbus", "encode_sbus", 80, 82},
    Row{"EncodeIbus", "encode_ibus", 65, 84},
};

constexpr Row garbage(std::string_view name, std::string_view workload, std::string_view pattern,
                      double most_x86, double most_arm) {
    return {name, workload, most_x86, most_arm, pattern, kGarbageBlock};
}

/// "!!" is a byte that the line damaged.
inline constexpr std::array kGarbageRows{
    garbage("SbusRandom", "garbage_sbus_read", "random", 19, 15),
    garbage("SbusHeaders", "garbage_sbus_read", "0f", 95, 82),
    garbage("SbusHeadersAndFlags", "garbage_sbus_read", "0f0f00", 80, 69),
    garbage("SbusAlmostFrames", "garbage_sbus_read",
            "0f000000000000000000000000000000000000000000000001", 25, 25),
    garbage("SbusFramesThenRubbish", "garbage_sbus_read",
            "0f00000000000000000000000000000000000000000000000400"
            "0f00000000000000000000000000000000000000000000000403000003",
            31, 29),
    garbage("SbusHeadersDamaged", "garbage_sbus_read", "0f!!", 260, 242),
    garbage("SbusHeadersByteByByte", "garbage_sbus_bytes", "0f", 291, 270),
    garbage("SbusRandomByteByByte", "garbage_sbus_bytes", "random", 69, 78),
    garbage("IbusRandom", "garbage_ibus_read", "random", 48, 45),
    garbage("IbusLengths", "garbage_ibus_read", "20", 109, 99),
    garbage("IbusHeaders", "garbage_ibus_read", "2040", 224, 218),
    garbage("IbusHeadersOfTheOtherKind", "garbage_ibus_read", "550501", 59, 54),
    garbage("Ibus2Shortest", "garbage_ibus_read", "08", 155, 148),
    garbage("Ibus2Longest", "garbage_ibus_read", "0825", 148, 167),
    garbage("IbusAlmostFrames", "garbage_ibus_read",
            "2040dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc050000", 47, 48),
    garbage("IbusHeadersDamaged", "garbage_ibus_read", "2040!!", 235, 215),
    garbage("IbusHeadersByteByByte", "garbage_ibus_bytes", "2040", 461, 443),
    garbage("IbusRandomByteByByte", "garbage_ibus_bytes", "random", 112, 111),
};

}  // namespace tribus::bench
