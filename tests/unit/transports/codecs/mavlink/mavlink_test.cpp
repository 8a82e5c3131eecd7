#include "transports/codecs/mavlink/mavlink.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"

namespace tribus::test::mavlink_test {
namespace {

using namespace std::chrono_literals;

std::vector<DecodedFrame> read(const Bytes& bytes, const MavlinkDecoder::Settings& settings = {},
                               Instant at = {}) {
    MavlinkDecoder decoder(settings);
    return feed(decoder, bytes, kOneRead, at);
}

TEST(MavlinkDecoder, ReadsAnOverrideOfVersion2WhoseZerosAreCutOff) {
    const auto frames = read(from_hex(kOverride));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), kSixteenPulses);
    EXPECT_FALSE(frames[0].channels.has(16));
    EXPECT_FALSE(frames[0].channels.has(17));
    EXPECT_TRUE(frames[0].channels.good());
}

TEST(MavlinkDecoder, ReadsAnOverrideOfVersion1) {
    const auto frames = read(from_hex(kOverride1));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), kEightPulses);
}

TEST(MavlinkDecoder, ReadsNoChannelWhereAnOverrideReleasesAll) {
    const auto frames = read(from_hex(kReleaseAll));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_FALSE(frames[0].channels.has_any());
}

TEST(MavlinkDecoder, ReadsRadioChannelsAndTheirFlags) {
    for (const bool failsafe : {false, true}) {
        for (const bool outdated : {false, true}) {
            Bytes payload = from_hex("40e20100 0000 01 00 10 0000 0000 80f3 0000 800c");
            payload[4] = static_cast<std::uint8_t>((failsafe ? 1 : 0) | (outdated ? 2 : 0));
            const auto frames = read(message_2(420, 20, payload, {.system = 51}));
            ASSERT_EQ(frames.size(), 1U);
            const ChannelFrame& channels = frames[0].channels;
            EXPECT_EQ(channels.failsafe, failsafe);
            EXPECT_EQ(channels.frame_lost, outdated);
            std::vector<double> expected{1500, 1500, 1000, 1500, 2000};
            expected.resize(16, 1500);
            EXPECT_EQ(pulses_of(channels), expected);
        }
    }
    EXPECT_TRUE(read(from_hex(kRadioFailsafe)).at(0).channels.failsafe);
}

TEST(MavlinkDecoder, ReadsEveryStepOfARadioChannelToTheNextEighth) {
    MavlinkDecoder decoder({});
    for (int step = -32768; step <= 32767; ++step) {
        Bytes payload = from_hex("00000000 0000 01 00 01 0000");
        payload[9] = static_cast<std::uint8_t>(step);
        payload[10] = static_cast<std::uint8_t>(step >> 8);
        const auto frames = feed(decoder, message_2(420, 20, payload));
        ASSERT_EQ(frames.size(), 1U) << step;
        const double exact = 1500 + step * 5 / 32.0;
        const double limited = std::min(std::max(exact, -4096.0), 4095.875);
        ASSERT_NEAR(frames[0].channels.channel(0)->microseconds(), limited, 0.0625) << step;
    }
}

TEST(MavlinkDecoder, ReadsRcChannelsAsManyAsTheMessageSays) {
    const auto frames = read(from_hex(kRcChannelsOfAnAutopilot));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels), kSixteenPulses);
    EXPECT_FALSE(frames[0].channels.has(16));
}

TEST(MavlinkDecoder, ReadsEveryWordOfAPulseAndOthersAreNoChannel) {
    for (unsigned word = 0; word <= 0xFFFF; ++word) {
        Bytes payload(38);
        for (const std::size_t at : {0U, 18U}) {
            payload[at] = static_cast<std::uint8_t>(word);
            payload[at + 1] = static_cast<std::uint8_t>(word >> 8U);
        }
        MavlinkDecoder decoder({});
        const auto frames = feed(decoder, message_2(70, 124, payload));
        ASSERT_EQ(frames.size(), 1U) << word;
        const bool pulse = word >= 1 && word <= 4095;
        for (const std::size_t channel : {0U, 8U}) {
            ASSERT_EQ(frames[0].channels.has(channel), pulse) << word;
            if (pulse) {
                ASSERT_EQ(frames[0].channels.channel(channel)->microseconds(), word);
            }
        }
    }
}

TEST(MavlinkDecoder, ReadsManualControlWithPitchTheOtherWay) {
    const auto frames = read(from_hex(kManual), {.buttons = 3});
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_EQ(pulses_of(frames[0].channels),
              (std::vector<double>{1000, 1000, 1500, 1500, 2000, 2000, 1000}));
}

TEST(MavlinkDecoder, ReadsNoChannelFromAnAxisThatIsNotValid) {
    // INT16_MAX, -1001, 1001 and -1001.
    const Bytes payload = from_hex("ff7f 17fc e903 17fc 0000 01");
    for (const auto throttle : {MavlinkThrottle::zero_based, MavlinkThrottle::centred}) {
        const auto frames = read(message_2(69, 243, payload), {.throttle = throttle});
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_FALSE(frames[0].channels.has_any());
    }
}

/// The pulse of channel 3 of MANUAL_CONTROL with this z.
double throttle_of(int z, MavlinkThrottle throttle) {
    Bytes payload = from_hex("0000 0000 0000 0000 0000 01");
    payload[4] = static_cast<std::uint8_t>(z);
    payload[5] = static_cast<std::uint8_t>(z >> 8);
    return read(message_2(69, 243, payload), {.throttle = throttle})
        .at(0)
        .channels.channel(2)
        .value()
        .microseconds();
}

TEST(MavlinkDecoder, ReadsANegativeThrottleAsReverseOrAsStandstill) {
    for (int z = -1000; z <= 1000; ++z) {
        ASSERT_EQ(throttle_of(z, MavlinkThrottle::centred), 1500 + z / 2.0);
        ASSERT_EQ(throttle_of(z, MavlinkThrottle::zero_based), z < 0 ? 1000 : 1000 + z);
    }
}

/// SYS_STATUS that says whether a receiver is enabled and healthy.
/// MAV_SYS_STATUS_SENSOR_RC_RECEIVER is bit 16 of present, enabled and healthy.
Bytes status(std::uint8_t system, bool enabled, bool healthy, std::uint8_t component = 1) {
    Bytes payload(31);
    payload[2] = 1;
    payload[6] = enabled ? 1 : 0;
    payload[10] = healthy ? 1 : 0;
    payload[30] = 0xFF;
    return message_2(1, 124, payload, {.system = system, .component = component});
}

/// Whether RC_CHANNELS of system 1 says failsafe after another message.
bool failsafe_after(MavlinkDecoder& decoder, const Bytes& message) {
    feed(decoder, message);
    return feed(decoder, from_hex(kRcChannelsOfAnAutopilot)).at(0).channels.failsafe;
}

TEST(MavlinkDecoder, TakesTheReceiversHealthFromSysStatusOfTheAutopilotOnly) {
    // 154 is a gimbal, 191 a computer aboard; they know of no receiver.
    for (const std::uint8_t component : std::to_array<std::uint8_t>({0, 2, 154, 191, 255})) {
        MavlinkDecoder decoder({});
        EXPECT_FALSE(failsafe_after(decoder, status(1, true, false, component))) << component;
        EXPECT_TRUE(failsafe_after(decoder, status(1, true, false)));
        EXPECT_TRUE(failsafe_after(decoder, status(1, false, false, component))) << component;
        EXPECT_TRUE(failsafe_after(decoder, status(1, true, true, component))) << component;
        EXPECT_FALSE(failsafe_after(decoder, status(1, true, true)));
    }
}

TEST(MavlinkDecoder, TakesTheReceiversHealthFromSysStatusOfTheSameSystem) {
    MavlinkDecoder decoder({});
    const auto failsafe = [&](const Bytes& before) { return failsafe_after(decoder, before); };
    EXPECT_FALSE(failsafe({}));
    EXPECT_FALSE(failsafe(status(1, true, true)));
    EXPECT_TRUE(failsafe(status(1, true, false)));
    EXPECT_TRUE(failsafe(status(2, true, true)));
    EXPECT_FALSE(failsafe(status(1, false, false)));
    EXPECT_TRUE(failsafe(status(1, true, false)));
    EXPECT_FALSE(failsafe(status(1, true, true)));
}

TEST(MavlinkDecoder, PassesOverMessagesToAnotherSystem) {
    EXPECT_EQ(read(from_hex(kOverride), {.target = 2}).size(), 0U);
    EXPECT_EQ(read(from_hex(kManual), {.target = 2}).size(), 0U);
    EXPECT_EQ(read(from_hex(kRadioFailsafe), {.target = 2}).size(), 0U);
    EXPECT_EQ(read(from_hex(kRcChannelsOfAnAutopilot), {.target = 2}).size(), 1U);
    Bytes to_all(18, 1);
    to_all[16] = 0;
    EXPECT_EQ(read(message_2(70, 124, to_all), {.target = 2}).size(), 1U);
}

TEST(MavlinkDecoder, KeepsToTheFirstSenderUntilItIsSilentForASecond) {
    MavlinkDecoder decoder({});
    const Bytes first = message_2(70, 124, Bytes(18, 1), {.system = 255});
    const Bytes second = message_2(70, 124, Bytes(18, 1), {.system = 254});
    EXPECT_EQ(feed(decoder, first, kOneRead, Instant{}).size(), 1U);
    EXPECT_EQ(feed(decoder, second, kOneRead, Instant{} + 1ms).size(), 0U);
    EXPECT_EQ(feed(decoder, from_hex(kRcChannelsOfAnAutopilot), kOneRead, Instant{} + 2ms).size(),
              0U);
    EXPECT_EQ(feed(decoder, first, kOneRead, Instant{} + 500ms).size(), 1U);
    EXPECT_EQ(feed(decoder, second, kOneRead, Instant{} + 1499ms).size(), 0U);
    EXPECT_EQ(count_of(decoder, "other_sender"), 3U);
    EXPECT_EQ(feed(decoder, second, kOneRead, Instant{} + 1500ms).size(), 1U);
    EXPECT_EQ(feed(decoder, first, kOneRead, Instant{} + 1501ms).size(), 0U);
}

TEST(MavlinkDecoder, TakesTwoComponentsOfASystemForTwoSenders) {
    // Two ground stations with the usual system id.
    const Bytes one = message_2(70, 124, Bytes(18, 1), {.system = 255, .component = 190});
    const Bytes other = message_2(70, 124, Bytes(18, 1), {.system = 255, .component = 191});
    for (const std::optional<std::uint8_t> system : {std::optional<std::uint8_t>(), {255}}) {
        MavlinkDecoder decoder({.system = system, .target = 1});
        EXPECT_EQ(feed(decoder, one, kOneRead, Instant{}).size(), 1U);
        EXPECT_EQ(feed(decoder, other, kOneRead, Instant{} + 20ms).size(), 0U);
        EXPECT_EQ(count_of(decoder, "other_sender"), 1U);
        EXPECT_EQ(feed(decoder, one, kOneRead, Instant{} + 40ms).size(), 1U);
    }
}

TEST(MavlinkDecoder, TakesRcChannelsOfTheAutopilotOnly) {
    MavlinkDecoder decoder({});
    EXPECT_EQ(feed(decoder, rc_channels_message(kSixteenPulses, {.component = 154})).size(), 0U);
    EXPECT_EQ(count_of(decoder, "other_sender"), 1U);
    EXPECT_EQ(feed(decoder, rc_channels_message(kSixteenPulses)).size(), 1U);
}

TEST(MavlinkDecoder, TakesOnlyTheSystemAndTheMessageThatWereConfigured) {
    const Bytes foreign = message_2(70, 124, Bytes(18, 1), {.system = 7});
    MavlinkDecoder decoder({.message = MavlinkChannels::rc_channels_override, .system = 255});
    EXPECT_EQ(feed(decoder, foreign).size(), 0U);
    EXPECT_EQ(count_of(decoder, "other_sender"), 1U);
    EXPECT_EQ(feed(decoder, from_hex(kRcChannelsOfAnAutopilot)).size(), 0U);
    EXPECT_EQ(feed(decoder, from_hex(kOverride)).size(), 1U);
}

TEST(MavlinkDecoder, SaysWhichSystemSent) {
    MavlinkDecoder decoder({});
    feed(decoder, from_hex(kRadioFailsafe));
    ASSERT_EQ(decoder.details().size(), 1U);
    EXPECT_EQ(decoder.details()[0].name, "system");
    EXPECT_EQ(decoder.details()[0].values[0], 51);
}

TEST(MavlinkDecoder, RefusesEachFlippedBit) {
    for (const std::string_view hex : {kOverride, kOverride1, kManual, kRcChannelsOfAnAutopilot}) {
        const Bytes good = from_hex(hex);
        for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
            Bytes bytes = good;
            bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
            MavlinkDecoder decoder({});
            ASSERT_TRUE(all_frames(decoder, bytes).empty()) << hex << ", bit " << bit;
        }
    }
}

TEST(MavlinkDecoder, PassesOverASignatureAndRefusesFlagsThatItDoesNotKnow) {
    for (unsigned flags = 0; flags <= 0xFF; ++flags) {
        const Bytes bytes =
            message_2(70, 124, Bytes(18, 1), {.flags = static_cast<std::uint8_t>(flags)});
        EXPECT_EQ(read(bytes).size(), flags <= 1 ? 1U : 0U) << flags;
    }
}

TEST(MavlinkDecoder, FindsNoMessageInsideOfAnotherOneWhateverItsLength) {
    // A log that is sent over the line can have whole messages in it. FILE_TRANSFER_PROTOCOL is
    // 110; its check is not known here.
    const Bytes inner = from_hex(kOverride);
    for (std::size_t length = inner.size(); length <= 255; ++length) {
        Bytes payload(length, 0xFE);
        std::copy(inner.begin(), inner.end(),
                  payload.end() - static_cast<std::ptrdiff_t>(inner.size()));
        Bytes line = message_2(110, 84, payload);
        append(line, from_hex(kRcChannelsOfAnAutopilot));
        for (const Split split : {kOneRead, kByteByByte, Split{.longest = 40, .seed = 3}}) {
            MavlinkDecoder decoder({});
            const auto frames = feed(decoder, line, split);
            ASSERT_EQ(frames.size(), 1U) << length;
            EXPECT_EQ(frames[0].first_byte,
                      line.size() - from_hex(kRcChannelsOfAnAutopilot).size());
            EXPECT_EQ(decoder.skipped_bytes(), 0U);
        }
    }
}

TEST(MavlinkDecoder, FindsAFrameAtOnceBehindALongMessageThatAPauseOrADamagedByteCutsOff) {
    const Bytes whole = message_2(110, 84, Bytes(250, 0x55));
    for (const std::size_t left : {3U, 100U, 200U}) {
        const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(left));
        MavlinkDecoder paused({});
        feed(paused, cut);
        DecodedFrame frame;
        EXPECT_FALSE(paused.silence(frame));
        EXPECT_EQ(feed(paused, from_hex(kOverride)).size(), 1U) << left;
        MavlinkDecoder damaged({});
        feed(damaged, cut);
        damaged.damaged_byte();
        EXPECT_EQ(feed(damaged, from_hex(kOverride)).size(), 1U) << left;
    }
}

TEST(MavlinkDecoder, FindsAFrameBehindGarbageThatBeginsAsAMessageOfAnyLength) {
    for (const unsigned magic : {0xFEU, 0xFDU}) {
        for (unsigned length = 0; length <= 0xFF; ++length) {
            Bytes line{static_cast<std::uint8_t>(magic), static_cast<std::uint8_t>(length), 0};
            for (int i = 0; i < 8; ++i) {
                append(line, from_hex(kOverride));
            }
            // The longest message has 280 bytes: six of eight frames at most.
            EXPECT_GE(read(line).size(), 2U) << length;
        }
    }
}

}  // namespace
}  // namespace tribus::test::mavlink_test
