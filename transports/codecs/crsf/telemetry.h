#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/setting.h"
#include "core/value_board.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/protocol.h"
#include "transports/codecs/sent_number.h"

/// Telemetry of CRSF: named values that a receiver passes on to the handset
/// (docs/protocols/crsf.md, "Telemetry").
namespace tribus {

extern const Protocol kCrsfTelemetryProtocol;

/// A number in a frame, high byte first: value * scale + offset, rounded and limited.
struct CrsfTelemetryField {
    std::string value;              ///< name; empty: the number is 0
    std::vector<std::string> path;  ///< of the key that names it
    std::string_view unit;          ///< of `value * scale`; empty: any
    double scale = 1;
    double offset = 0;
    std::size_t bytes = 2;
    bool is_signed = false;
    bool is_turn = false;  ///< degrees from 0 to 360; others are turned there
};

/// A frame of one type.
struct CrsfTelemetryFrame {
    std::uint8_t type = 0;
    std::vector<std::uint8_t> prefix{};  ///< bytes before the numbers
    std::vector<CrsfTelemetryField> fields{};
    /// Not empty: the frame has the text with the number of its only field instead of the number.
    std::vector<std::string> texts{};
};

/// The frames that the settings ask for, in the order of the manual. Adds what is wrong to
/// `mistakes`. For the start.
std::vector<CrsfTelemetryFrame> crsf_telemetry_frames(const SettingValues& settings,
                                                      std::vector<SettingMistake>& mistakes);

/// Writes one frame each time, in turn. A frame of which a value is missing or too old is left out,
/// and one with a negative number in a field without a sign. A value without a unit is taken as it
/// is.
class CrsfTelemetryEncoder final : public ByteEncoder {
  public:
    explicit CrsfTelemetryEncoder(std::vector<CrsfTelemetryFrame> frames);

    void use(const ValueBoard& board) override;
    std::uint32_t needed_channels(const ChannelFrame& /*frame*/) const override { return 0; }
    bool marks_frame_lost() const override { return false; }
    /// Returns 0 if no frame has all its values.
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;

  private:
    std::size_t write_frame(std::size_t index, std::span<std::uint8_t> wire, Instant now) const;

    std::vector<CrsfTelemetryFrame> frames_;
    /// For each field of each frame, one after the other.
    std::vector<SentNumber> numbers_;
    std::vector<std::size_t> first_number_;  ///< for each frame
    std::size_t next_ = 0;
};

}  // namespace tribus
