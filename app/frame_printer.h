#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>

#include "app/can_frame_finder.h"
#include "app/frame_finder.h"
#include "transports/links/recording.h"

namespace tribus {

enum class DecodeFormat : std::uint8_t { text, json, csv };

/// As the command line calls it.
std::string_view recording_kind_name(RecordingKind kind);

/// Writes the frames that bytes or CAN frames hold, each as soon as it is complete.
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
    void can_summary(const CanTally& tally);

  private:
    DecodeFormat format_;
    RecordingKind input_;
    std::ostream& results_;
    std::ostream& talk_;
};

}  // namespace tribus
