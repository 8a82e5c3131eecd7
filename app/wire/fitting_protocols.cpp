#include "app/wire/fitting_protocols.h"

#include <cstdint>

#include <fmt/format.h>

#include "app/cli/protocol_use.h"
#include "app/wire/decode_sensor.h"
#include "app/wire/frames/frame_finder.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "core/counted.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"

namespace tribus {
namespace {

std::uint64_t sensor_frames(const Recording& recording) {
    SensorFrameFinder finder([](const ReceivedSensorFrame&) {});
    for (const Burst& burst : recording.bursts) {
        finder.feed(burst);
    }
    return finder.tally().frames.frames;
}

}  // namespace

std::string no_frame_text(const Recording& recording, std::string_view asked) {
    const bool can = recording.kind == RecordingKind::candump;
    const auto uses = choose_protocols("auto", SettingScope::input, {});
    std::string fitting;
    const auto add = [&](std::string_view protocol, std::uint64_t frames) {
        if (frames > 0 && protocol != asked) {
            fitting += fmt::format("{}{} ({})", fitting.empty() ? "" : ", ", protocol,
                                   counted(frames, "frame"));
        }
    };
    for (const ProtocolUse& use :
         of_shape(uses.value(), can ? WireShape::can_frames : WireShape::bytes)) {
        add(use.protocol->name, find_frames(use, recording, [](const FoundFrame&) {}).frames);
    }
    std::uint64_t bytes = 0;
    for (const Burst& burst : recording.bursts) {
        bytes += burst.bytes.size();
    }
    if (!can) {
        add(kSensorBusName, sensor_frames(recording));
    }
    return fmt::format(
        "tribus: no frame of {} in {}; {}\n", asked,
        can ? counted(recording.can_frames.size(), "CAN frame") : counted(bytes, "byte"),
        fitting.empty() ? "no other protocol finds any" : "protocols that find frames: " + fitting);
}

}  // namespace tribus
