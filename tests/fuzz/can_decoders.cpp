#include <array>
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config/load.h"
#include "core/can_frame.h"
#include "tests/fuzz/fuzz.h"
#include "transports/codecs/can_codec.h"

namespace tribus::fuzz::can_decoders_target {
namespace {

/// One input of each kind that reads CAN, and outputs that send to them. The DBC inputs are
/// examples.
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
[input.servos]
protocol = "dronecan"
interface = "can1"
carries = "servos"
[input.motors]
protocol = "dronecan"
interface = "can1"
carries = "motors"
fd = true
[output.classic]
protocol = "can"
interface = "can2"
[output.fd]
protocol = "can"
interface = "can2"
id = 0x400
fd = true
[output.long]
protocol = "can"
interface = "can2"
crc = "p01"
id = 0x1234500
extended = true
[output.drone]
protocol = "dronecan"
interface = "can3"
node_id = 42
[output.servos]
protocol = "dronecan"
interface = "can3"
node_id = 42
carries = "servos"
channels = 15
arms = true
[output.motors]
protocol = "dronecan"
interface = "can3"
node_id = 42
carries = "motors"
channels = 15
fd = true
[pipeline.main]
from = ["classic", "fd", "long", "drone", "servos", "motors"]
to = ["classic", "fd", "long", "drone", "servos", "motors"]
)";

struct Bus {
    std::vector<const InputConfig*> readers;
    std::vector<const OutputConfig*> speakers;
};

void add_ports(const Configuration& configuration, Bus& bus) {
    for (const InputConfig& input : configuration.inputs) {
        if (input.protocol->shape == WireShape::can_frames) {
            bus.readers.push_back(&input);
        }
    }
    for (const OutputConfig& output : configuration.outputs) {
        if (output.protocol->shape == WireShape::can_frames) {
            bus.speakers.push_back(&output);
        }
    }
}

const Bus& the_bus() {
    static const auto loaded = [] {
        std::vector<Configuration> all;
        all.push_back(load_configuration(kConfiguration, "fuzz.toml").value());
        for (const std::string name :
             {"canopen-pdo", "j1939-joystick", "rc-box", "rover-command"}) {
            all.push_back(
                load_configuration_file(TRIBUS_SOURCE_DIR "/config/examples/" + name + ".toml")
                    .value());
        }
        return all;
    }();
    static const auto made = [] {
        Bus ports;
        for (const Configuration& configuration : loaded) {
            add_ports(configuration, ports);
        }
        return ports;
    }();
    return made;
}

/// Returns a frame, mostly with an id that a decoder reads.
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

/// Returns the frames of a snapshot as its sender makes them. Each may be lost, repeated or
/// changed. No random frame would have the right checksum.
std::vector<CanFrame> spoken_by(FrameEncoder& speaker, Input& input, Instant now) {
    ChannelFrame snapshot;
    const std::uint8_t choice = input.byte();
    snapshot.frame_lost = (choice & 1U) != 0;
    snapshot.failsafe = (choice & 2U) != 0;
    const std::size_t channels = choice / 4 % (kChannelCount + 1);
    for (std::size_t channel = 0; channel < channels; ++channel) {
        snapshot.set(channel, Pulse::from_microseconds(880 + 5 * input.byte()));
    }
    snapshot.received = now - std::chrono::microseconds(input.byte()) * 100;
    std::vector<CanFrame> spoken;
    for (CanFrame part : speaker.encode(snapshot, now).can_frames()) {
        const std::uint8_t fate = input.byte();
        if (fate % 8 == 1) {
            continue;
        }
        if (fate % 8 == 2 && part.length > 0) {
            part.data[input.below(part.length)] ^= static_cast<std::uint8_t>(1U << (fate / 32U));
        }
        spoken.insert(spoken.end(), fate % 8 == 3 ? 2 : 1, part);
    }
    return spoken;
}

}  // namespace

/// Any frames of a bus: a decoder returns whole snapshots with values that a pulse can have, and
/// its counters only grow.
FUZZ_TARGET(can_decoders) {
    Input input({data, size});
    const Bus& bus = the_bus();
    const InputConfig& config = *bus.readers[input.below(bus.readers.size())];
    const auto decoder = make_can_decoder(*config.protocol, config.settings);
    const OutputConfig& other = *bus.speakers[input.below(bus.speakers.size())];
    FrameEncoder speaker(other.protocol->make_encoder(other.settings));
    Instant now = later(Instant{}, std::chrono::seconds(1));
    std::uint64_t refused = 0;
    while (!input.empty()) {
        constexpr std::uint8_t kSpoken = 128;
        now = later(now, std::chrono::microseconds(input.byte()) * 100);
        const auto frames = input.byte() < kSpoken
                                ? std::vector{frame_from(input, decoder->wanted())}
                                : spoken_by(speaker, input, now);
        for (const CanFrame& frame : frames) {
            const auto snapshot = decoder->next(frame, now);
            require(!snapshot || snapshot->received <= now, "values are not from the future");
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

}  // namespace tribus::fuzz::can_decoders_target
