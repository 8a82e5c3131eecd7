#include "tests/support/known_receivers.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <span>

#include "core/setting.h"
#include "transports/codecs/codec.h"
#include "transports/registry/registry.h"

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kThrottle = 2;

Pulse us(std::int64_t microseconds) {
    return Pulse::from_microseconds(microseconds);
}

ChannelFrame with_flags(ChannelFrame frame, bool frame_lost, bool failsafe) {
    frame.frame_lost = frame_lost;
    frame.failsafe = failsafe;
    return frame;
}
ChannelFrame with_throttle(ChannelFrame frame, std::int64_t microseconds) {
    frame.set(kThrottle, us(microseconds));
    return frame;
}
ChannelFrame all_at(std::int64_t microseconds) {
    ChannelFrame frame;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, us(microseconds));
    }
    frame.set(16, kSwitchOffPulse);
    frame.set(17, kSwitchOffPulse);
    return with_flags(frame, false, false);
}

std::optional<ChannelFrame> held(Duration /*since*/, const ChannelFrame& last) {
    return last;
}
std::optional<ChannelFrame> silence(Duration /*since*/, const ChannelFrame& /*last*/) {
    return std::nullopt;
}
/// Sticks centred, throttle at a usual low: values that occur in every flight.
std::optional<ChannelFrame> presets_within_range(Duration /*since*/, const ChannelFrame& last) {
    ChannelFrame frame = last;
    for (const std::size_t stick : {0U, 1U, 3U}) {
        frame.set(stick, us(1500));
    }
    return with_throttle(frame, 1010);
}
std::optional<ChannelFrame> both_flags(Duration /*since*/, const ChannelFrame& last) {
    return with_flags(last, true, true);
}
auto throttle_at(std::int64_t microseconds) {
    return [microseconds](Duration, const ChannelFrame& last) {
        return std::optional(with_throttle(last, microseconds));
    };
}

std::vector<KnownReceiver> ibus_receivers() {
    constexpr Duration kPeriod = 7700us;
    return {
        {"FS-iA6B, no failsafe set: last values for ever", "ibus", kPeriod, held,
         ToldBy::standing_still},
        {"FS-iA6B, no failsafe set, a transmitter without any tremble",
         "ibus",
         kPeriod,
         held,
         ToldBy::nothing,
         {},
         false},
        {"FS-iA6B, presets within the stick range, no tremble",
         "ibus",
         kPeriod,
         presets_within_range,
         ToldBy::nothing,
         {},
         false},
        {"FS-iA6B, throttle preset below 1000 (BF#8877)", "ibus", kPeriod, throttle_at(900),
         ToldBy::value},
        {"FS-X6B, firmware that holds although a failsafe is set", "ibus", kPeriod, held,
         ToldBy::standing_still},
        {"Fli14, Flit10: throttle goes to 885 (BF#9754)", "ibus", kPeriod, throttle_at(885),
         ToldBy::value},
        {"AFHDS3 surface receiver: output stops", "ibus", 4ms, silence, ToldBy::silence},
        {"FS-iA6B that stops a few tenths of a second after (basejunction 2015)", "ibus", kPeriod,
         [](Duration since, const ChannelFrame& last) {
             return since < 400ms ? std::optional(last) : std::nullopt;
         },
         ToldBy::silence},
        {"RssiMod firmware: goes on, signal strength in channel 14", "ibus", kPeriod,
         [](Duration, const ChannelFrame& last) {
             ChannelFrame frame = last;
             frame.set(13, us(1000));
             return std::optional(frame);
         },
         ToldBy::value},
    };
}

/// Receivers with SBUS output. mLRS and ELRS do what their setting says.
std::vector<KnownReceiver> sbus_receivers() {
    constexpr Duration kPeriod = 9ms;
    const auto zeros = [](Duration, const ChannelFrame&) {
        return std::optional(with_flags(all_at(880), true, true));
    };
    return {
        {"Futaba R7003SB: both flags, values held", "sbus", 14ms, both_flags, ToldBy::flag},
        {"receiver in Carbon225: both flags, centre", "sbus", 14ms,
         [](Duration, const ChannelFrame&) {
             return std::optional(with_flags(all_at(1500), true, true));
         },
         ToldBy::flag},
        {"Futaba behind a splitter: frame lost for ever (ArduPilot 31088)", "sbus", 14ms,
         [](Duration, const ChannelFrame& last) {
             return std::optional(with_flags(last, true, false));
         },
         ToldBy::frame_lost},
        {"FrSky \"no pulses\": failsafe flag, all raw zero", "sbus", kPeriod, zeros, ToldBy::flag},
        {"FrSky zeros without a flag", "sbus", kPeriod,
         [](Duration, const ChannelFrame&) { return std::optional(all_at(880)); }, ToldBy::value},
        {"FrSky X8R: some channels at zero for 400 ms after the flag is gone", "sbus", kPeriod,
         zeros, ToldBy::flag,
         [](Duration since, const ChannelFrame& live) {
             return since < 400ms ? with_throttle(live, 880) : live;
         }},
        {"FrSky \"custom\": presets, failsafe flag", "sbus", kPeriod,
         [](Duration since, const ChannelFrame& last) {
             return std::optional(with_flags(*presets_within_range(since, last), false, true));
         },
         ToldBy::flag},
        {"FrSky \"not set\", minimum values, no flag", "sbus", kPeriod,
         [](Duration, const ChannelFrame&) { return std::optional(all_at(900)); }, ToldBy::value},
        {"ELRS, output stops", "sbus", kPeriod, silence, ToldBy::silence},
        {"ELRS, last values with 0x08", "sbus", kPeriod,
         [](Duration, const ChannelFrame& last) {
             return std::optional(with_flags(last, false, true));
         },
         ToldBy::flag},
        {"mLRS, low throttle with flags", "sbus", 19ms,
         [](Duration, const ChannelFrame& last) {
             return std::optional(with_flags(with_throttle(last, 988), true, true));
         },
         ToldBy::flag},
        {"mLRS, the mode that hides both flags, throttle below the sticks", "sbus", 19ms,
         throttle_at(900), ToldBy::value},
        {"mLRS, the mode that hides both flags, values within range, no tremble",
         "sbus",
         19ms,
         presets_within_range,
         ToldBy::nothing,
         {},
         false},
        {"FlySky in SBUS mode: throttle 850, others frozen, no reliable flag", "sbus", kPeriod,
         throttle_at(850), ToldBy::value},
    };
}

}  // namespace

const std::vector<KnownReceiver>& known_receivers() {
    static const std::vector<KnownReceiver> receivers = [] {
        std::vector<KnownReceiver> all = ibus_receivers();
        for (KnownReceiver& receiver : sbus_receivers()) {
            all.push_back(std::move(receiver));
        }
        return all;
    }();
    return receivers;
}

ChannelFrame pilot(Duration since_start, bool trembling) {
    const double seconds = std::chrono::duration<double>(since_start).count();
    const bool moving = since_start < 10s;
    ChannelFrame frame = all_at(1500);
    for (std::size_t stick = 0; stick < 4; ++stick) {
        const double turn =
            2 * std::numbers::pi * seconds * (0.3 + 0.1 * static_cast<double>(stick));
        const double travel = moving ? 500 * std::sin(turn) : stick == kThrottle ? -490 : 0;
        // One microsecond up or down, irregularly.
        const double tremble = trembling ? std::round(std::sin(seconds * 7919.0 + turn)) : 0;
        frame.set(stick, Pulse::from_fractional_microseconds(1500 + travel + tremble));
    }
    for (std::size_t lever = 4; lever < 8; ++lever) {
        const int position = moving ? static_cast<int>(seconds) % 3 : 0;
        frame.set(lever, us(1000 + 500 * position));
    }
    frame.set(13, us(1900 + (moving ? static_cast<int>(seconds * 10) % 50 : 20)));
    return frame;
}

LossStudyTimes study_times() {
    return {.off = Instant(15s), .back = Instant(25s)};
}
Instant study_end() {
    return Instant(30s);
}

std::vector<WireFrame> wire_of(const KnownReceiver& receiver, const Flight& flight) {
    const LossStudyTimes times = study_times();
    const Protocol* protocol = find_protocol(receiver.protocol);
    FrameEncoder encoder(protocol->make_encoder(SettingValues{}));
    std::vector<WireFrame> frames;
    ChannelFrame last;
    for (Instant at{}; at < study_end(); at += receiver.period) {
        std::optional<ChannelFrame> frame = flight(at.time_since_epoch());
        if (at < times.off) {
            last = *frame;
        } else if (at < times.back) {
            frame = receiver.lost(at - times.off, last);
        } else if (receiver.back) {
            frame = receiver.back(at - times.back, *frame);
        }
        if (!frame) {
            continue;
        }
        const auto bytes = encoder.encode(*frame, Instant(at)).bytes();
        frames.push_back(
            {at + protocol->line.bytes_time(bytes.size()), {bytes.begin(), bytes.end()}});
    }
    return frames;
}

}  // namespace tribus::test
