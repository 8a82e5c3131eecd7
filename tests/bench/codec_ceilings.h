#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

/// What is counted, and the upper limit of its instructions. A ceiling is the figure that was
/// reached, rounded up. README.md shows it next to the bound that is the goal.
namespace tribus::bench {

inline constexpr std::size_t kGarbageBlock = 32;

/// The program that counts. All but the codecs are counted on x86 only.
enum class Counted : std::uint8_t { codecs, engine, link, authenticated };

struct Row {
    std::string_view name;
    std::string_view workload;
    double most_x86 = 0;
    double most_arm = 0;
    std::string_view pattern = "random";
    std::size_t bytes_a_unit = 1;  ///< 1 if the count is one of frames
    Counted counted = Counted::codecs;
    double most_calls = 0;  ///< system calls, of the link only
};

constexpr Row through_engine(std::string_view name, std::string_view workload, double most) {
    return {.name = name, .workload = workload, .most_x86 = most, .counted = Counted::engine};
}

/// From what arrived to what the output sends, at first without the engine: a frame, or a snapshot
/// of native CAN (five frames) or of DroneCAN RCInput (five frames too). SBUS asks at each pause
/// whether frames of 24 channels came. The CRC of DroneCAN is compiled apart from those who call
/// it, so it is not inlined: some 30 to 40 instructions of its rows.
/// An input keeps its latest loss, which costs frames that change the state of the link.
inline constexpr std::array kEngineRows{
    through_engine("CorePipeline18", "ibus18_to_sbus_core", 285),
    through_engine("CorePipeline14", "ibus14_to_sbus_core", 302),
    through_engine("Ibus18ToSbus", "ibus18_to_sbus", 1180),
    through_engine("Ibus14ToSbus", "ibus14_to_sbus", 1232),
    through_engine("Ibus18ToSbusThroughAMap", "ibus18_to_sbus_map", 1219),
    through_engine("Ibus14ToSbusThroughAMap", "ibus14_to_sbus_map", 1272),
    through_engine("SbusToIbus18", "sbus_to_ibus18", 1160),
    through_engine("NativeCanToSbus", "can_to_sbus", 4190),
    through_engine("Ibus18ToNativeCan", "ibus18_to_can", 2905),
    through_engine("DroneCanToSbus", "dronecan_to_sbus", 7480),
    through_engine("Ibus18ToDroneCan", "ibus18_to_dronecan", 3880),
};
/// A snapshot of a link with a key, on a processor without AES instructions, and a fifth of what a
/// challenge costs: the MAC and its check, and all that both ends do.
inline constexpr std::array kAuthenticatedRows{Row{.name = "MacAndCheck",
                                                   .workload = "mac",
                                                   .most_x86 = 3010,
                                                   .counted = Counted::authenticated},
                                               Row{.name = "AuthenticatedCanFd",
                                                   .workload = "can_fd",
                                                   .most_x86 = 4930,
                                                   .counted = Counted::authenticated},
                                               Row{.name = "BroadcastCanFd",
                                                   .workload = "can_fd_epoch",
                                                   .most_x86 = 5390,
                                                   .counted = Counted::authenticated}};
/// A snapshot of five frames through the link of a CAN interface. Some 300 instructions of a row
/// are those of the bus that stands in for the kernel. One system call looks whether the interface
/// still has the name that was configured.
inline constexpr std::array kLinkRows{
    Row{.name = "CanOutWithEcho",
        .workload = "out_with_echo",
        .most_x86 = 2525,
        .counted = Counted::link,
        .most_calls = 4},
    Row{.name = "CanOutWithoutEcho",
        .workload = "out_without_echo",
        .most_x86 = 1402,
        .counted = Counted::link,
        .most_calls = 6},
    Row{.name = "CanIn",
        .workload = "in",
        .most_x86 = 2015,
        .counted = Counted::link,
        .most_calls = 3},
};
/// CRSF keeps when a frame of type 16 came: its channels fill frames of type 17.
inline constexpr std::array kFrameRows{
    Row{"DecodeSbusInOneRead", "decode_sbus_read", 106, 122},
    Row{"DecodeIbusInOneRead", "decode_ibus_read", 145, 175},
    Row{"DecodeSbusByteByByte", "decode_sbus_bytes", 421, 577},
    Row{"DecodeIbusByteByByte", "decode_ibus_bytes", 572, 759},
    Row{"EncodeSbus", "encode_sbus", 80, 82},
    Row{"EncodeIbus", "encode_ibus", 65, 84},
    Row{"EncodeSbusWithAbsentChannels", "encode_sbus_absent", 110, 108},
    Row{"DecodeCrsfInOneRead", "decode_crsf_read", 138, 153},
    Row{"DecodeCrsfByteByByte", "decode_crsf_bytes", 1187, 1410},
    Row{"EncodeCrsf", "encode_crsf", 112, 117},
    Row{"DecodeGhstInOneRead", "decode_ghst_read", 136, 162},
    Row{"DecodeGhstByteByByte", "decode_ghst_bytes", 924, 1057},
    Row{"EncodeGhst", "encode_ghst", 107, 168},
    Row{"DecodeSrxlInOneRead", "decode_srxl_read", 198, 294},
    Row{"DecodeSrxlByteByByte", "decode_srxl_bytes", 956, 1240},
    Row{"EncodeSrxl", "encode_srxl", 242, 200},
    Row{"DecodeFport2InOneRead", "decode_fport2_read", 147, 150},
    Row{"DecodeFportInOneRead", "decode_fport_read", 168, 172},
    Row{"DecodeIbus2InOneRead", "decode_ibus2_read", 290, 338},
    Row{"DecodeDsmInOneRead", "decode_dsm_read", 140, 138},
    Row{"DecodeExBusInOneRead", "decode_exbus_read", 285, 344},
};

constexpr Row garbage(std::string_view name, std::string_view workload, std::string_view pattern,
                      double most_x86, double most_arm) {
    return {name, workload, most_x86, most_arm, pattern, kGarbageBlock};
}

/// "!!" is a byte that the line damaged.
inline constexpr std::array kGarbageRows{
    garbage("SbusRandom", "garbage_sbus_read", "random", 6, 7),
    garbage("SbusHeaders", "garbage_sbus_read", "0f", 16, 17),
    garbage("SbusHeadersAndFlags", "garbage_sbus_read", "0f0f00", 13, 14),
    garbage("SbusAlmostFrames", "garbage_sbus_read",
            "0f000000000000000000000000000000000000000000000001", 7, 8),
    garbage("SbusFramesThenRubbish", "garbage_sbus_read",
            "0f00000000000000000000000000000000000000000000000400"
            "0f00000000000000000000000000000000000000000000000403000003",
            31, 29),
    garbage("SbusHeadersDamaged", "garbage_sbus_read", "0f!!", 104, 109),
    garbage("SbusHeadersByteByByte", "garbage_sbus_bytes", "0f", 111, 115),
    garbage("SbusRandomByteByByte", "garbage_sbus_bytes", "random", 51, 63),
    garbage("IbusRandom", "garbage_ibus_read", "random", 13, 13),
    garbage("IbusLengths", "garbage_ibus_read", "20", 32, 32),
    garbage("IbusHeaders", "garbage_ibus_read", "2040", 109, 135),
    garbage("IbusHeadersOfTheOtherKind", "garbage_ibus_read", "550501", 17, 23),
    garbage("Ibus2Shortest", "garbage_ibus_read", "08", 77, 93),
    garbage("Ibus2Longest", "garbage_ibus_read", "0825", 84, 118),
    garbage("IbusAlmostFrames", "garbage_ibus_read",
            "2040dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc05dc050000", 18, 20),
    garbage("IbusHeadersDamaged", "garbage_ibus_read", "2040!!", 128, 122),
    garbage("IbusHeadersByteByByte", "garbage_ibus_bytes", "2040", 329, 347),
    garbage("IbusRandomByteByByte", "garbage_ibus_bytes", "random", 94, 104),
};

}  // namespace tribus::bench
