#include <string>

#include "tests/fuzz/fuzz.h"
#include "transports/recordings/recording.h"

namespace tribus::fuzz::recording_target {

/// A recording of any kind is refused with a place in it, or its times never go back.
FUZZ_TARGET(recording) {
    Input input({data, size});
    const std::string_view text = input.rest_as_text();
    const auto recording = parse_recording(text, "fuzz.txt");
    if (!recording) {
        require(recording.error().starts_with("fuzz.txt"), "a mistake names its file");
        return 0;
    }
    for (std::size_t i = 1; recording->timed && i < recording->bursts.size(); ++i) {
        require(recording->bursts[i - 1].start <= recording->bursts[i].start,
                "times of bursts do not go back");
    }
    for (std::size_t i = 1; i < recording->can_frames.size(); ++i) {
        require(recording->can_frames[i - 1].at <= recording->can_frames[i].at,
                "times of CAN frames do not go back");
    }
    return 0;
}

}  // namespace tribus::fuzz::recording_target
