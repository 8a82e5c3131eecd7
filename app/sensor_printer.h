#pragma once

#include <iosfwd>
#include <string>

#include "app/frame_printer.h"
#include "app/sensor_conversation.h"
#include "app/sensor_frame_finder.h"
#include "transports/codecs/ibus_sensor_types.h"
#include "transports/links/recording.h"

namespace tribus {

/// Writes what was said on a sensor bus: a line for each request with its answer, then a summary.
/// Values are in the units of their types; where no sensor has said its type, they are as they were
/// sent.
class SensorPrinter {
  public:
    /// The summary of a CSV goes to `talk`, every other output to `results`. `types`, `results` and
    /// `talk` must outlive it.
    SensorPrinter(DecodeFormat format, RecordingKind input, const SensorTypes& types,
                  std::ostream& results, std::ostream& talk);

    void heading();
    void exchange(const SensorExchange& exchange);
    void summary(const SensorTally& tally, const SensorConversation& conversation);

  private:
    DecodeFormat format_;
    RecordingKind input_;
    const SensorTypes& types_;
    std::ostream& results_;
    std::ostream& talk_;
};

}  // namespace tribus
