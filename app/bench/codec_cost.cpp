#include "app/bench/codec_cost.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "app/bench/lane.h"
#include "app/cli/protocol_use.h"
#include "core/can_frame.h"
#include "pipelines/realtime/clock.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/registry/registry.h"

namespace tribus::bench {
namespace {

constexpr std::size_t kFramesPerRun = 1000;
constexpr int kLeastRuns = 3;

/// Keeps the compiler from removing unused results.
volatile std::size_t sink = 0;

/// Settings for protocols that need a description of the bus: 16 channels of 16 bits.
SettingValues dbc_settings() {
    std::string text = "VERSION \"\"\nBU_: A\n";
    SettingTree::Table messages;
    for (std::size_t message = 0; message < 4; ++message) {
        text += fmt::format("BO_ {} M{}: 8 A\n", 256 + message, message);
        SettingTree::Table signals;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t channel = 4 * message + i + 1;
            text += fmt::format(" SG_ C{} : {}|16@1+ (1,0) [0|65535] \"us\" A\n", channel, 16 * i);
            signals.push_back({fmt::format("C{}", channel), {static_cast<std::int64_t>(channel)}});
        }
        messages.push_back({fmt::format("M{}", message), {std::move(signals)}});
    }
    SettingValues settings;
    settings.set("dbc", SettingFile{"bench.dbc", std::move(text)});
    settings.set("signals", SettingTree{std::move(messages)});
    return settings;
}

std::optional<SettingValues> settings_for(const Protocol& protocol, SettingScope direction) {
    if (!protocol.goes(direction)) {
        return std::nullopt;
    }
    if (auto use = use_protocol(protocol, direction, {})) {
        return std::move(use->settings);
    }
    return protocol.name == "dbc" ? std::optional(dbc_settings()) : std::nullopt;
}

/// Time per frame of the best of several runs of `work` over `kFramesPerRun` frames.
template <class Work>
double best_nanoseconds(Duration length, Work work) {
    double best = std::numeric_limits<double>::max();
    const Instant end = monotonic_now() + length;
    for (int run = 0; run < kLeastRuns || monotonic_now() < end; ++run) {
        const Instant start = monotonic_now();
        sink = sink + work();
        const Duration took = monotonic_now() - start;
        best = std::min(best, static_cast<double>(took.count()) / kFramesPerRun);
    }
    return best;
}

/// Instants of a regular sender, so that no supervision reports a loss.
Instant frame_time(std::size_t number) {
    return Instant{} + std::chrono::seconds(1) +
           static_cast<std::int64_t>(number) * std::chrono::milliseconds(10);
}

std::vector<ChannelFrame> some_frames() {
    std::vector<ChannelFrame> frames;
    for (std::uint32_t number = 0; number < kFramesPerRun; ++number) {
        frames.push_back(numbered_channels(number));
    }
    return frames;
}

CodecCost serial_cost(const Protocol& protocol, const SettingValues& in, const SettingValues& out,
                      Duration length) {
    FrameEncoder encoder(protocol.make_encoder(out));
    const auto decoder = make_byte_decoder(protocol, in);
    const std::vector<ChannelFrame> frames = some_frames();
    std::vector<WireFrame> wires(frames.size());
    CodecCost cost{.protocol = std::string(protocol.name)};
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const auto bytes = encoder.encode(frames[i], Instant{}).bytes();
        std::ranges::copy(bytes, wires[i].bytes.begin());
        wires[i].length = bytes.size();
    }
    cost.encode_ns = best_nanoseconds(length / 2, [&] {
        std::size_t written = 0;
        for (const ChannelFrame& frame : frames) {
            written += encoder.encode(frame, Instant{}).bytes().size();
        }
        return written;
    });
    cost.decode_ns = best_nanoseconds(length / 2, [&] {
        std::size_t found = 0;
        DecodedFrame frame;
        for (const WireFrame& wire : wires) {
            std::span<const std::uint8_t> bytes(wire.bytes.data(), wire.length);
            while (decoder->next(bytes, Instant{}, frame)) {
                ++found;
            }
        }
        return found;
    });
    return cost;
}

struct CanSnapshot {
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    std::size_t count = 0;
};

CodecCost can_cost(const Protocol& protocol, const SettingValues& in, const SettingValues& out,
                   Duration length) {
    FrameEncoder encoder(protocol.make_encoder(out));
    const auto decoder = make_can_decoder(protocol, in);
    const std::vector<ChannelFrame> frames = some_frames();
    std::vector<CanSnapshot> snapshots(frames.size());
    std::size_t number = 0;
    CodecCost cost{.protocol = std::string(protocol.name)};
    cost.encode_ns = best_nanoseconds(length / 2, [&] {
        std::size_t written = 0;
        for (const ChannelFrame& frame : frames) {
            written += encoder.encode(frame, frame_time(number++)).can_frames().size();
        }
        return written;
    });
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const auto sent = encoder.encode(frames[i], frame_time(number++)).can_frames();
        std::ranges::copy(sent, snapshots[i].frames.begin());
        snapshots[i].count = sent.size();
    }
    cost.decode_ns = best_nanoseconds(length / 2, [&] {
        std::size_t found = 0;
        for (const CanSnapshot& snapshot : snapshots) {
            const Instant now = frame_time(number++);
            for (const CanFrame& frame : std::span(snapshot.frames).first(snapshot.count)) {
                found += decoder->next(frame, now) ? 1U : 0U;
            }
        }
        return found;
    });
    return cost;
}

}  // namespace

std::vector<CodecCost> measure_codecs(Duration length) {
    std::vector<CodecCost> costs;
    const Duration share = length / static_cast<std::int64_t>(protocols().size());
    for (const Protocol* protocol : protocols()) {
        const auto in = settings_for(*protocol, SettingScope::input);
        const auto out = settings_for(*protocol, SettingScope::output);
        if (in && out) {
            costs.push_back(protocol->shape == WireShape::bytes
                                ? serial_cost(*protocol, *in, *out, share)
                                : can_cost(*protocol, *in, *out, share));
        }
    }
    return costs;
}

}  // namespace tribus::bench
