#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

#include "app/cli/protocol_use.h"
#include "app/wire/decoding.h"
#include "app/wire/frames/frame_printer.h"
#include "transports/recordings/recording.h"

/// `decode` for CAN protocols, from candump logs.
namespace tribus {

/// The largest number of channel snapshots that one of the protocols finds.
std::uint64_t most_snapshots(std::span<const ProtocolUse> uses, const Recording& recording);

/// Channel snapshots of one CAN protocol.
class CanDecoding final : public Decoding {
  public:
    CanDecoding(const ProtocolUse& use, FramePrinter printer);

    void heading() override { printer_.heading(); }
    void feed_frame(const RecordedCanFrame& frame) override { finder_.feed(frame); }
    void finish(const LogFacts& facts) override;
    DecodedAmount amount() const override;
    std::string_view protocol() const override { return protocol_; }

  private:
    std::string_view protocol_;
    FramePrinter printer_;
    CanFrameFinder finder_;
};

/// Decodes a whole log by the one of several protocols that finds the most snapshots. Returns the
/// exit status.
int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& messages);

}  // namespace tribus
