#include "transports/codecs/mavlink/answers.h"

#include <chrono>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/mavlink.h"

/// What an output hears of the autopilot that it steers.
namespace tribus::test::mavlink_answers_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};

const MavlinkEncoder::Settings kOverrides{.message = MavlinkChannels::rc_channels_override};

/// Whether the answers of an encoder that sent kSixteenPulses show an effect.
bool shows_effect(const MavlinkEncoder::Settings& settings, const Bytes& answer) {
    MavlinkEncoder encoder(settings);
    encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart);
    encoder.hear(answer, kStart);
    return encoder.answers().effect;
}

std::vector<double> with_channel(std::size_t channel, double pulse) {
    std::vector<double> pulses = kSixteenPulses;
    pulses[channel] = pulse;
    return pulses;
}

TEST(MavlinkAnswers, CountTheHeartbeatsOfTheAutopilotThatIsSteered) {
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override, .target = 7});
    encoder.hear(heartbeat_message({.system = 7}), kStart);
    encoder.hear(heartbeat_message({.system = 7}), kStart);
    for (const MessageHead& other :
         {MessageHead{.system = 1}, MessageHead{.system = 255}, {.system = 7, .component = 154}}) {
        encoder.hear(heartbeat_message(other), kStart);
    }
    EXPECT_EQ(encoder.answers().heard, 2U);
    EXPECT_FALSE(encoder.answers().effect);
}

TEST(MavlinkAnswers, ShowAnEffectWhereTheChannelsAreThoseThatWereSent) {
    for (const auto message :
         {MavlinkChannels::rc_channels_override, MavlinkChannels::radio_rc_channels}) {
        const MavlinkEncoder::Settings settings{.message = message};
        EXPECT_TRUE(shows_effect(settings, rc_channels_message(kSixteenPulses)));
        for (std::size_t channel = 0; channel < 16; ++channel) {
            const double sent = kSixteenPulses[channel];
            EXPECT_TRUE(
                shows_effect(settings, rc_channels_message(with_channel(channel, sent + 2))));
            EXPECT_FALSE(
                shows_effect(settings, rc_channels_message(with_channel(channel, sent + 3))));
            EXPECT_FALSE(
                shows_effect(settings, rc_channels_message(with_channel(channel, sent - 3))));
        }
    }
}

TEST(MavlinkAnswers, ShowAnEffectOnlyOfTheAutopilotWithAllChannels) {
    EXPECT_FALSE(shows_effect(kOverrides, rc_channels_message(kSixteenPulses, {.system = 2})));
    EXPECT_FALSE(shows_effect(kOverrides, rc_channels_message(kSixteenPulses, {.component = 2})));
    EXPECT_FALSE(shows_effect(kOverrides, rc_channels_message({1500, 1500, 1000, 1500})));
    EXPECT_FALSE(shows_effect(kOverrides, rc_channels_message({})));
    EXPECT_FALSE(shows_effect(kOverrides, heartbeat_message()));
}

TEST(MavlinkAnswers, ShowNoEffectOfWhatWasNotSentYet) {
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override, .channels = 1});
    encoder.hear(rc_channels_message({0}), kStart);
    EXPECT_FALSE(encoder.answers().effect);
}

TEST(MavlinkAnswers, ComeLateWhileSticksMove) {
    for (const auto& [later, effect] : {std::pair{31, true}, std::pair{32, false}}) {
        MavlinkEncoder encoder(kOverrides);
        for (int i = 0; i <= later; ++i) {
            encoded(encoder, frame_of_microseconds(with_channel(0, 1100 + 10 * i)),
                    kStart + i * 20ms);
        }
        encoder.hear(rc_channels_message(with_channel(0, 1100)), kStart + later * 20ms);
        EXPECT_EQ(encoder.answers().effect, effect);
    }
}

TEST(MavlinkAnswers, StayTrueOnceAnEffectWasShown) {
    MavlinkEncoder encoder(kOverrides);
    encoded(encoder, frame_of_microseconds(kSixteenPulses), kStart);
    encoder.hear(rc_channels_message(kSixteenPulses), kStart);
    encoder.hear(rc_channels_message(with_channel(0, 1700)), kStart);
    EXPECT_TRUE(encoder.answers().effect);
}

TEST(MavlinkAnswers, GoOnOverAReloadThatLooksForTheSame) {
    MavlinkEncoder before(kOverrides);
    encoded(before, frame_of_microseconds(kSixteenPulses), kStart);
    before.hear(heartbeat_message(), kStart);
    before.hear(rc_channels_message(kSixteenPulses), kStart);
    MavlinkEncoder same(kOverrides);
    same.continue_from(before);
    EXPECT_TRUE(same.answers().effect);
    EXPECT_EQ(same.answers().heard, 1U);
    MavlinkEncoder other({.message = MavlinkChannels::rc_channels_override, .system = 254});
    other.continue_from(before);
    EXPECT_FALSE(other.answers().effect);
    EXPECT_EQ(other.answers().heard, 0U);
}

TEST(MavlinkAnswers, TellNothingOfManualControl) {
    EXPECT_FALSE(shows_effect({.message = MavlinkChannels::manual_control},
                              rc_channels_message(kSixteenPulses)));
    SettingValues settings;
    settings.set("message", std::string("manual_control"));
    EXPECT_EQ(kMavlinkProtocol.advice_without_effect(settings), "");
}

TEST(MavlinkAnswers, AdviceNamesTheSystemsAndWhatToCheck) {
    SettingValues settings;
    settings.set("message", std::string("rc_channels_override"));
    settings.set("system", std::int64_t{250});
    settings.set("target", std::int64_t{3});
    EXPECT_EQ(kMavlinkProtocol.advice_without_effect(settings),
              "autopilot 3 answers, but none of its RC_CHANNELS has these channels; it takes "
              "overrides only from its ground station: its MAV_GCS_SYSID (before 4.7 SYSID_MYGCS) "
              "must be 250, the `system` of this output; and it must send RC_CHANNELS "
              "(SRn_RC_CHAN 2 or more)");
    settings.set("key", KeyFile{"drone.key", {1}});
    EXPECT_NE(kMavlinkProtocol.advice_without_effect(settings).find("have the same key"),
              std::string::npos);
    EXPECT_EQ(kMavlinkProtocol.advice_without_effect({}),
              "autopilot 1 answers, but none of its RC_CHANNELS has these channels; it must read "
              "RADIO_RC_CHANNELS (ArduPilot 4.6 and newer); and it must send RC_CHANNELS "
              "(SRn_RC_CHAN 2 or more)");
}

}  // namespace
}  // namespace tribus::test::mavlink_answers_test
