#include "app/wire/fitting_protocols.h"

#include <memory>
#include <vector>

#include <fmt/format.h>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_finder.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "core/counted.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/sbus/sbus24.h"

namespace tribus {

namespace {

class Sbus24Taker final : public RecordingTaker {
  public:
    void feed_burst(std::size_t /*index*/, const Burst& burst) override { watch.take(burst.bytes); }
    Sbus24Watch watch;
};

}  // namespace

std::string unread_frames_text(RecordingSource& recording) {
    Sbus24Taker taker;
    recording.read(taker);
    const std::uint64_t frames = taker.watch.frames();
    return frames == 0
               ? std::string()
               : fmt::format("tribus: it has {} of {}\n", counted(frames, "frame"), kSbus24Text);
}

std::string no_frame_text(RecordingSource& recording, std::string_view asked, std::uint64_t given) {
    const bool can = recording.kind() == RecordingKind::candump;
    const auto uses = of_shape(choose_protocols("auto", SettingScope::input, {}).value(),
                               can ? WireShape::can_frames : WireShape::bytes);
    SeveralTakers all;
    SensorFrameFinder sensors([](const ReceivedSensorFrame&) {});
    all.add(sensors);
    std::vector<std::unique_ptr<FrameFinder>> finders;
    for (const ProtocolUse& use : uses) {
        all.add(*finders.emplace_back(make_frame_finder(use, [](const FoundFrame&) {})));
    }
    recording.read(all);
    std::string fitting;
    const auto add = [&](std::string_view protocol, const Tally& tally) {
        if (tally.frames > 0 && protocol != asked) {
            fitting += fmt::format("{}{} ({})", fitting.empty() ? "" : ", ", protocol,
                                   counted(tally.frames, "frame"));
        }
    };
    for (std::size_t i = 0; i < uses.size(); ++i) {
        finders[i]->finish();
        add(uses[i].protocol->name, finders[i]->tally());
    }
    add(kSensorBusName, sensors.tally().frames);
    return unread_frames_text(recording) +
           fmt::format("tribus: no frame of {} in {}; {}\n", asked,
                       counted(given, can ? "CAN frame" : "byte"),
                       fitting.empty() ? "no other protocol finds any"
                                       : "protocols that find frames: " + fitting);
}

}  // namespace tribus
