#pragma once

#include <iosfwd>
#include <span>
#include <string_view>

#include "app/cli/command.h"
#include "app/cli/protocol_use.h"
#include "app/wire/decoding.h"
#include "app/wire/frames/frame_printer.h"
#include "transports/recordings/recording.h"

/// The subcommand `decode`: decodes recorded bytes or CAN frames to channel frames.
namespace tribus {

/// Channel frames of one serial protocol.
class FrameDecoding final : public Decoding {
  public:
    FrameDecoding(const ProtocolUse& use, FramePrinter printer);

    void heading() override { printer_.heading(); }
    void feed_burst(std::size_t index, const Burst& burst) override { finder_.feed(index, burst); }
    void finish(const LogFacts& facts) override;
    DecodedAmount amount() const override;
    std::string_view protocol() const override { return protocol_; }

  private:
    std::string_view protocol_;
    FramePrinter printer_;
    FrameFinder finder_;
};

/// Decodes a whole recording and prints heading, frames and summary. Returns the exit status. Skips
/// CAN protocols.
///
/// If there are several protocols, the one that finds the most frames decodes the recording. A
/// burst that none of its frames touches and that is exactly one frame of another protocol is
/// decoded as that frame; so a file that lists frames of several protocols, one a line, is decoded
/// completely. If there are bytes but no frame of the only protocol, `messages` names protocols
/// that find frames.
int decode_bytes(const Recording& recording, std::span<const ProtocolUse> uses,
                 FramePrinter& printer, std::ostream& messages);

Command decode_command();

}  // namespace tribus
