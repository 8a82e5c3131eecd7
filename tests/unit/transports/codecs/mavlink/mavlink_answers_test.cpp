#include "transports/codecs/mavlink/answers.h"

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
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

TEST(MavlinkAnswers, CountTheHeartbeatsOfOtherAutopilotsApart) {
    MavlinkEncoder encoder({.message = MavlinkChannels::rc_channels_override, .target = 7});
    encoder.hear(heartbeat_message({.system = 4}), kStart);
    encoder.hear(heartbeat_message({.system = 5}), kStart);
    // A gimbal, and a ground station, which is no autopilot (MAV_AUTOPILOT_INVALID).
    encoder.hear(heartbeat_message({.system = 6, .component = 154}), kStart);
    encoder.hear(heartbeat_message({.system = 8}, 6, 8), kStart);
    EXPECT_EQ(encoder.answers().heard, 0U);
    EXPECT_EQ(encoder.answers().heard_others, 2U);
    EXPECT_EQ(encoder.answers().other, 5);
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

/// RC_CHANNELS that shows `pulses` and says that its receiver has `count` channels.
Bytes with_count(const std::vector<double>& pulses, std::uint8_t count, unsigned unused) {
    Bytes payload(42);
    for (std::size_t i = 0; i < 18; ++i) {
        const auto word = i < pulses.size() ? static_cast<unsigned>(pulses[i]) : unused;
        payload[4 + 2 * i] = static_cast<std::uint8_t>(word);
        payload[5 + 2 * i] = static_cast<std::uint8_t>(word >> 8U);
    }
    payload[40] = count;
    payload[41] = 255;
    return message_2(65, 118, payload);
}

TEST(MavlinkAnswers, ShowAnEffectWhateverTheReceiverOfTheAutopilotHas) {
    // ArduPilot: chancount is that of its receiver, and all channels are shown.
    for (const unsigned count : {0U, 8U, 16U, 18U}) {
        EXPECT_TRUE(shows_effect(kOverrides,
                                 with_count(kSixteenPulses, static_cast<std::uint8_t>(count), 0)));
    }
    // Only the receiver's channels are shown.
    for (const unsigned unused : {0U, 65535U}) {
        EXPECT_TRUE(shows_effect(kOverrides, with_count(kEightPulses, 8, unused)));
        EXPECT_FALSE(shows_effect(kOverrides, with_count({1500, 1500, 1000, 1500}, 4, unused)));
        EXPECT_FALSE(shows_effect(kOverrides, with_count(kEightPulses, 16, unused)));
        EXPECT_FALSE(shows_effect(kOverrides, with_count({}, 0, unused)));
    }
    EXPECT_FALSE(shows_effect(kOverrides, with_count(with_channel(15, 1900), 8, 0)));
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
    EXPECT_EQ(kMavlinkProtocol.advice_by_answers(settings, {.heard = 100}), "");
}

std::string advice(const SettingValues& settings, const Answers& answers) {
    return kMavlinkProtocol.advice_by_answers(settings, answers);
}

TEST(MavlinkAnswers, AdviceNamesTheSystemsAndWhatToCheck) {
    constexpr Answers kNoEffect{.heard = 10};
    SettingValues settings;
    settings.set("message", std::string("rc_channels_override"));
    settings.set("system", std::int64_t{250});
    settings.set("target", std::int64_t{3});
    EXPECT_EQ(advice(settings, kNoEffect),
              "autopilot 3 answers, but none of its RC_CHANNELS has these channels; it takes "
              "overrides only from its ground station: its MAV_GCS_SYSID (before 4.7 SYSID_MYGCS) "
              "must be 250, the `system` of this output; and it must send RC_CHANNELS "
              "(SRn_RC_CHAN 2 or more)");
    settings.set("key", KeyFile{"drone.key", {1}});
    EXPECT_NE(advice(settings, kNoEffect).find("have the same key"), std::string::npos);
    EXPECT_EQ(advice({}, kNoEffect),
              "autopilot 1 answers, but none of its RC_CHANNELS has these channels; it must read "
              "RADIO_RC_CHANNELS (ArduPilot 4.6 and newer); and it must send RC_CHANNELS "
              "(SRn_RC_CHAN 2 or more)");
    EXPECT_EQ(advice({}, {.heard = 9}), "");
    EXPECT_EQ(advice({}, {.heard = 10, .effect = true}), "");
}

TEST(MavlinkAnswers, AdviceSaysThatTheTargetIsWrong) {
    constexpr std::string_view kWrong =
        "autopilot 2 answers, and none with system id 1, the `target` of this output; set target "
        "to the id of the autopilot, its MAV_SYSID (before 4.7 SYSID_THISMAV)";
    for (const char* const message :
         {"radio_rc_channels", "rc_channels_override", "manual_control"}) {
        SettingValues settings;
        settings.set("message", std::string(message));
        EXPECT_EQ(advice(settings, {.heard_others = 10, .other = 2}), kWrong);
        EXPECT_EQ(advice(settings, {.heard_others = 9, .other = 2}), "");
        EXPECT_EQ(advice(settings, {.heard = 1, .heard_others = 100, .other = 2}), "");
    }
}

/// The advice of an output with MANUAL_CONTROL after the first HEARTBEAT.
std::string throttle_advice(const std::string& throttle, std::uint8_t vehicle,
                            std::uint8_t autopilot, const std::string& message = "manual_control") {
    SettingValues settings;
    settings.set("message", message);
    if (!throttle.empty()) {
        settings.set("throttle", throttle);
    }
    const AnyEncoder made = kMavlinkProtocol.make_encoder(settings);
    auto& encoder = *std::get<std::unique_ptr<ByteEncoder>>(made);
    encoder.hear(heartbeat_message({}, vehicle, autopilot), kStart);
    return advice(settings, encoder.answers());
}

TEST(MavlinkAnswers, AdviceSaysHowTheThrottleOfTheVehicleCounts) {
    // MAV_TYPE: 2 quadrotor, 10 ground rover, 11 surface boat, 12 submarine. MAV_AUTOPILOT: 3
    // ArduPilot, 12 PX4, which takes 0 to 1000 always.
    for (const std::string& zero_based : {std::string(), std::string("zero based")}) {
        EXPECT_EQ(throttle_advice(zero_based, 10, 3),
                  "autopilot 1 is a rover with ArduPilot: a centred stick is half throttle there, "
                  "and reverse cannot be reached; set throttle = \"centred\"");
        EXPECT_NE(throttle_advice(zero_based, 11, 3).find("is a boat with ArduPilot"),
                  std::string::npos);
        for (const std::uint8_t vehicle : std::to_array<std::uint8_t>({1, 2, 12})) {
            EXPECT_EQ(throttle_advice(zero_based, vehicle, 3), "");
        }
        EXPECT_EQ(throttle_advice(zero_based, 10, 12), "");
    }
    EXPECT_EQ(throttle_advice("centred", 10, 3), "");
    EXPECT_EQ(throttle_advice("centred", 11, 3), "");
    EXPECT_EQ(throttle_advice("centred", 2, 3),
              "autopilot 1 is no rover or boat with ArduPilot, and takes no throttle below the "
              "centre; set throttle = \"zero based\"");
    EXPECT_NE(throttle_advice("centred", 10, 12), "");
    EXPECT_EQ(throttle_advice("", 10, 3, "rc_channels_override"), "");
}

}  // namespace
}  // namespace tribus::test::mavlink_answers_test
