#include "app/wire/decoding.h"

#include "app/cli/exit_status.h"
#include "app/wire/fitting_protocols.h"

namespace tribus {
namespace {

/// Upper limit of the bytes kept while no frame was found; enough to find a protocol that fits.
constexpr std::size_t kMostKept = std::size_t{64} * 1024;

int status_of(const Decoding& decoding, RecordingSource& recording, std::ostream& messages) {
    const DecodedAmount amount = decoding.amount();
    if (amount.frames > 0 || amount.given == 0) {
        return kExitFine;
    }
    messages << no_frame_text(recording, decoding.protocol(), amount.given);
    return decoding.status_of_nothing();
}

}  // namespace

DecodedAmount amount_of(const Tally& tally) {
    return {.frames = tally.frames, .given = tally.can ? tally.can->frames : tally.bytes};
}

int Decoding::status_of_nothing() const {
    return kExitFine;
}

int decode_recording(RecordingSource& recording, Decoding& decoding, std::ostream& messages) {
    decoding.heading();
    decoding.finish(recording.read(decoding));
    return status_of(decoding, recording, messages);
}

int decode_stream(const std::function<std::string()>& read, Decoding& decoding,
                  std::ostream& results, std::ostream& messages) {
    Recording kept;
    Burst& all = kept.bursts.emplace_back();
    decoding.heading();
    while (results.good()) {
        const std::string bytes = read();
        if (bytes.empty()) {
            break;
        }
        decoding.feed_burst(
            0, {.start = std::nullopt, .bytes = {bytes.begin(), bytes.end()}, .damaged = {}});
        results.flush();
        if (decoding.amount().frames == 0 && all.bytes.size() < kMostKept) {
            all.bytes.insert(all.bytes.end(), bytes.begin(), bytes.end());
        }
    }
    decoding.finish({});
    RecordingInMemory recording(kept);
    return status_of(decoding, recording, messages);
}

int decode_log(const CanLogSource& source, Decoding& decoding, std::ostream& results,
               std::ostream& messages) {
    decoding.heading();
    results.flush();
    const CanLogEnd end = read_can_log(
        source, [&decoding](const RecordedCanFrame& frame) { decoding.feed_frame(frame); }, results,
        messages);
    decoding.finish(end.log);
    return end.failed ? kExitFailed : kExitFine;
}

}  // namespace tribus
