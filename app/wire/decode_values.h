#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/wire/decoding.h"
#include "transports/codecs/value_reader.h"

namespace tribus {

/// A protocol whose messages have named values instead of channels: one message a line, then a
/// summary. In CSV one value a line.
class ValueDecoding final : public Decoding {
  public:
    /// The protocol of `use` must have values.
    ValueDecoding(const ProtocolUse& use, const DecodeOutput& output);

    void heading() override;
    void feed_burst(std::size_t index, const Burst& burst) override;
    void finish(const LogFacts& log) override;
    DecodedAmount amount() const override { return {.frames = messages_, .given = bytes_}; }
    std::string_view protocol() const override { return use_.protocol->name; }
    int status_of_nothing() const override;

  private:
    void feed_byte(std::uint8_t byte, bool damaged, std::optional<Duration> start);
    Tally tally() const;

    ProtocolUse use_;
    DecodeOutput output_;
    std::unique_ptr<ByteValueReader> reader_;
    std::vector<ValueReading> readings_;
    std::uint64_t bytes_ = 0;
    std::uint64_t messages_ = 0;
};

}  // namespace tribus
