#include <array>
#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "app/recorder/recording_plan.h"
#include "app/replay/capture_text.h"
#include "tests/fuzz/fuzz.h"
#include "transports/recordings/recording.h"

namespace tribus::fuzz::crash_recording_target {
namespace {

struct alignas(64) Line {
    std::array<std::byte, 64> bytes{};
};

bool stays_in_its_folder(const std::string& name) {
    return !name.empty() && name != "." && name != ".." && name.find('/') == std::string::npos;
}

void read_plan(std::string_view text) {
    const auto plan = plan_from_text(text);
    if (!plan) {
        return;
    }
    for (const RecordedPort& port : plan->ports) {
        for (const std::string* name : {&port.read_file, &port.written_file}) {
            require(name->empty() || stays_in_its_folder(*name), "a name stays in its folder");
        }
        require(stays_in_its_folder(port.ring_file), "the name of a ring stays in its folder");
    }
    for (const SideFile& file : plan->files) {
        require(stays_in_its_folder(file.name), "the name of a file stays in its folder");
    }
    const std::string again = plan_to_text(*plan);
    const auto same = plan_from_text(again);
    require(same && plan_to_text(*same) == again, "a plan that is taken is taken again");
}

void read_ring(std::span<const std::uint8_t> image, bool can) {
    std::vector<Line> lines((image.size() + sizeof(Line) - 1) / sizeof(Line));
    if (image.empty()) {
        return;
    }
    std::memcpy(lines.data(), image.data(), image.size());
    const auto ring = CaptureRing::adopt(std::as_writable_bytes(std::span(lines)));
    if (!ring) {
        return;
    }
    CaptureText text({.can = can,
                      .interface = "can0",
                      .byte_time = std::chrono::microseconds(87),
                      .zero = Instant{},
                      .zero_wall = std::chrono::seconds(1'795'348'805),
                      .end = Instant(std::chrono::hours(1))});
    std::vector<CapturePiece> pieces(lines.size());
    const auto batch = ring->read(0, pieces);
    text.take(std::span(pieces).first(batch.count));
    text.finish();
    for (const std::string* recorded : {&text.read(), &text.written()}) {
        require(parse_recording(*recorded, "recorded").has_value(), "what is written can be read");
    }
}

}  // namespace

/// Files that a crashed process left in memory: its plan, or the ring of a port, is refused, or the
/// recording made from it stays in one folder and can be read.
FUZZ_TARGET(crash_recording) {
    Input input({data, size});
    const std::size_t kind = input.below(3);
    if (kind == 0) {
        read_plan(input.rest_as_text());
    } else {
        read_ring(input.rest(), kind == 2);
    }
    return 0;
}

}  // namespace tribus::fuzz::crash_recording_target
