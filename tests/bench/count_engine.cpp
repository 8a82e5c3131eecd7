#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "pipelines/engine/engine.h"
#include "pipelines/rules/channel_map.h"
#include "transports/codecs/dronecan/rc.h"
#include "transports/codecs/frame_encoder.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"

/// count_engine WORKLOAD UNITS PREPARED
///
/// Passes UNITS frames or CAN snapshots through an engine with one input and one output, under
/// virtual time: arrival in one piece, pause, decoding, supervision, selection, map, encoding,
/// schedule. As count_codecs: the difference between two runs with other UNITS is only the work,
/// and nothing is printed. WORKLOAD is two protocols with `_to_` between them, for example
/// `ibus14_to_sbus` for 14 channels of i.Bus. Behind it, `_map` adds a rule for each channel, and
/// `_core` leaves out the engine: only decoder, map with a rule for each channel, and encoder.
namespace tribus {
namespace {

/// Receives the results, so that the compiler cannot leave out the computation.
volatile std::uint64_t sink = 0;

constexpr std::size_t kFewChannels = 14;

bool about(std::string_view workload, std::string_view word) {
    return workload.find(word) != workload.npos;
}

bool begins(std::string_view side, std::string_view protocol) {
    return side.substr(0, protocol.size()) == protocol;
}

AnyDecoder decoder_of(std::string_view protocol) {
    if (begins(protocol, "sbus")) {
        return std::make_unique<SbusDecoder>();
    }
    if (begins(protocol, "can")) {
        return std::make_unique<CanChannelsDecoder>(CanChannelsFormat{});
    }
    if (begins(protocol, "dronecan")) {
        return std::make_unique<dronecan::RcDecoder>(dronecan::RcInputFormat{});
    }
    return std::make_unique<IbusDecoder>();
}

AnyEncoder encoder_of(std::string_view protocol) {
    if (begins(protocol, "sbus")) {
        return std::make_unique<SbusEncoder>();
    }
    if (begins(protocol, "can")) {
        return std::make_unique<CanChannelsEncoder>(CanChannelsFormat{});
    }
    if (begins(protocol, "dronecan")) {
        return std::make_unique<dronecan::RcEncoder>(dronecan::RcOutputFormat{.node = 42});
    }
    return std::make_unique<IbusEncoder>(begins(protocol, "ibus14") ? kFewChannels : kChannelCount);
}

InputSettings input_of(std::string_view protocol) {
    InputSettings input;
    input.name = "in";
    input.decoder = decoder_of(protocol);
    input.byte_time = begins(protocol, "sbus") ? Duration(std::chrono::microseconds(120))
                                               : Duration(std::chrono::nanoseconds(86'806));
    input.supervision.plausible =
        PulseRange{Pulse::from_microseconds(800), Pulse::from_microseconds(2200)};
    return input;
}

std::vector<ChannelRule> rules_of_all_channels() {
    std::vector<ChannelRule> rules;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        rules.push_back({.output = channel,
                         .source = FromChannel{channel},
                         .min = Pulse::from_microseconds(900),
                         .max = Pulse::from_microseconds(2100)});
    }
    return rules;
}

OutputSettings output_of(std::string_view protocol, bool map) {
    OutputSettings output;
    output.name = "out";
    output.encoder = encoder_of(protocol);
    output.schedule.period = std::chrono::milliseconds(7);
    output.selection.inputs = {0};
    if (map) {
        output.channels = rules_of_all_channels();
    }
    return output;
}

/// One arrival: bytes, or the frames of a snapshot.
struct Unit {
    std::vector<std::uint8_t> bytes;
    std::vector<CanFrame> frames;
};

/// Units whose channels differ from each other and from one unit to the next. As many of them as
/// are a multiple of 32 can be repeated: the counters of CAN then go on.
std::vector<Unit> units_of(std::string_view protocol, std::size_t count) {
    constexpr std::size_t kStep = 37;
    constexpr std::size_t kTravel = 1000;
    FrameEncoder encoder(encoder_of(protocol));
    const std::size_t channels = begins(protocol, "ibus14") ? kFewChannels : kChannelCount;
    std::vector<Unit> units;
    for (std::size_t number = 0; number < count; ++number) {
        ChannelFrame frame;
        frame.frame_lost = false;
        frame.failsafe = false;
        for (std::size_t channel = 0; channel < channels; ++channel) {
            frame.set(channel, Pulse::from_microseconds(static_cast<std::int64_t>(
                                   1000 + (number + channel) * kStep % kTravel)));
        }
        const Transmission sent = encoder.encode(frame, frame.received);
        units.push_back({{sent.bytes().begin(), sent.bytes().end()},
                         {sent.can_frames().begin(), sent.can_frames().end()}});
    }
    return units;
}

void arrive(Engine& engine, const Unit& unit, Instant now) {
    if (!unit.bytes.empty()) {
        engine.receive(0, unit.bytes, now);
    }
    for (const CanFrame& frame : unit.frames) {
        engine.receive(0, frame, now);
    }
}

void use(const Transmission& sent) {
    sink = sink + (sent.bytes().empty() ? sent.can_frames().front().id : sent.bytes().front());
}

/// Returns how many frames came out.
std::size_t count_core(std::string_view from, std::string_view to, std::size_t units,
                       std::size_t prepared) {
    const auto decoder = std::get<std::unique_ptr<ByteDecoder>>(decoder_of(from));
    const auto encoder = std::get<std::unique_ptr<ByteEncoder>>(encoder_of(to));
    ChannelMap map(rules_of_all_channels());
    const std::vector<Unit> incoming = units_of(from, prepared);
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    DecodedFrame decoded;
    std::size_t out = 0;
    for (std::size_t unit = 0; unit < units; ++unit) {
        std::span<const std::uint8_t> bytes = incoming[unit % prepared].bytes;
        while (decoder->next(bytes, Instant{}, decoded)) {
            encoder->write(map.apply(decoded.channels, Instant{}), wire, Instant{});
            sink = sink + wire[1];
            ++out;
        }
    }
    return out;
}

/// Returns how often the output sent.
std::size_t count(std::string_view from, std::string_view to, std::size_t units,
                  std::size_t prepared) {
    std::vector<InputSettings> inputs;
    inputs.push_back(input_of(from));
    std::vector<OutputSettings> outputs;
    outputs.push_back(output_of(to, about(to, "_map")));
    Engine engine(std::move(inputs), std::move(outputs));
    const std::vector<Unit> incoming = units_of(from, prepared);
    std::size_t sent_count = 0;
    Instant now{std::chrono::seconds(1)};
    engine.start(now);
    for (std::size_t unit = 0; unit < units; ++unit) {
        constexpr std::size_t kStep = 7919;
        constexpr std::size_t kJitter = 60;
        now += std::chrono::microseconds(7700 + unit * kStep % kJitter);
        arrive(engine, incoming[unit % prepared], now);
        engine.poll(now);
        for (const std::size_t output : engine.ran()) {
            const Transmission sent = engine.output(output).take();
            if (!sent.empty()) {
                engine.output(output).written();
                use(sent);
                ++sent_count;
            }
        }
    }
    return sent_count;
}

}  // namespace
}  // namespace tribus

int main(int words, char** word) {
    if (words < 4 || !tribus::about(word[1], "_to_")) {
        return 2;
    }
    constexpr std::string_view kTo = "_to_";
    const std::string_view workload = word[1];
    const std::size_t middle = workload.find(kTo);
    const std::string_view from = workload.substr(0, middle);
    const std::string_view to = workload.substr(middle + kTo.size());
    const std::size_t units = std::strtoul(word[2], nullptr, 10);
    const std::size_t prepared = std::strtoul(word[3], nullptr, 10);
    const auto work = tribus::about(to, "_core") ? tribus::count_core : tribus::count;
    // The first ones only start the input.
    constexpr std::size_t kStart = 20;
    return work(from, to, units, prepared) + kStart >= units ? 0 : 1;
}
