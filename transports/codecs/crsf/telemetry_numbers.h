#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>

/// The messages of CRSF telemetry, as implementations count where TBS's text differs
/// (docs/protocols/crsf.md, "Telemetry"). The keys of an output and the names of received values.
namespace tribus {

/// How a number stands in a message.
enum class TelemetryForming : std::uint8_t {
    straight,
    altitude,  ///< dm + 10000 of less than 8000, else metres in the low 15 bits
    climb,     ///< finer around 0: +-25 m/s in a byte
    turn,      ///< straight; degrees from 0 to 360, whatever is counted
};

/// A number in a message, high byte first. Straight: value * scale + offset.
struct TelemetryNumber {
    std::string_view key;
    std::string_view unit;
    std::size_t bytes = 2;
    bool is_signed = false;
    double scale = 1;
    double offset = 0;
    TelemetryForming forming = TelemetryForming::straight;
};

/// How the numbers of a message are named.
enum class TelemetryForm : std::uint8_t {
    table,     ///< KEY.NUMBER
    single,    ///< KEY
    numbered,  ///< KEY.1 to KEY.N: behind a byte that says which source, several of one kind
};

struct TelemetryMessage {
    std::string_view key;
    std::uint8_t type = 0;
    TelemetryForm form = TelemetryForm::table;
    std::span<const TelemetryNumber> numbers;
    /// With `numbered`.
    std::size_t most = 1;
    /// How many numbers a shorter message must have, if not all.
    std::optional<std::size_t> least{};
};

/// The source of numbered values that is sent and read: the board itself.
inline constexpr std::uint8_t kTelemetrySource = 0;

inline constexpr double kTenThousandthRadiansADegree = 10'000 * std::numbers::pi / 180;
inline constexpr std::array kBatteryNumbers{
    TelemetryNumber{"voltage", "V", 2, false, 10}, TelemetryNumber{"current", "A", 2, true, 10},
    TelemetryNumber{"consumed", "mAh", 3}, TelemetryNumber{"remaining", "%", 1}};
inline constexpr std::array kGpsNumbers{
    TelemetryNumber{"latitude", "deg", 4, true, 1e7},
    TelemetryNumber{"longitude", "deg", 4, true, 1e7},
    TelemetryNumber{"speed", "km/h", 2, false, 10},
    TelemetryNumber{"heading", "deg", 2, false, 100, 0, TelemetryForming::turn},
    TelemetryNumber{"altitude", "m", 2, false, 1, 1000},
    TelemetryNumber{"satellites", "", 1}};
inline constexpr std::array kAttitudeNumbers{
    TelemetryNumber{"pitch", "deg", 2, true, kTenThousandthRadiansADegree},
    TelemetryNumber{"roll", "deg", 2, true, kTenThousandthRadiansADegree},
    TelemetryNumber{"yaw", "deg", 2, true, kTenThousandthRadiansADegree}};
inline constexpr std::array kVarioNumber{TelemetryNumber{"vario", "m/s", 2, true, 100}};
inline constexpr std::array kAirspeedNumber{TelemetryNumber{"airspeed", "km/h", 2, false, 10}};
inline constexpr std::array kRpmNumber{TelemetryNumber{"rpm", "1/min", 3, true}};
inline constexpr std::array kTemperatureNumber{TelemetryNumber{"temperature", "degC", 2, true, 10}};
inline constexpr std::array kCellsNumber{TelemetryNumber{"cells", "V", 2, false, 1000}};

/// Statistics of the radio link, as a transmitter module tells its handset.
inline constexpr std::array kLinkNumbers{TelemetryNumber{"up_rssi_1", "dBm", 1, false, -1},
                                         TelemetryNumber{"up_rssi_2", "dBm", 1, false, -1},
                                         TelemetryNumber{"up_quality", "%", 1},
                                         TelemetryNumber{"up_snr", "dB", 1, true},
                                         TelemetryNumber{"antenna", "", 1},
                                         TelemetryNumber{"mode", "", 1},
                                         TelemetryNumber{"power_number", "", 1},
                                         TelemetryNumber{"down_rssi", "dBm", 1, false, -1},
                                         TelemetryNumber{"down_quality", "%", 1},
                                         TelemetryNumber{"down_snr", "dB", 1, true}};

/// What one side hears of the other, as newer receivers and modules tell it.
inline constexpr std::array kReceiverLinkNumbers{
    TelemetryNumber{"rssi", "dBm", 1, false, -1}, TelemetryNumber{"rssi_percent", "%", 1},
    TelemetryNumber{"quality", "%", 1}, TelemetryNumber{"snr", "dB", 1, true},
    TelemetryNumber{"power", "dBm", 1, true}};
inline constexpr std::array kTransmitterLinkNumbers{
    TelemetryNumber{"rssi", "dBm", 1, false, -1},
    TelemetryNumber{"rssi_percent", "%", 1},
    TelemetryNumber{"quality", "%", 1},
    TelemetryNumber{"snr", "dB", 1, true},
    TelemetryNumber{"power", "dBm", 1, true},
    TelemetryNumber{"frame_rate", "Hz", 1, false, 0.1}};

/// Above the point where the flight controller was switched on.
inline constexpr std::array kBarometerNumbers{
    TelemetryNumber{"altitude", "m", 2, false, 1, 0, TelemetryForming::altitude},
    TelemetryNumber{"vario", "m/s", 1, true, 1, 0, TelemetryForming::climb}};

inline constexpr std::uint8_t kGpsType = 0x02;

/// Messages that are sent and read, in the order of the manual.
inline constexpr std::array kTelemetryMessages{
    TelemetryMessage{"battery", 0x08, TelemetryForm::table, kBatteryNumbers},
    TelemetryMessage{"gps", kGpsType, TelemetryForm::table, kGpsNumbers},
    TelemetryMessage{"attitude", 0x1E, TelemetryForm::table, kAttitudeNumbers},
    TelemetryMessage{"vario", 0x07, TelemetryForm::single, kVarioNumber},
    TelemetryMessage{"airspeed", 0x0A, TelemetryForm::single, kAirspeedNumber},
    TelemetryMessage{"rpm", 0x0C, TelemetryForm::numbered, kRpmNumber, 19},
    TelemetryMessage{"temperature", 0x0D, TelemetryForm::numbered, kTemperatureNumber, 20},
    TelemetryMessage{"cells", 0x0E, TelemetryForm::numbered, kCellsNumber, 29},
};
/// Messages that are only read.
inline constexpr std::array kReadMessages{
    TelemetryMessage{"baro", 0x09, TelemetryForm::table, kBarometerNumbers, 1, 1},
    TelemetryMessage{"link", 0x14, TelemetryForm::table, kLinkNumbers},
    TelemetryMessage{"receiver_link", 0x1C, TelemetryForm::table, kReceiverLinkNumbers},
    TelemetryMessage{"transmitter_link", 0x1D, TelemetryForm::table, kTransmitterLinkNumbers}};

}  // namespace tribus
