#include "transports/recordings/recording.h"

#include <string>
#include <utility>

#include "transports/recordings/burst_reader.h"
#include "transports/recordings/candump.h"
#include "transports/recordings/text.h"

namespace tribus {

using recording_text::Mistake;

tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name,
                                                     RecordingKind kind) {
    if (kind == RecordingKind::candump) {
        return parse_candump(content, file_name);
    }
    Recording recording;
    recording.kind = kind;
    recording.timed = kind == RecordingKind::timed || kind == RecordingKind::saleae;
    OnePiece piece(content);
    BurstReader reader(piece, file_name, kind);
    auto burst = reader.next();
    for (; burst && *burst; burst = reader.next()) {
        recording.bursts.push_back(std::move(**burst));
    }
    if (!burst) {
        return Mistake(std::move(burst.error()));
    }
    recording.rest = reader.rest();
    return recording;
}

tl::expected<Recording, std::string> parse_recording(std::string_view content,
                                                     std::string_view file_name) {
    const auto kind = detect_recording_kind(content, file_name);
    if (!kind) {
        return Mistake(kind.error());
    }
    return parse_recording(content, file_name, *kind);
}

}  // namespace tribus
