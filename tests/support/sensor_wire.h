#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "core/time.h"
#include "tests/support/ibus_checksum.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

/// Bytes of a sensor bus with their times, for the tests of its parser.
namespace tribus {

using Bytes = std::vector<std::uint8_t>;

inline constexpr Duration kByteTime = std::chrono::microseconds(95);

inline Bytes encoded(SensorCommand command, std::uint8_t address, const Bytes& data = {}) {
    std::array<std::uint8_t, kLongestSensorFrame> wire{};
    const std::size_t length = encode_sensor_frame(command, address, data, wire);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// All bytes on the wire, each with its time.
class Wire {
  public:
    void add(const Bytes& bytes) {
        for (const std::uint8_t byte : bytes) {
            bytes_.push_back({byte, now_});
            now_ += kByteTime;
        }
    }
    void pause(Duration duration) { now_ += duration; }
    std::size_t size() const { return bytes_.size(); }

    void lose(std::size_t at) { bytes_.erase(bytes_.begin() + static_cast<std::ptrdiff_t>(at)); }
    void flip(std::size_t at, std::uint8_t bits) { bytes_[at].byte ^= bits; }
    void insert(std::size_t at, std::uint8_t byte) {
        const Instant when = bytes_[at].at;
        bytes_.insert(bytes_.begin() + static_cast<std::ptrdiff_t>(at), {byte, when});
    }

    struct Found {
        Bytes frame;
        std::uint64_t first_byte = 0;
        std::size_t bytes_read = 0;  ///< bytes that the parser had read when it found the frame
    };
    std::vector<Found> read(SensorFrameParser& parser) const {
        std::vector<Found> found;
        for (std::size_t i = 0; i < bytes_.size(); ++i) {
            std::span<const std::uint8_t> one(&bytes_[i].byte, 1);
            while (const auto frame = parser.next(one, bytes_[i].at)) {
                const auto data = frame->payload();
                found.push_back(
                    {encoded(frame->command, frame->address, {data.begin(), data.end()}),
                     frame->first_byte, i + 1});
            }
        }
        return found;
    }
    std::vector<Bytes> frames() const {
        SensorFrameParser parser;
        std::vector<Bytes> frames;
        for (const Found& found : read(parser)) {
            frames.push_back(found.frame);
        }
        return frames;
    }

  private:
    struct Byte {
        std::uint8_t byte = 0;
        Instant at{};
    };
    std::vector<Byte> bytes_;
    Instant now_{std::chrono::seconds(1)};
};

inline Wire wire_of(const Bytes& bytes) {
    Wire wire;
    wire.add(bytes);
    return wire;
}

inline Bytes joined(std::initializer_list<Bytes> parts) {
    Bytes all;
    for (const Bytes& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

inline Bytes servo_frame(const std::vector<std::uint16_t>& slots) {
    Bytes frame{0x20, 0x40};
    for (const std::uint16_t slot : slots) {
        frame.push_back(static_cast<std::uint8_t>(slot));
        frame.push_back(static_cast<std::uint8_t>(slot >> 8U));
    }
    return test::with_ibus_checksum(frame);
}

inline const Bytes kRequest{0x04, 0xA1, 0x5A, 0xFF};
inline const Bytes kReply{0x06, 0xA1, 0x00, 0x00, 0x58, 0xFF};
inline const Bytes kProbe{0x04, 0x82, 0x79, 0xFF};
// docs/protocols/ibus.md, "Vectors", a receiver's frame.
inline const Bytes kServo{0x20, 0x40, 0xDB, 0x05, 0xDC, 0x05, 0x54, 0x05, 0xDC, 0x05, 0xE8,
                          0x03, 0xD0, 0x07, 0xD2, 0x05, 0xE8, 0x03, 0xDC, 0x05, 0xDC, 0x05,
                          0xDC, 0x05, 0xDC, 0x05, 0xDC, 0x05, 0xDC, 0x05, 0xDA, 0xF3};

}  // namespace tribus
