#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/mavlink.h"

namespace tribus::test::mavlink_encoder_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};

Bytes silence(MavlinkEncoder& encoder, Instant now = kStart) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write_silence(wire, now);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// The first frame, without the HEARTBEAT behind it.
Bytes first_message(const MavlinkEncoder::Settings& settings, const ChannelFrame& frame) {
    MavlinkEncoder encoder(settings);
    const Bytes bytes = encoded(encoder, frame, kStart);
    const std::size_t header = bytes.at(0) == 0xFE ? 8 : 12;
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(header + bytes.at(1))};
}

TEST(MavlinkEncoder, WritesTheVectorsOfAnOverride) {
    const ChannelFrame frame = frame_of_microseconds(kSixteenPulses);
    EXPECT_EQ(first_message({.message = MavlinkChannels::rc_channels_override}, frame),
              from_hex(kOverride));
    EXPECT_EQ(
        first_message(
            {.message = MavlinkChannels::rc_channels_override, .version_1 = true, .channels = 8},
            frame),
        from_hex(kOverride1));
}

TEST(MavlinkEncoder, WritesTheVectorsOfRadioChannels) {
    std::vector<double> pulses{1500, 1500, 1000, 1500, 2000};
    pulses.resize(16, 1500);
    ChannelFrame frame = frame_of_microseconds(pulses);
    frame.received = Instant{} + 123456ms + 999us;
    const MavlinkEncoder::Settings settings{.system = 51, .component = 68};
    EXPECT_EQ(first_message(settings, frame), from_hex(kRadioGood));
    frame.failsafe = true;
    EXPECT_EQ(first_message(settings, frame), from_hex(kRadioFailsafe));
}

/// The axis z of MANUAL_CONTROL for a pulse of channel 3.
int throttle_of(double pulse, MavlinkThrottle throttle) {
    const Bytes bytes =
        first_message({.message = MavlinkChannels::manual_control, .throttle = throttle},
                      frame_of_microseconds({1500, 1500, pulse, 1500}));
    return static_cast<std::int16_t>(bytes.at(14) | bytes.at(15) << 8);
}

TEST(MavlinkEncoder, WritesACentredThrottleForVehiclesThatReverse) {
    // ArduPilot's Rover maps z -1000 to 1000 to the ends of its throttle channel.
    for (const auto& [pulse, z] : {std::pair{1000, -1000},
                                   std::pair{1250, -500},
                                   {1500, 0},
                                   {1750, 500},
                                   {2000, 1000},
                                   {900, -1000},
                                   {2100, 1000}}) {
        EXPECT_EQ(throttle_of(pulse, MavlinkThrottle::centred), z) << pulse;
    }
    for (const auto& [pulse, z] : {std::pair{1000, 0}, {1500, 500}, {2000, 1000}, {900, 0}}) {
        EXPECT_EQ(throttle_of(pulse, MavlinkThrottle::zero_based), z) << pulse;
    }
}

TEST(MavlinkEncoder, WritesTheVectorOfManualControl) {
    const ChannelFrame frame =
        frame_of_microseconds({1000, 1000, 1500, 1500, 2000, 1501, 1500, 1000});
    EXPECT_EQ(first_message({.message = MavlinkChannels::manual_control, .buttons = 4}, frame),
              from_hex(kManual));
}

TEST(MavlinkEncoder, MarksALostFrameAsOutdated) {
    ChannelFrame frame = frame_of_microseconds({1500});
    frame.frame_lost = true;
    frame.cause = LinkCause::good;
    EXPECT_EQ(first_message({.channels = 1}, frame).at(10 + 4), 2);
    EXPECT_TRUE(MavlinkEncoder({}).marks_frame_lost());
    EXPECT_FALSE(MavlinkEncoder({.message = MavlinkChannels::manual_control}).marks_frame_lost());
}

TEST(MavlinkEncoder, MarksHeldValuesAsFailsafeToo) {
    // ArduPilot's AP_RCProtocol_MAVLinkRadio looks at the failsafe flag only.
    ChannelFrame frame = frame_of_microseconds({1500});
    frame.frame_lost = true;
    frame.cause = LinkCause::wire_silent;
    EXPECT_EQ(first_message({.channels = 1}, frame).at(10 + 4), 3);
}

TEST(MavlinkEncoder, SendsAHeartbeatBehindTheFirstFrameAndThenEverySecond) {
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override});
    const ChannelFrame frame = frame_of_microseconds(kSixteenPulses);
    const std::size_t alone = from_hex(kOverride).size();
    int heartbeats = 0;
    for (int i = 0; i < 500; ++i) {
        const Bytes bytes = encoded(encoder, frame, kStart + i * 20ms);
        const bool heartbeat = bytes.size() > alone;
        EXPECT_EQ(heartbeat, i % 50 == 0) << i;
        heartbeats += heartbeat ? 1 : 0;
        // Each message has the next number.
        ASSERT_EQ(bytes.at(4), static_cast<std::uint8_t>(i + heartbeats - (heartbeat ? 1 : 0)));
        if (heartbeat) {
            ASSERT_EQ(bytes.size(), alone + 21);
            ASSERT_EQ(bytes.at(alone + 4), static_cast<std::uint8_t>(bytes.at(4) + 1));
        }
    }
    EXPECT_EQ(heartbeats, 10);
}

TEST(MavlinkEncoder, WritesTheHeartbeatOfAGroundStation) {
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override});
    const Bytes bytes = encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart);
    Bytes expected = from_hex(kHeartbeatOfAStation);
    const Bytes payload(expected.begin() + 10, expected.begin() + 19);
    // The vector has number 0; here it is the second message.
    Bytes numbered = message_2(0, 50, payload, {.system = 255, .component = 190});
    EXPECT_EQ(Bytes(bytes.end() - 21, bytes.end()).size(), numbered.size());
    EXPECT_EQ(Bytes(bytes.end() - 11, bytes.end() - 2), payload);
    EXPECT_EQ(bytes.at(bytes.size() - 17), 1);
}

TEST(MavlinkEncoder, SaysNothingInSilenceNotEvenAHeartbeat) {
    for (const auto message :
         {MavlinkChannels::radio_rc_channels, MavlinkChannels::rc_channels_override,
          MavlinkChannels::manual_control}) {
        MavlinkEncoder encoder({.message = message});
        encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart);
        EXPECT_EQ(silence(encoder, kStart + 1h), Bytes{});
    }
}

TEST(MavlinkEncoder, GivesTheChannelsBackTenTimesAfterEachLoss) {
    MavlinkEncoder encoder(
        {.message = MavlinkChannels::rc_channels_override, .channels = 18, .releases = true});
    EXPECT_EQ(encoder.farewells(), 10);
    EXPECT_EQ(silence(encoder), Bytes{});
    for (int loss = 0; loss < 2; ++loss) {
        encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart);
        for (int i = 0; i < 10; ++i) {
            Bytes bytes = silence(encoder);
            const Bytes expected = from_hex(kReleaseAll);
            ASSERT_EQ(bytes.size(), expected.size());
            EXPECT_EQ(Bytes(bytes.begin() + 10, bytes.end() - 2),
                      Bytes(expected.begin() + 10, expected.end() - 2));
        }
        EXPECT_EQ(silence(encoder), Bytes{});
    }
}

TEST(MavlinkEncoder, LeavesChannelsAloneThatItDoesNotSend) {
    for (std::size_t count = 1; count <= 18; ++count) {
        const Bytes bytes =
            first_message({.message = MavlinkChannels::rc_channels_override, .channels = count},
                          frame_of_microseconds(std::vector<double>(18, 1500)));
        Bytes payload(bytes.begin() + 10, bytes.end() - 2);
        payload.resize(38);
        for (std::size_t channel = 0; channel < 18; ++channel) {
            const std::size_t at = channel < 8 ? 2 * channel : 2 + 2 * channel;
            const unsigned word = payload.at(at) | static_cast<unsigned>(payload.at(at + 1)) << 8U;
            // ArduPilot leaves 65535 alone in the first eight, and 0 in the others.
            EXPECT_EQ(word, channel < count ? 1500U : channel < 8 ? 65535U : 0U) << channel;
        }
        EXPECT_EQ(MavlinkEncoder({.channels = count}).needed_channels({}), (1U << count) - 1);
    }
    EXPECT_EQ(MavlinkEncoder({.message = MavlinkChannels::manual_control}).needed_channels({}),
              0b1111U);
    EXPECT_EQ(MavlinkEncoder({.message = MavlinkChannels::manual_control, .buttons = 2})
                  .needed_channels({}),
              0b111111U);
}

/// Each pulse through an encoder and a decoder.
void expect_round_trip(MavlinkChannels message, double least, double most, double within) {
    MavlinkEncoder encoder({.message = message, .channels = 4});
    MavlinkDecoder decoder({});
    for (double pulse = least; pulse <= most; pulse += 0.125) {
        const ChannelFrame frame = frame_of_microseconds({pulse, pulse, pulse, pulse});
        const auto frames = feed(decoder, encoded(encoder, frame));
        ASSERT_EQ(frames.size(), 1U) << pulse;
        for (std::size_t channel = 0; channel < 4; ++channel) {
            ASSERT_NEAR(frames[0].channels.channel(channel)->microseconds(), pulse, within);
        }
    }
}

TEST(MavlinkEncoder, IsReadBackToTheStepOfEachMessage) {
    expect_round_trip(MavlinkChannels::radio_rc_channels, 860, 2140, 0.125);
    expect_round_trip(MavlinkChannels::rc_channels_override, 1, 4094, 0.5);
    expect_round_trip(MavlinkChannels::manual_control, 1000, 2000, 1);
}

TEST(MavlinkEncoder, WritesTheLongestPulseAsOneThatReadersTake) {
    MavlinkDecoder decoder({});
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override, .channels = 2});
    const auto frames = feed(decoder, encoded(encoder, frame_of_microseconds({4095.875, 4095.5})));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), (std::vector<double>{4095, 4095}));
}

TEST(MavlinkEncoder, LimitsWhatAMessageCannotCarry) {
    const ChannelFrame frame = frame_of_microseconds({-4000, 4000, -4000, 4000});
    MavlinkDecoder radio({});
    MavlinkEncoder radio_encoder({.channels = 4});
    EXPECT_EQ(pulses_of(feed(radio, encoded(radio_encoder, frame)).at(0).channels),
              (std::vector<double>{860, 2140, 860, 2140}));
    MavlinkDecoder manual({});
    MavlinkEncoder manual_encoder({.message = MavlinkChannels::manual_control});
    EXPECT_EQ(pulses_of(feed(manual, encoded(manual_encoder, frame)).at(0).channels),
              (std::vector<double>{1000, 2000, 1000, 2000}));
}

TEST(MavlinkEncoder, GoesOnOverAReload) {
    const MavlinkEncoder::Settings settings{.message = MavlinkChannels::rc_channels_override};
    MavlinkEncoder before(settings);
    const ChannelFrame frame = frame_of_microseconds(kSixteenPulses);
    encoded(before, frame, kStart);
    MavlinkEncoder after(settings);
    after.continue_from(before);
    const Bytes bytes = encoded(after, frame, kStart + 20ms);
    EXPECT_EQ(bytes.size(), from_hex(kOverride).size());
    EXPECT_EQ(bytes.at(4), 2);
}

TEST(MavlinkEncoder, WritesNoFrameThatIsLongerThanItPromises) {
    ChannelFrame frame = frame_of_microseconds(std::vector<double>(18, 2000));
    frame.received = Instant{} + std::chrono::hours(800);
    frame.failsafe = true;
    for (const auto message :
         {MavlinkChannels::radio_rc_channels, MavlinkChannels::rc_channels_override,
          MavlinkChannels::manual_control}) {
        MavlinkEncoder encoder({.message = message, .channels = 18, .buttons = 14});
        EXPECT_LE(encoded(encoder, frame).size(), MavlinkEncoder::kLongest);
    }
    MavlinkEncoder longest({.channels = 18});
    EXPECT_EQ(encoded(longest, frame).size(), MavlinkEncoder::kLongest);
}

}  // namespace
}  // namespace tribus::test::mavlink_encoder_test
