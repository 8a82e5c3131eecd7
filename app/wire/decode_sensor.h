#pragma once

#include "app/wire/decoding.h"
#include "app/wire/sensors/sensor_printer.h"

namespace tribus {

/// The sensor bus, which has no channel frames but requests and replies.
class SensorDecoding final : public Decoding {
  public:
    explicit SensorDecoding(SensorPrinter printer);

    void heading() override { printer_.heading(); }
    void feed_burst(std::size_t index, const Burst& burst) override;
    void finish(const LogFacts& facts) override;
    DecodedAmount amount() const override;
    std::string_view protocol() const override;
    int status_of_nothing() const override;

  private:
    SensorPrinter printer_;
    SensorConversation conversation_;
    SensorFrameFinder finder_;
};

}  // namespace tribus
