#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "transports/codecs/codec.h"
#include "transports/codecs/protocol.h"

/// Servo pulses of a PWM chip (docs/protocols/pwm.md).
namespace tribus {

extern const Protocol kPwmProtocol;

struct PwmOutput {
    std::size_t channel = 0;
    std::uint8_t output = 0;  ///< of the chip
};

/// Records of core/pwm_pulses.h, one for each output. In silence every output is switched off,
/// because a chip repeats its last pulse for ever.
class PwmEncoder final : public ByteEncoder {
  public:
    /// `calibration`: how much faster than it should the chip's oscillator is.
    PwmEncoder(std::vector<PwmOutput> outputs, double calibration)
        : outputs_(std::move(outputs)), calibration_(calibration) {}
    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::size_t write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                              Instant now) override;

  private:
    std::vector<PwmOutput> outputs_;
    double calibration_;
};

/// The outputs that a configuration names, in its order. Settings must be checked.
std::vector<PwmOutput> pwm_outputs(const SettingValues& settings);

}  // namespace tribus
