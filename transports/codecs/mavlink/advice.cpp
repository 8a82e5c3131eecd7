#include <cstdint>
#include <string>

#include "transports/codecs/mavlink/mavlink.h"

namespace tribus {
namespace {

/// An autopilot sends a HEARTBEAT once a second, and shows what it does within a few seconds.
constexpr std::uint32_t kAnswersWithoutEffect = 10;

constexpr std::uint8_t kArduPilot = 3;  // MAV_AUTOPILOT_ARDUPILOTMEGA
constexpr std::uint8_t kPx4 = 12;
constexpr std::uint8_t kRover = 10;  // MAV_TYPE
constexpr std::uint8_t kBoat = 11;

/// ArduPilot's rovers and boats take MANUAL_CONTROL's z from -1000 to 1000. Its other vehicles and
/// PX4 take 0 to 1000; copters leave a message with less out altogether.
std::string throttle_advice(const MavlinkEncoder::Settings& sent, std::uint16_t kind) {
    const auto autopilot = static_cast<std::uint8_t>(kind >> 8U);
    const auto vehicle = static_cast<std::uint8_t>(kind);
    const bool reverses = autopilot == kArduPilot && (vehicle == kRover || vehicle == kBoat);
    const bool centred = sent.throttle == MavlinkThrottle::centred;
    const std::string target = "autopilot " + std::to_string(sent.target);
    if (reverses && !centred) {
        return target + " is a " + (vehicle == kRover ? "rover" : "boat") +
               " with ArduPilot: a centred stick is half throttle there, and reverse cannot be "
               "reached; set throttle = \"centred\"";
    }
    if (centred && !reverses && (autopilot == kArduPilot || autopilot == kPx4)) {
        return target +
               " is no rover or boat with ArduPilot, and takes no throttle below the centre; set "
               "throttle = \"zero based\"";
    }
    return {};
}

/// Nobody tells a stranger that he is one.
std::string effect_advice(const MavlinkEncoder::Settings& sent) {
    const std::string what =
        sent.message == MavlinkChannels::radio_rc_channels
            ? "it must read RADIO_RC_CHANNELS (ArduPilot 4.6 and newer)"
            : "it takes overrides only from its ground station: its MAV_GCS_SYSID (before 4.7 "
              "SYSID_MYGCS) must be " +
                  std::to_string(sent.system) + ", the `system` of this output";
    return "autopilot " + std::to_string(sent.target) +
           " answers, but none of its RC_CHANNELS has these channels; " + what +
           (sent.key ? ", and have the same key" : "") +
           "; and it must send RC_CHANNELS (SRn_RC_CHAN 2 or more)";
}

}  // namespace

std::string mavlink_advice(const MavlinkEncoder::Settings& sent, const Answers& answers) {
    const bool manual = sent.message == MavlinkChannels::manual_control;
    if (manual && answers.kind != 0) {
        if (std::string advice = throttle_advice(sent, answers.kind); !advice.empty()) {
            return advice;
        }
    }
    if (answers.heard == 0 && answers.heard_others >= kAnswersWithoutEffect) {
        return "autopilot " + std::to_string(answers.other) + " answers, and none with system id " +
               std::to_string(sent.target) +
               ", the `target` of this output; set target to the id of the autopilot, its "
               "MAV_SYSID "
               "(before 4.7 SYSID_THISMAV)";
    }
    const bool without_effect = answers.heard >= kAnswersWithoutEffect && !answers.effect;
    return without_effect && !manual ? effect_advice(sent) : std::string();
}

}  // namespace tribus
