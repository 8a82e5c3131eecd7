#include <memory>
#include <string>
#include <vector>

#include "config/load.h"
#include "core/can_frame.h"
#include "tests/fuzz/fuzz.h"
#include "transports/codecs/can_codec.h"

namespace tribus::fuzz {
namespace {

/// One input of each kind that reads CAN.
constexpr const char* kConfiguration = R"(
[input.classic]
protocol = "can"
interface = "can0"
[input.fd]
protocol = "can"
interface = "can0"
id = 0x400
fd = true
[input.long]
protocol = "can"
interface = "can0"
crc = "p01"
id = 0x1234500
extended = true
[input.drone]
protocol = "dronecan"
interface = "can1"
[input.drone_fd]
protocol = "dronecan"
interface = "can1"
fd = true
[output.servos]
protocol = "sbus"
device = "/dev/ttyA"
[pipeline.main]
from = ["classic", "fd", "long", "drone", "drone_fd"]
to = "servos"
)";

const Configuration& configuration() {
    static const auto loaded = load_configuration(kConfiguration, "fuzz.toml");
    require(loaded.has_value(), "the target's own configuration is valid");
    return *loaded;
}

/// Mostly an id that somebody listens to.
CanFrame frame_from(Input& input, std::span<const CanIdMatch> wanted) {
    CanFrame frame;
    const std::uint8_t kind = input.byte();
    const std::uint32_t chosen = input.word();
    if (!wanted.empty() && kind % 4 != 0) {
        const CanIdMatch& match = wanted[kind / 4 % wanted.size()];
        frame.id = (match.id & match.mask) | (chosen & ~match.mask & kMostExtendedId);
        frame.extended = match.extended;
    } else {
        frame.extended = (kind & 4U) != 0;
        frame.id = chosen & (frame.extended ? kMostExtendedId : kMostStandardId);
    }
    frame.fd = (kind & 0x80U) != 0;
    const std::size_t most = frame.fd ? kMostFdBytes : kMostClassicBytes;
    const auto content = input.take(std::min<std::size_t>(input.byte(), most));
    std::ranges::copy(content, frame.data.begin());
    frame.length = static_cast<std::uint8_t>(can_length_for(content.size()));
    return frame;
}

}  // namespace
}  // namespace tribus::fuzz

/// Any frames of a bus: a decoder gives whole snapshots with values that a pulse can have, and its
/// counters only grow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tribus;
    using fuzz::require;
    fuzz::Input input({data, size});
    const auto& inputs = fuzz::configuration().inputs;
    const InputConfig& config = inputs[input.below(inputs.size())];
    const auto decoder = config.protocol->make_can_decoder(config.settings);
    Instant now{};
    std::uint64_t refused = 0;
    while (!input.empty()) {
        now = later(now, std::chrono::microseconds(input.byte()) * 100);
        const CanFrame frame = fuzz::frame_from(input, decoder->wanted());
        if (const auto snapshot = decoder->next(frame, now)) {
            require(snapshot->received <= now, "values are not from the future");
        }
        std::uint64_t sum = 0;
        for (const NamedCount& cause : decoder->rejected()) {
            sum += cause.count;
        }
        require(sum >= refused, "counters only grow");
        refused = sum;
    }
    return 0;
}
