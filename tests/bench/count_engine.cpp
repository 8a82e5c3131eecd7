#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "pipelines/engine/engine.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

/// count_engine WORKLOAD UNITS PREPARED
///
/// Passes UNITS frames through an engine with one input and one output, under virtual time: bytes
/// in one read, pause, decoding, supervision, selection, map, encoding, schedule. As count_codecs:
/// the difference between two runs with other UNITS is only the work, and nothing is printed. The
/// word `14` or `18` in WORKLOAD is the number of channels; `sbus_to` and `map` change the rest.
namespace tribus {
namespace {

/// Receives the results, so that the compiler cannot leave out the computation.
volatile std::uint64_t sink = 0;

bool about(std::string_view workload, std::string_view word) {
    return workload.find(word) != workload.npos;
}

InputSettings input_of(std::string_view workload) {
    InputSettings input;
    input.name = "in";
    input.byte_time = std::chrono::nanoseconds(86'806);
    if (about(workload, "sbus_to")) {
        input.decoder = std::make_unique<SbusDecoder>();
        input.byte_time = std::chrono::microseconds(120);
    } else {
        input.decoder = std::make_unique<IbusDecoder>();
    }
    input.supervision.plausible =
        PulseRange{Pulse::from_microseconds(800), Pulse::from_microseconds(2200)};
    return input;
}

OutputSettings output_of(std::string_view workload) {
    OutputSettings output;
    output.name = "out";
    if (about(workload, "sbus_to")) {
        output.encoder = std::make_unique<IbusEncoder>(std::size_t{18});
    } else {
        output.encoder = std::make_unique<SbusEncoder>();
    }
    output.schedule.period = std::chrono::milliseconds(7);
    output.selection.inputs = {0};
    for (std::size_t channel = 0; about(workload, "map") && channel < kChannelCount; ++channel) {
        output.channels.push_back({.output = channel,
                                   .source = FromChannel{channel},
                                   .min = Pulse::from_microseconds(900),
                                   .max = Pulse::from_microseconds(2100)});
    }
    return output;
}

/// A frame whose channels differ from each other and from one frame to the next.
std::vector<std::uint8_t> frame_of(std::string_view workload, std::size_t number) {
    constexpr std::size_t kStep = 37;
    constexpr std::size_t kTravel = 1000;
    const std::size_t channels = about(workload, "14") ? 14 : kChannelCount;
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < channels; ++channel) {
        frame.set(channel, Pulse::from_microseconds(static_cast<std::int64_t>(
                               1000 + (number + channel) * kStep % kTravel)));
    }
    std::vector<std::uint8_t> wire(kLongestSerialFrame);
    const auto room = std::span(wire).first<kLongestSerialFrame>();
    wire.resize(about(workload, "sbus_to") ? SbusEncoder().write(frame, room, Instant{})
                                           : IbusEncoder(channels).write(frame, room, Instant{}));
    return wire;
}

void count(std::string_view workload, std::size_t units, std::size_t prepared) {
    std::vector<InputSettings> inputs;
    inputs.push_back(input_of(workload));
    std::vector<OutputSettings> outputs;
    outputs.push_back(output_of(workload));
    Engine engine(std::move(inputs), std::move(outputs));
    std::vector<std::vector<std::uint8_t>> frames;
    for (std::size_t i = 0; i < prepared; ++i) {
        frames.push_back(frame_of(workload, i));
    }
    Instant now{std::chrono::seconds(1)};
    engine.start(now);
    for (std::size_t unit = 0; unit < units; ++unit) {
        constexpr std::size_t kStep = 7919;
        constexpr std::size_t kJitter = 60;
        now += std::chrono::microseconds(7700 + unit * kStep % kJitter);
        engine.receive(0, frames[unit % prepared], now);
        engine.poll(now);
        for (const std::size_t output : engine.ran()) {
            const Transmission sent = engine.output(output).take();
            if (!sent.empty()) {
                engine.output(output).written();
                sink = sink + sent.bytes().front();
            }
        }
    }
}

}  // namespace
}  // namespace tribus

int main(int words, char** word) {
    if (words < 4) {
        return 2;
    }
    tribus::count(word[1], std::strtoul(word[2], nullptr, 10), std::strtoul(word[3], nullptr, 10));
    return 0;
}
