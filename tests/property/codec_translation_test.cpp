#include <gtest/gtest.h>

#include <array>
#include <string_view>

#include "tests/support/streams.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::codec_translation_test {
namespace {

using test::feed;

/// Returns the frame at the other end of a wire.
template <class Coder>
ChannelFrame over(ByteEncoder&& encoder, Coder& decoder, const ChannelFrame& frame) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, Instant{});
    const auto frames = feed(decoder, std::span(wire).first(length));
    if (!frames.empty()) {
        return frames.back().channels;
    }
    const auto last = decoder.finish();
    return last ? last->channels : ChannelFrame{};
}

/// Translates i.Bus to SBUS and back. Each of channels 1 to 16 takes every microsecond of the
/// range.
void expect_exact(std::string_view name, int least, int most) {
    const SbusScale scale = *SbusScale::named(name);
    const int count = most - least + 1;
    for (int base = 0; base < count; ++base) {
        ChannelFrame frame;
        for (int channel = 0; channel < 16; ++channel) {
            frame.set(static_cast<std::size_t>(channel),
                      Pulse::from_microseconds(least + (base + 431 * channel) % count));
        }
        frame.set(16, base % 2 == 0 ? kSwitchOnPulse : kSwitchOffPulse);
        frame.set(17, base % 3 == 0 ? kSwitchOnPulse : kSwitchOffPulse);
        frame.frame_lost = frame.failsafe = false;

        IbusDecoder from_receiver;
        SbusDecoder from_sbus(scale);
        IbusDecoder at_the_end;
        const ChannelFrame received = over(IbusEncoder(18), from_receiver, frame);
        ASSERT_TRUE(received.same_content(frame));
        const ChannelFrame translated = over(SbusEncoder(scale), from_sbus, received);
        const ChannelFrame back = over(IbusEncoder(18), at_the_end, translated);
        ASSERT_TRUE(back.same_content(frame)) << name << ", base " << base;
    }
}

TEST(TranslationProperty, EveryMicrosecondComesBackThroughSbus) {
    expect_exact("betaflight", 880, 2159);
}

// In these two scales 11 bits end 5 and 6 us earlier.
TEST(TranslationProperty, SoInTheScalesOfArduPilotAndPx4) {
    expect_exact("ardupilot", 880, 2154);
    expect_exact("px4", 880, 2153);
}

TEST(TranslationProperty, SoBetweenTheEndPointsOfTheMakers) {
    expect_exact("frsky", 988, 2012);
    expect_exact("futaba", 1000, 2000);
}

TEST(TranslationProperty, WhatSbusCannotHoldComesBackAsItsEnd) {
    for (int microseconds = 0; microseconds < 4096; ++microseconds) {
        ChannelFrame frame;
        frame.set(0, Pulse::from_microseconds(microseconds));
        SbusDecoder from_sbus;
        IbusDecoder at_the_end;
        const ChannelFrame back =
            over(IbusEncoder(14), at_the_end, over(SbusEncoder(), from_sbus, frame));
        ASSERT_EQ(back.channel(0)->whole_microseconds(), std::clamp(microseconds, 880, 2159));
    }
}

}  // namespace
}  // namespace tribus::codec_translation_test
