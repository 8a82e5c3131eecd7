#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>

#include "app/frame_finder.h"
#include "app/protocol_use.h"
#include "transports/links/recording.h"

namespace CLI {
class App;
}

/// The subcommand `decode`: recorded bytes to frames.
namespace tribus {

enum class DecodeFormat : std::uint8_t { text, json, csv };

/// Writes the frames of one protocol that bytes hold, each as soon as it is complete.
class FramePrinter {
  public:
    /// The summary of a CSV goes to `talk`, every other output to `results`.
    FramePrinter(DecodeFormat format, RecordingKind input, std::ostream& results,
                 std::ostream& talk);

    void heading();
    void frame(const FoundFrame& found);
    /// As `frame` would print it.
    std::string line(const FoundFrame& found) const;
    void line(std::string_view printed);
    void summary(const Tally& tally);

  private:
    DecodeFormat format_;
    RecordingKind input_;
    std::ostream& results_;
    std::ostream& talk_;
};

/// Decodes a whole recording and prints heading, frames and summary; returns the exit status.
///
/// With several protocols: the one that finds the most frames reads the recording; a burst that
/// none of its frames touches, and that is exactly one frame of another protocol, is that frame.
/// Thus files that list frames of several protocols, one a line, are read whole.
int decode_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                     FramePrinter& printer, std::ostream& talk);

/// Decodes raw bytes as they come; `read` returns the next ones, none at the end.
int decode_stream(const std::function<std::string()>& read, const ProtocolUse& use,
                  FramePrinter& printer, std::ostream& results);

void add_decode_command(CLI::App& app, int& status);

}  // namespace tribus
