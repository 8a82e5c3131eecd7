#pragma once

#include <iosfwd>
#include <string>

#include "app/wire/frames/frame_printer.h"
#include "app/wire/sensors/sensor_conversation.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "transports/codecs/ibus_sensor/types.h"
#include "transports/recordings/recording.h"

namespace tribus {

/// Prints the exchanges of a sensor bus, one a line, then a summary. Values have the units of their
/// types; if the type is not known yet, they are printed raw.
class SensorPrinter {
  public:
    /// The summary of a CSV goes to `messages`, all other output to `results`. `results` and
    /// `messages` must outlive the printer.
    SensorPrinter(DecodeFormat format, RecordingKind input, SensorTypes types,
                  std::ostream& results, std::ostream& messages);

    void heading();
    void exchange(const SensorExchange& exchange);
    void summary(const SensorTally& tally, const SensorConversation& conversation);

  private:
    DecodeFormat format_;
    RecordingKind input_;
    SensorTypes types_;
    std::ostream& results_;
    std::ostream& messages_;
};

}  // namespace tribus
