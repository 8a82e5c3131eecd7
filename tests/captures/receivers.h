#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

/// The recorded receivers in figures, which the tests' twins of the recordings are made from.
/// Each figure was read off its recording; docs/protocols/ibus.md, "Recordings", "Period and gaps"
/// and "Sensor bus: timing", and docs/protocols/sbus.md, "Periods", have them too.
namespace tribus::test {

/// When the periods of a wire begin. A start is at most `early` before its place on the grid and
/// at most `late` behind it; one in `one_in` starts is not at its place.
struct Rhythm {
    std::chrono::nanoseconds first{};
    std::chrono::nanoseconds period{};
    std::chrono::nanoseconds early{};
    std::chrono::nanoseconds late{};
    unsigned one_in = 1;
    std::size_t periods = 0;
};

/// A channel reaches `us` in the frame with this number. Between two of them it moves evenly.
struct Reached {
    std::size_t frame = 0;
    int us = 0;
};

struct Course {
    std::size_t channel = 0;  ///< from 1
    std::vector<Reached> points;
};

/// i.Bus servo frames, one a period.
struct ServoFrames {
    /// Microseconds of each channel, 14 or 18 of them; those of `moves` apart.
    std::vector<int> channels;
    std::vector<Course> moves;
    /// The recording begins inside of a frame: so many bytes of its end, at such a time.
    std::size_t cut_first_bytes = 0;
    /// It begins inside of the first of these bytes, which therefore reads as this.
    std::optional<std::uint8_t> torn_byte;
    std::chrono::nanoseconds cut_first_at{};
};

/// SBUS2 frames, one a period, whose footers announce the slots in turn. The receiver itself sends
/// slot 0 behind each frame with the first footer.
struct Sbus2Frames {
    std::vector<unsigned> raw;  ///< 16 channels
    std::vector<std::uint8_t> footers;
    std::chrono::nanoseconds slot_after{};
    std::vector<std::vector<std::uint8_t>> slots;  ///< in turn
};

/// A sensor's value from an exchange on.
struct Measured {
    std::size_t exchange = 0;
    std::uint16_t raw = 0;
};

struct WiredSensor {
    std::uint8_t address = 0;
    /// Empty: its answers are not on this piece of the wire.
    std::vector<Measured> values;
};

/// The i.Bus sensor bus: one request a period to each sensor in turn. A request without an answer
/// is repeated in the next period. Now and then the next free address is probed, which nobody
/// answers; after that the first sensor comes again.
struct SensorExchanges {
    std::vector<WiredSensor> sensors;
    std::size_t first_sensor = 0;  ///< index of the one that is asked first
    std::size_t first_probe = 0;   ///< number of the exchange
    std::size_t probe_each = 66;
    std::vector<std::size_t> missed;          ///< numbers of the exchanges without their answer
    std::chrono::nanoseconds answer_least{};  ///< from the start of the request
    std::chrono::nanoseconds answer_most{};
    /// The recording ends inside of the last request: so many bytes of it.
    std::size_t cut_last_bytes = 0;
};

struct Receiver {
    std::string_view name;  ///< file name of its recording, without the ending
    /// Endings of the recording's files: .timed.txt, an analyser's .saleae.csv, and .channels.csv
    /// with the channels of each frame.
    std::vector<std::string_view> endings;
    std::chrono::nanoseconds byte_distance{};
    Rhythm rhythm;
    std::variant<ServoFrames, Sbus2Frames, SensorExchanges> wire;
};

/// The table of receivers. Constant, may be called from any thread.
std::span<const Receiver> receivers();

}  // namespace tribus::test
