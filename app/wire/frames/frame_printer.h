#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>

#include "app/wire/frames/can_frame_finder.h"
#include "app/wire/frames/frame_finder.h"
#include "transports/recordings/recording.h"

namespace tribus {

enum class DecodeFormat : std::uint8_t { text, json, csv };

/// Its name on the command line.
std::string_view recording_kind_name(RecordingKind kind);

/// Prints frames decoded from bytes or CAN frames, each as soon as it is complete.
class FramePrinter {
  public:
    /// The summary of a CSV goes to `messages`, all other output to `results`.
    FramePrinter(DecodeFormat format, RecordingKind input, std::ostream& results,
                 std::ostream& messages);

    void heading();
    void frame(const FoundFrame& found);
    /// The text that `frame` prints.
    std::string line(const FoundFrame& found) const;
    void line(std::string_view printed);
    void summary(const Tally& tally);
    void can_summary(const CanTally& tally);

  private:
    DecodeFormat format_;
    RecordingKind input_;
    std::ostream& results_;
    std::ostream& messages_;
};

}  // namespace tribus
