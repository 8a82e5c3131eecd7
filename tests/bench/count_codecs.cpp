#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "transports/codecs/codec.h"
#include "transports/codecs/crsf/crsf.h"
#include "transports/codecs/dsm/dsm.h"
#include "transports/codecs/exbus/exbus.h"
#include "transports/codecs/exbus/wire.h"
#include "transports/codecs/fport/fport.h"
#include "transports/codecs/ghst/ghst.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/ibus2/ibus2.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/srxl/srxl.h"

/// count_codecs WORKLOAD UNITS PREPARED [PATTERN]
///
/// Works through UNITS units. PREPARED units are made before, so the difference between two runs
/// with other UNITS is only the work. Prints nothing, because printing would be counted. A unit is
/// a frame, or kGarbageBlock bytes of garbage. PATTERN is repeated hexadecimal digits ("2040"),
/// with "!!" for a byte that the line damaged, or "random".
namespace tribus {
namespace {

constexpr std::size_t kGarbageBlock = 32;
/// Largest number of bytes that the engine reads at once.
constexpr std::size_t kLargestRead = 256;
constexpr std::size_t kIbusLength = 32;
constexpr std::size_t kIbusBody = 30;

struct Work {
    std::string_view workload;
    std::size_t units = 0;
    std::size_t prepared = 0;
    std::string_view pattern;

    bool about(std::string_view word) const { return workload.find(word) != workload.npos; }
};

/// Receives the results, so that the compiler cannot leave out the computation.
volatile std::uint64_t sink = 0;

class Random {
  public:
    std::uint32_t operator()() {
        state_ = state_ * 1664525U + 1013904223U;
        return state_ >> 8U;
    }

  private:
    std::uint32_t state_ = 1;
};

std::vector<std::uint8_t> sbus_frames(std::size_t count) {
    Random random;
    std::vector<std::uint8_t> bytes(count * kSbusFrameLength);
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        bytes[at] = static_cast<std::uint8_t>(random());
        switch (at % kSbusFrameLength) {
            case 0:
                bytes[at] = 0x0F;
                break;
            case kSbusFrameLength - 2:
                bytes[at] &= 0x03U;
                break;
            case kSbusFrameLength - 1:
                bytes[at] = 0x00;
                break;
            default:
                break;
        }
    }
    return bytes;
}

/// 18 channels, none absent: a high nibble in every third slot gives channels 15 to 18 at least 988
/// us.
std::vector<std::uint8_t> ibus_frames(std::size_t count) {
    Random random;
    std::vector<std::uint8_t> bytes(count * kIbusLength);
    for (std::size_t start = 0; start < bytes.size(); start += kIbusLength) {
        bytes[start] = kIbusLength;
        bytes[start + 1] = 0x40;
        unsigned checksum = 0xFFFF - kIbusLength - 0x40;
        for (std::size_t at = start + 2; at < start + kIbusBody; ++at) {
            bytes[at] = static_cast<std::uint8_t>((random() & 0xFFU) | 0x10U);
            checksum -= bytes[at];
        }
        bytes[start + kIbusBody] = static_cast<std::uint8_t>(checksum);
        bytes[start + kIbusBody + 1] = static_cast<std::uint8_t>(checksum >> 8U);
    }
    return bytes;
}

std::vector<ChannelFrame> channel_frames(std::size_t count, std::uint32_t absent) {
    Random random;
    std::vector<ChannelFrame> frames(count);
    for (ChannelFrame& frame : frames) {
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            frame.set(channel, Pulse::from_eighths(988 * 8 + (random() & 0x1FFFU)));
        }
        frame.frame_lost = false;
        frame.failsafe = false;
        frame.remove_all(absent);
    }
    return frames;
}

constexpr std::size_t kCrsfLength = 26;
constexpr std::size_t kGhstLength = 14;

/// Frames of `length` bytes as the encoder writes them.
std::vector<std::uint8_t> frames_of(ByteEncoder& encoder, std::size_t length, std::size_t count) {
    std::vector<std::uint8_t> bytes(count * length);
    const auto channels = channel_frames(count, 0);
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    for (std::size_t i = 0; i < count; ++i) {
        encoder.write(channels[i], wire, Instant{});
        std::memcpy(&bytes[i * length], wire.data(), length);
    }
    return bytes;
}

constexpr std::size_t kFport2Length = 27;

/// 16 channels. The sum of all bytes but the length, with each carry added again, is FF.
std::vector<std::uint8_t> fport2_frames(std::size_t count) {
    Random random;
    std::vector<std::uint8_t> bytes(count * kFport2Length);
    for (std::size_t start = 0; start < bytes.size(); start += kFport2Length) {
        bytes[start] = 0x18;
        bytes[start + 1] = 0xFF;
        unsigned sum = 0xFF;
        for (std::size_t at = start + 2; at < start + kFport2Length - 1; ++at) {
            bytes[at] = static_cast<std::uint8_t>(random());
            sum += bytes[at];
        }
        bytes[start + kFport2Length - 1] = static_cast<std::uint8_t>(0xFF - sum % 0xFF);
    }
    return bytes;
}

constexpr std::size_t kFportLength = 29;

/// 16 channels without escapes.
std::vector<std::uint8_t> fport_frames(std::size_t count) {
    Random random;
    std::vector<std::uint8_t> bytes(count * kFportLength);
    for (std::size_t start = 0; start < bytes.size(); start += kFportLength) {
        bytes[start] = bytes[start + kFportLength - 1] = 0x7E;
        bytes[start + 1] = 0x19;
        unsigned sum = 0x19;
        for (std::size_t at = start + 3; at < start + kFportLength - 2; ++at) {
            bytes[at] = static_cast<std::uint8_t>(random() & 0x5FU);
            sum += bytes[at];
        }
        // The last random byte makes room for a sum that needs no escape.
        std::uint8_t& last = bytes[start + kFportLength - 3];
        for (unsigned check = 0xFF - sum % 0xFF; check == 0x7D || check == 0x7E;
             check = 0xFF - sum % 0xFF) {
            ++last;
            ++sum;
        }
        bytes[start + kFportLength - 2] = static_cast<std::uint8_t>(0xFF - sum % 0xFF);
    }
    return bytes;
}

constexpr std::size_t kIbus2Length = 29;

/// Writes the CRC of a frame of i-BUS2 behind it.
void put_ibus2_check(std::span<std::uint8_t> frame) {
    unsigned crc = 0xFF;
    for (const std::uint8_t byte : frame.first(frame.size() - 1)) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) {
            crc = (crc << 1U) ^ ((crc & 0x80U) != 0 ? 0x125U : 0U);
        }
    }
    frame.back() = static_cast<std::uint8_t>(crc);
}

/// 18 channels of 11 bits in steps of 1 us.
std::array<std::uint8_t, 24> ibus2_key() {
    constexpr unsigned kType = 0x1B;
    std::array<std::uint8_t, 24> key{0x04, 24, 0x07};
    for (std::size_t bit = 0; bit < 5 * kChannelCount; ++bit) {
        std::uint8_t& byte = key[3 + bit / 8];
        byte = static_cast<std::uint8_t>(byte | (kType >> bit % 5 & 1U) << bit % 8);
    }
    put_ibus2_check(key);
    return key;
}

/// Values from 988 to 2011 us.
std::vector<std::uint8_t> ibus2_frames(std::size_t count) {
    Random random;
    std::vector<std::uint8_t> bytes(count * kIbus2Length);
    for (std::size_t start = 0; start < bytes.size(); start += kIbus2Length) {
        const auto frame = std::span(bytes).subspan(start, kIbus2Length);
        frame[1] = kIbus2Length;
        frame[2] = 0x07;
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            const std::uint32_t value = (random() & 0x3FFU) - 512;
            for (std::size_t bit = 0; bit < 11; ++bit) {
                const std::size_t at = 11 * channel + bit;
                std::uint8_t& byte = frame[3 + at / 8];
                byte = static_cast<std::uint8_t>(byte | (value >> bit & 1U) << at % 8);
            }
        }
        put_ibus2_check(frame);
    }
    return bytes;
}

constexpr std::size_t kExBusLength = 40;

/// 16 channels, no request.
std::vector<std::uint8_t> exbus_frames(std::size_t count) {
    constexpr std::array<std::uint8_t, 6> kHeader{0x3E, 0x03, kExBusLength, 0x06, 0x31, 32};
    constexpr std::size_t kBody = kExBusLength - 2;
    Random random;
    std::vector<std::uint8_t> bytes(count * kExBusLength);
    for (std::size_t start = 0; start < bytes.size(); start += kExBusLength) {
        std::memcpy(&bytes[start], kHeader.data(), kHeader.size());
        for (std::size_t at = start + kHeader.size(); at < start + kBody; at += 2) {
            bytes[at] = static_cast<std::uint8_t>(random());
            bytes[at + 1] = static_cast<std::uint8_t>((random() & 0x1FU) + 0x1F);
        }
        const std::uint16_t crc = ExBusCrc::of(0, std::span(bytes).subspan(start, kBody));
        bytes[start + kBody] = static_cast<std::uint8_t>(crc);
        bytes[start + kBody + 1] = static_cast<std::uint8_t>(crc >> 8U);
    }
    return bytes;
}

/// Two phases by turns. Without pauses, so the first few frames are the proof.
std::vector<std::uint8_t> dsm_frames(std::size_t count) {
    constexpr std::array<std::array<std::uint8_t, 7>, 2> kPhases{
        {{1, 5, 2, 3, 0, 7, 6}, {1, 5, 2, 3, 4, 8, 9}}};
    Random random;
    std::vector<std::uint8_t> bytes(count * kDsmFrameBytes);
    for (std::size_t i = 0; i < count; ++i) {
        std::uint8_t* const frame = &bytes[i * kDsmFrameBytes];
        frame[1] = 0xB2;
        for (std::size_t word = 0; word < kDsmWords; ++word) {
            const unsigned high = kPhases[i % 2][word] * 8U + random() % 8;
            frame[2 + 2 * word] = static_cast<std::uint8_t>(high);
            frame[3 + 2 * word] = static_cast<std::uint8_t>(random());
        }
    }
    return bytes;
}

struct WireByte {
    std::uint8_t value = 0;
    bool damaged = false;
};

std::vector<WireByte> read_pattern(std::string_view text) {
    std::vector<WireByte> pattern;
    for (std::size_t at = 0; at + 1 < text.size(); at += 2) {
        const std::array<char, 3> digits{text[at], text[at + 1], '\0'};
        const bool damaged = text[at] == '!';
        pattern.push_back(
            {static_cast<std::uint8_t>(std::strtoul(digits.data(), nullptr, 16)), damaged});
    }
    return pattern;
}

void take_frames(ByteDecoder& decoder, std::span<const std::uint8_t> bytes, DecodedFrame& frame) {
    const Instant received{};
    while (decoder.next(bytes, received, frame)) {
        sink = frame.first_byte;
    }
}

void decode_frames(const Work& work, ByteDecoder& decoder, std::span<const std::uint8_t> bytes,
                   std::size_t length) {
    const auto stream = bytes.first(work.units * length);
    DecodedFrame frame;
    if (work.about("bytes")) {
        for (const std::uint8_t& byte : stream) {
            take_frames(decoder, {&byte, 1}, frame);
        }
        return;
    }
    for (std::size_t at = 0; at < stream.size(); at += length) {
        take_frames(decoder, stream.subspan(at, length), frame);
    }
}

void decode_garbage(const Work& work, ByteDecoder& decoder) {
    std::vector<WireByte> pattern = read_pattern(work.pattern);
    Random random;
    if (work.pattern == "random") {
        pattern.resize(work.prepared * kGarbageBlock);
        for (WireByte& byte : pattern) {
            byte.value = static_cast<std::uint8_t>(random());
        }
    }
    std::vector<std::uint8_t> bytes(work.prepared * kGarbageBlock);
    std::vector<std::uint32_t> damaged;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        bytes[at] = pattern[at % pattern.size()].value;
        if (pattern[at % pattern.size()].damaged) {
            damaged.push_back(static_cast<std::uint32_t>(at));
        }
    }
    damaged.push_back(static_cast<std::uint32_t>(bytes.size()));
    const std::size_t piece = work.about("bytes") ? 1 : kLargestRead;
    const std::size_t end = work.units * kGarbageBlock;
    std::size_t next_damaged = 0;
    DecodedFrame frame;
    for (std::size_t at = 0; at < end;) {
        if (at == damaged[next_damaged]) {
            decoder.damaged_byte();
            take_frames(decoder, {}, frame);
            ++next_damaged;
            ++at;
            continue;
        }
        std::size_t length = piece < end - at ? piece : end - at;
        length = length < damaged[next_damaged] - at ? length : damaged[next_damaged] - at;
        take_frames(decoder, std::span(bytes).subspan(at, length), frame);
        at += length;
    }
}

/// Not inlined, so that the loop is the same whatever is prepared.
[[gnu::noinline]] void encode(std::span<const ChannelFrame> frames, ByteEncoder& encoder) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    for (const ChannelFrame& frame : frames) {
        sink = encoder.write(frame, wire, Instant{});
    }
}

std::unique_ptr<ByteDecoder> decoder_for(const Work& work) {
    if (work.about("exbus")) {
        return std::make_unique<ExBusDecoder>();
    }
    if (work.about("dsm")) {
        return std::make_unique<DsmDecoder>();
    }
    if (work.about("ibus2")) {
        auto decoder = std::make_unique<Ibus2Decoder>();
        DecodedFrame frame;
        take_frames(*decoder, ibus2_key(), frame);
        return decoder;
    }
    if (work.about("fport2")) {
        return std::make_unique<Fport2Decoder>();
    }
    if (work.about("fport")) {
        return std::make_unique<FportDecoder>();
    }
    if (work.about("crsf")) {
        return std::make_unique<CrsfDecoder>();
    }
    if (work.about("ghst")) {
        return std::make_unique<GhstDecoder>();
    }
    if (work.about("srxl")) {
        return std::make_unique<SrxlDecoder>();
    }
    if (work.about("sbus")) {
        return std::make_unique<SbusDecoder>(
            *SbusScale::named(work.about("frsky") ? "frsky" : "betaflight"));
    }
    return std::make_unique<IbusDecoder>();
}

std::unique_ptr<ByteEncoder> encoder_for(const Work& work) {
    if (work.about("crsf")) {
        return std::make_unique<CrsfEncoder>();
    }
    if (work.about("ghst")) {
        return std::make_unique<GhstEncoder>();
    }
    if (work.about("srxl")) {
        return std::make_unique<SrxlEncoder>();
    }
    if (work.about("sbus")) {
        return std::make_unique<SbusEncoder>(
            *SbusScale::named(work.about("frsky") ? "frsky" : "betaflight"));
    }
    return std::make_unique<IbusEncoder>(kChannelCount);
}

void run(const Work& work) {
    if (work.about("encode")) {
        // As a receiver with 14 channels sends them, or with all channels.
        const auto frames = channel_frames(
            work.prepared, work.about("absent") ? kAllChannels & ~((1U << 14U) - 1) : 0);
        encode(std::span(frames).first(work.units), *encoder_for(work));
    } else if (work.about("garbage")) {
        decode_garbage(work, *decoder_for(work));
    } else if (work.about("crsf") || work.about("ghst") || work.about("srxl")) {
        const std::size_t length = work.about("crsf")   ? kCrsfLength
                                   : work.about("ghst") ? kGhstLength
                                                        : kSrxlMostBytes;
        decode_frames(work, *decoder_for(work),
                      frames_of(*encoder_for(work), length, work.prepared), length);
    } else if (work.about("ibus2")) {
        decode_frames(work, *decoder_for(work), ibus2_frames(work.prepared), kIbus2Length);
    } else if (work.about("fport2")) {
        decode_frames(work, *decoder_for(work), fport2_frames(work.prepared), kFport2Length);
    } else if (work.about("fport")) {
        decode_frames(work, *decoder_for(work), fport_frames(work.prepared), kFportLength);
    } else if (work.about("dsm")) {
        decode_frames(work, *decoder_for(work), dsm_frames(work.prepared), kDsmFrameBytes);
    } else if (work.about("exbus")) {
        decode_frames(work, *decoder_for(work), exbus_frames(work.prepared), kExBusLength);
    } else if (work.about("sbus")) {
        decode_frames(work, *decoder_for(work), sbus_frames(work.prepared), kSbusFrameLength);
    } else {
        decode_frames(work, *decoder_for(work), ibus_frames(work.prepared), kIbusLength);
    }
}

}  // namespace
}  // namespace tribus

int main(int count, char** arguments) {
    tribus::Work work;
    if (count >= 4) {
        work = {.workload = arguments[1],
                .units = std::strtoul(arguments[2], nullptr, 10),
                .prepared = std::strtoul(arguments[3], nullptr, 10),
                .pattern = count > 4 ? arguments[4] : "random"};
    }
    if (work.units == 0 || work.units > work.prepared) {
        std::fputs("count_codecs WORKLOAD UNITS PREPARED [PATTERN], at most PREPARED units\n",
                   stderr);
        return 2;
    }
    tribus::run(work);
    return 0;
}
