#include "transports/codecs/pwm/pwm.h"

#include <algorithm>

#include "core/pwm_pulses.h"
#include "core/rounding.h"

namespace tribus {
namespace {

constexpr double kNanosecondsAnEighth = 125;
/// The shortest and longest pulses that are sent: no servo knows others.
constexpr int kLeastPulseEighths = 8 * 400;
constexpr int kMostPulseEighths = 8 * 2600;

}  // namespace

std::uint32_t PwmEncoder::needed_channels(const ChannelFrame& /*frame*/) const {
    std::uint32_t needed = 0;
    for (const PwmOutput& output : outputs_) {
        needed |= 1U << output.channel;
    }
    return needed;
}

std::size_t PwmEncoder::write(const ChannelFrame& frame,
                              std::span<std::uint8_t, kLongestSerialFrame> wire, Instant /*now*/) {
    std::size_t length = 0;
    for (const PwmOutput& output : outputs_) {
        const int eighths = std::clamp(frame.channel_or(output.channel, kCentrePulse).eighths(),
                                       kLeastPulseEighths, kMostPulseEighths);
        const double nanoseconds = eighths * kNanosecondsAnEighth * calibration_;
        pwm_pulses::put(wire.subspan(length, pwm_pulses::kRecordBytes), output.output,
                        static_cast<std::uint32_t>(nearest_whole(nanoseconds)));
        length += pwm_pulses::kRecordBytes;
    }
    return length;
}

std::size_t PwmEncoder::write_silence(std::span<std::uint8_t, kLongestSerialFrame> wire,
                                      Instant /*now*/) {
    std::size_t length = 0;
    for (const PwmOutput& output : outputs_) {
        pwm_pulses::put(wire.subspan(length, pwm_pulses::kRecordBytes), output.output,
                        pwm_pulses::kOff);
        length += pwm_pulses::kRecordBytes;
    }
    return length;
}

}  // namespace tribus
