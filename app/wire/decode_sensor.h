#pragma once

#include "app/wire/decoding.h"
#include "app/wire/sensors/sensor_conversation.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "transports/codecs/ibus_sensor/types.h"

namespace tribus {

/// The sensor bus, which has no channel frames but requests and replies: one exchange a line, then
/// a summary. Values have the units of their types; if the type is not known yet, they are printed
/// raw.
class SensorDecoding final : public Decoding {
  public:
    SensorDecoding(SensorTypes types, const DecodeOutput& output);

    void heading() override;
    void feed_burst(std::size_t index, const Burst& burst) override;
    void finish(const LogFacts& log) override;
    DecodedAmount amount() const override;
    std::string_view protocol() const override;
    int status_of_nothing() const override;

  private:
    SensorTypes types_;
    DecodeOutput output_;
    SensorConversation conversation_;
    SensorFrameFinder finder_;
};

}  // namespace tribus
