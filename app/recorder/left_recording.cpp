#include "app/recorder/left_recording.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace tribus {
namespace {

using Failed = tl::unexpected<std::string>;

/// Upper limit of `memory` in [recorder].
constexpr std::size_t kMostRingBytes = std::size_t{64} * 1024 * 1024;

/// Instant of the newest plausible piece; nothing if there is none.
std::optional<Instant> latest_in(const CaptureRing& ring, bool can, Instant now) {
    std::array<CapturePiece, 64> pieces;
    const std::uint64_t begin = ring.begin();
    for (std::uint64_t end = ring.end(); end > begin;) {
        const std::uint64_t count = std::min<std::uint64_t>(pieces.size(), end - begin);
        end -= count;
        const auto batch = ring.read(end, std::span(pieces).first(static_cast<std::size_t>(count)));
        for (std::size_t i = batch.count; i > 0; --i) {
            if (can_be_recorded(pieces[i - 1], can) && pieces[i - 1].at() <= now) {
                return pieces[i - 1].at();
            }
        }
    }
    return std::nullopt;
}

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

tl::expected<LeftRecording, std::string> read_left_recording(const std::filesystem::path& folder,
                                                             Instant now) {
    const auto text = RingMemory::copy_of(folder / kRecordingPlanFile, kMostPlanBytes);
    if (!text) {
        return Failed(text.error());
    }
    auto plan = plan_from_text(as_text(text->span()));
    if (!plan || plan->begin > now) {
        return Failed(fmt::format("{} is damaged", kRecordingPlanFile));
    }
    LeftRecording left;
    left.plan = std::move(*plan);
    for (const RecordedPort& port : left.plan.ports) {
        auto memory = RingMemory::copy_of(folder / port.ring_file, kMostRingBytes);
        if (!memory) {
            return Failed(memory.error());
        }
        const auto ring = CaptureRing::adopt(memory->span());
        if (!ring) {
            return Failed(fmt::format("{} is damaged", port.ring_file));
        }
        left.memories.push_back(std::move(*memory));
        left.rings.push_back(*ring);
        left.latest = std::max(left.latest, latest_in(*ring, port.can, now).value_or(Instant{}));
    }
    if (left.latest == Instant{}) {
        return Failed("nothing was recorded yet");
    }
    return left;
}

}  // namespace tribus
