#include "transports/codecs/dronecan/actuators.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "tests/support/dronecan_frames.h"

namespace tribus::dronecan::actuators_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

constexpr NodeId kAutopilot = 10;

std::optional<ChannelFrame> decoded(CommandDecoder& decoder, const std::vector<CanFrame>& frames,
                                    Instant at = kStart) {
    std::optional<ChannelFrame> latest;
    for (const CanFrame& frame : frames) {
        if (const auto snapshot = decoder.next(frame, at)) {
            latest = snapshot;
        }
    }
    return latest;
}

ArrayCommand commands_of(std::initializer_list<ActuatorCommand> commands) {
    ArrayCommand message;
    for (const ActuatorCommand& command : commands) {
        message.commands.push_back(command);
    }
    return message;
}

ActuatorCommand unitless(std::uint8_t actuator, float value) {
    return {.actuator_id = actuator,
            .command_type = ActuatorCommand::kUnitless,
            .command_value = value};
}

std::vector<CanFrame> safety(std::uint8_t status, std::uint8_t transfer_id,
                             NodeId source = kAutopilot) {
    SafetyState message;
    message.status = status;
    return frames_of_message(message, source, transfer_id);
}

std::vector<CanFrame> arming(std::uint8_t status, std::uint8_t transfer_id) {
    ArmingStatus message;
    message.status = status;
    return frames_of_message(message, kAutopilot, transfer_id);
}

TEST(ServoCommands, AreReadAsInTheWorkedExample) {
    CommandDecoder decoder({});
    // docs/protocols/can.md, "DroneCAN: worked examples", example 3: 0.0, -1.0, +1.0 and +0.5 for
    // the actuators 1 to 4.
    const auto snapshot = decoded(
        decoder, frames_from(0x0803F20A, {"61B7010000000282", "0000BC0300003C22", "0400003842"}));
    ASSERT_TRUE(snapshot);
    EXPECT_TRUE(snapshot->good());
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1500));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(2), Pulse::from_microseconds(2000));
    EXPECT_EQ(snapshot->channel(3), Pulse::from_microseconds(1750));
    EXPECT_FALSE(snapshot->has(4));
}

TEST(ServoCommands, AreTakenAsPulsesWhereTheySaySo) {
    CommandDecoder decoder({});
    const auto snapshot =
        decoded(decoder, frames_of_message(commands_of({{.actuator_id = 1,
                                                         .command_type = ActuatorCommand::kPwm,
                                                         .command_value = 1234}}),
                                           kAutopilot, 0));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1234));
}

TEST(ServoCommands, ForPositionForceOrSpeedMoveNothing) {
    for (const std::uint8_t type :
         {ActuatorCommand::kPosition, ActuatorCommand::kForce, ActuatorCommand::kSpeed}) {
        CommandDecoder decoder({});
        EXPECT_FALSE(decoded(
            decoder, frames_of_message(commands_of({{.actuator_id = 1, .command_type = type}}),
                                       kAutopilot, 0)));
        EXPECT_EQ(count_named(decoder.rejected(), "layout"), 1U);
    }
}

/// Infinity is no value in DBC signals either.
TEST(ServoCommands, ThatAreNoNumberMoveNothing) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (const float none : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity}) {
        CommandDecoder decoder({});
        EXPECT_FALSE(
            decoded(decoder, frames_of_message(commands_of({unitless(1, none)}), kAutopilot, 0)))
            << none;
    }
}

TEST(ServoCommands, BeyondTheirRangeStopAtItsEnds) {
    CommandDecoder decoder({});
    const auto snapshot = decoded(
        decoder, frames_of_message(commands_of({unitless(1, 7), unitless(2, -7)}), kAutopilot, 0));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(2000));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(1000));
}

TEST(ServoCommands, CountFromTheFirstActuatorThatIsAskedFor) {
    CommandDecoder decoder({.first = 5, .channels = 2});
    const auto snapshot = decoded(
        decoder, frames_of_message(
                     commands_of({unitless(4, 1), unitless(5, 0), unitless(6, 1), unitless(7, 1)}),
                     kAutopilot, 0));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1500));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(2000));
    EXPECT_FALSE(snapshot->has(2));
}

TEST(ServoCommands, InSeveralMessagesAreOneSnapshotAsOldAsItsOldestCommand) {
    CommandDecoder decoder({});
    decoded(decoder, frames_of_message(commands_of({unitless(1, 0)}), kAutopilot, 0));
    const auto both =
        decoded(decoder, frames_of_message(commands_of({unitless(2, 0)}), kAutopilot, 1),
                kStart + milliseconds(5));
    ASSERT_TRUE(both);
    EXPECT_TRUE(both->has_first(2));
    EXPECT_EQ(both->received, kStart);
}

TEST(ServoCommands, ForAnActuatorThatIsCommandedNoLongerGrowOld) {
    CommandDecoder decoder({});
    decoded(decoder,
            frames_of_message(commands_of({unitless(1, 0), unitless(2, 0)}), kAutopilot, 0));
    for (int i = 1; i <= 200; ++i) {
        const auto snapshot = decoded(decoder,
                                      frames_of_message(commands_of({unitless(1, 0)}), kAutopilot,
                                                        static_cast<std::uint8_t>(i % 32)),
                                      kStart + i * milliseconds(20));
        ASSERT_TRUE(snapshot);
        EXPECT_EQ(snapshot->received, kStart);
    }
}

TEST(ServoCommands, AreThoseThatAVehicleHasNowAfterItBeganAnew) {
    CommandDecoder decoder({});
    decoded(decoder,
            frames_of_message(commands_of({unitless(1, 0), unitless(2, 0)}), kAutopilot, 0));
    const auto snapshot =
        decoded(decoder, frames_of_message(commands_of({unitless(1, 0)}), kAutopilot, 1),
                kStart + milliseconds(1001));
    ASSERT_TRUE(snapshot);
    EXPECT_FALSE(snapshot->has(1));
    EXPECT_EQ(snapshot->received, kStart + milliseconds(1001));
}

/// Returns whether a command is failsafe that comes `ago` after the vehicle's last safety state.
bool in_failsafe(SafetyRule rule, std::optional<std::uint8_t> said, Duration ago = {},
                 NodeId source = kAutopilot) {
    CommandDecoder decoder({.safety = rule});
    const auto command = commands_of({unitless(1, 0)});
    decoded(decoder, frames_of_message(command, kAutopilot, 0));
    if (said) {
        decoded(decoder, safety(*said, 0, source));
    }
    return decoded(decoder, frames_of_message(command, kAutopilot, 1), kStart + ago)->failsafe;
}

TEST(ServoCommands, FromAVehicleThatSaysThatItIsSafeAreFailsafe) {
    EXPECT_TRUE(in_failsafe(SafetyRule::heard, SafetyState::kSafetyOn));
    EXPECT_FALSE(in_failsafe(SafetyRule::heard, SafetyState::kSafetyOff));
    EXPECT_FALSE(in_failsafe(SafetyRule::heard, std::nullopt));
    EXPECT_TRUE(in_failsafe(SafetyRule::required, SafetyState::kSafetyOn));
    EXPECT_FALSE(in_failsafe(SafetyRule::required, SafetyState::kSafetyOff));
    EXPECT_TRUE(in_failsafe(SafetyRule::required, std::nullopt));
    EXPECT_FALSE(in_failsafe(SafetyRule::ignored, SafetyState::kSafetyOn));
}

TEST(ServoCommands, ForgetWhatTheVehicleSaidOfItsSafetyAfterThreeSeconds) {
    EXPECT_FALSE(in_failsafe(SafetyRule::required, SafetyState::kSafetyOff, milliseconds(3000)));
    EXPECT_TRUE(in_failsafe(SafetyRule::required, SafetyState::kSafetyOff, milliseconds(3001)));
}

TEST(ServoCommands, DoNotCareWhatAnotherNodeSaysOfItsSafety) {
    EXPECT_FALSE(in_failsafe(SafetyRule::heard, SafetyState::kSafetyOn, {}, 11));
}

TEST(ServoCommands, DoNotCareForArmingSinceSurfacesMoveOnTheGround) {
    CommandDecoder decoder({});
    const auto command = commands_of({unitless(1, 0)});
    decoded(decoder, frames_of_message(command, kAutopilot, 0));
    decoded(decoder, arming(ArmingStatus::kDisarmed, 0));
    EXPECT_FALSE(decoded(decoder, frames_of_message(command, kAutopilot, 1))->failsafe);
}

EscRawCommand throttles(std::initializer_list<std::int16_t> values) {
    EscRawCommand message;
    for (const std::int16_t value : values) {
        message.cmd.push_back(value);
    }
    return message;
}

TEST(MotorCommands, AreReadAsInTheWorkedExample) {
    CommandDecoder decoder({.kind = CommandKind::motors, .first = 0});
    // docs/protocols/can.md, "DroneCAN: worked examples", example 4: 0, 8191, -8192, 4096.
    const auto snapshot = decoded(decoder, frames_from(0x0804060A, {"0003FDF0080010C9"}));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(2000));
    EXPECT_EQ(snapshot->channel(2), Pulse::from_microseconds(1000));
    EXPECT_EQ(snapshot->channel(3)->whole_microseconds(), 1500);
}

TEST(MotorCommands, TurnBackwardsWhereTheyMay) {
    CommandDecoder decoder({.kind = CommandKind::motors, .first = 0, .reversible = true});
    const auto snapshot =
        decoded(decoder, frames_of_message(throttles({0, 8191, -8192}), kAutopilot, 0));
    ASSERT_TRUE(snapshot);
    EXPECT_EQ(snapshot->channel(0), Pulse::from_microseconds(1500));
    EXPECT_EQ(snapshot->channel(1), Pulse::from_microseconds(2000));
    EXPECT_EQ(snapshot->channel(2), Pulse::from_microseconds(1000));
}

TEST(MotorCommands, FromAVehicleThatSaysThatItIsDisarmedAreFailsafe) {
    CommandDecoder decoder({.kind = CommandKind::motors, .first = 0});
    decoded(decoder, frames_of_message(throttles({100}), kAutopilot, 0));
    decoded(decoder, arming(ArmingStatus::kDisarmed, 0));
    EXPECT_TRUE(decoded(decoder, frames_of_message(throttles({100}), kAutopilot, 1))->failsafe);
    decoded(decoder, arming(ArmingStatus::kFullyArmed, 1));
    EXPECT_FALSE(decoded(decoder, frames_of_message(throttles({100}), kAutopilot, 2))->failsafe);
}

constexpr NodeIdentity kIdentity{42};

std::vector<CanFrame> encoded(CommandEncoder& encoder, const ChannelFrame& snapshot,
                              Instant at = kStart) {
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    const std::size_t count = encoder.write(snapshot, frames, at);
    return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
}

ChannelFrame pulses(std::initializer_list<int> microseconds) {
    ChannelFrame snapshot;
    std::size_t channel = 0;
    for (const int pulse : microseconds) {
        snapshot.set(channel++, Pulse::from_microseconds(pulse));
    }
    snapshot.frame_lost = snapshot.failsafe = false;
    return snapshot;
}

TEST(ServoOutput, WritesTheBytesOfTheWorkedExample) {
    CommandEncoder encoder({});
    constexpr NodeIdentity kTen{10};
    encoder.send_as(kTen);
    const auto snapshot = pulses({1500, 1000, 2000, 1750});
    encoded(encoder, snapshot);
    encoded(encoder, snapshot);
    EXPECT_EQ(encoded(encoder, snapshot),
              frames_from(0x0803F20A, {"61B7010000000282", "0000BC0300003C22", "0400003842"}));
}

TEST(ServoOutput, WritesPulsesWhereItIsToldTo) {
    CommandEncoder encoder({.first = 7, .channels = 1, .pulses = true});
    encoder.send_as(kIdentity);
    const auto message = message_of_frames<ArrayCommand>(encoded(encoder, pulses({1500})));
    ASSERT_EQ(message.commands.size(), 1U);
    EXPECT_EQ(message.commands[0],
              (ActuatorCommand{
                  .actuator_id = 7, .command_type = ActuatorCommand::kPwm, .command_value = 1500}));
}

TEST(ServoOutput, LeavesOutAbsentChannels) {
    CommandEncoder encoder({});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = pulses({1500, 1500, 1500, 1500});
    snapshot.remove(1);
    const auto message = message_of_frames<ArrayCommand>(encoded(encoder, snapshot));
    ASSERT_EQ(message.commands.size(), 3U);
    EXPECT_EQ(message.commands[1].actuator_id, 3);
}

TEST(MotorOutput, WritesTheBytesOfTheWorkedExample) {
    CommandEncoder encoder({.kind = CommandKind::motors, .first = 0, .reversible = true});
    constexpr NodeIdentity kTen{10};
    encoder.send_as(kTen);
    ChannelFrame snapshot = pulses({1500, 2000, 900, 1750});
    for (int before = 0; before < 9; ++before) {
        encoded(encoder, snapshot);
    }
    // docs/protocols/can.md, "DroneCAN: worked examples", example 4, whose priority is 8. -8192 is
    // beyond full reverse.
    auto expected = frames_from(0x0704060A, {"0003FDF0080010C9"});
    EXPECT_EQ(encoded(encoder, snapshot), expected);
}

TEST(MotorOutput, CommandsStandstillToAbsentChannelsAndToThoseBeforeTheFirst) {
    CommandEncoder encoder({.kind = CommandKind::motors, .first = 1, .channels = 2});
    encoder.send_as(kIdentity);
    ChannelFrame snapshot = pulses({1500, 2000});
    snapshot.remove(0);
    EXPECT_EQ(message_of_frames<EscRawCommand>(encoded(encoder, snapshot)),
              throttles({0, 0, 8191}));
}

TEST(MotorOutput, NeverTurnsBackwardsUnlessItMay) {
    CommandEncoder encoder({.kind = CommandKind::motors, .first = 0, .channels = 1});
    encoder.send_as(kIdentity);
    EXPECT_EQ(message_of_frames<EscRawCommand>(encoded(encoder, pulses({900}))), throttles({0}));
}

TEST(ArmingOutput, TellsNobodyToMoveBeforeAnInputHadControl) {
    CommandEncoder encoder({.channels = 1, .arms = true});
    encoder.send_as(kIdentity);
    ChannelFrame failsafe = pulses({1500});
    failsafe.failsafe = true;
    EXPECT_EQ(encoded(encoder, failsafe).size(), 1U);
    const auto frames = encoded(encoder, pulses({1500}));
    ASSERT_EQ(frames.size(), 2U);
    EXPECT_EQ(message_of_frames<SafetyState>(std::span(frames).last(1)).status,
              SafetyState::kSafetyOff);
}

TEST(ArmingOutput, SaysItFiveTimesASecondAndNotWithEachCommand) {
    CommandEncoder encoder({.channels = 1, .arms = true});
    encoder.send_as(kIdentity);
    int said = 0;
    for (int i = 0; i < 100; ++i) {
        said += encoded(encoder, pulses({1500}), kStart + i * milliseconds(10)).size() > 1 ? 1 : 0;
    }
    EXPECT_EQ(said, 5);
}

TEST(ArmingOutput, DisarmsMotorsInFailsafe) {
    CommandEncoder encoder({.kind = CommandKind::motors, .first = 0, .channels = 1, .arms = true});
    encoder.send_as(kIdentity);
    const auto armed = encoded(encoder, pulses({1200}));
    ASSERT_EQ(armed.size(), 3U);
    EXPECT_EQ(message_of_frames<ArmingStatus>(std::span(armed).last(1)).status,
              ArmingStatus::kFullyArmed);
    ChannelFrame failsafe = pulses({1000});
    failsafe.failsafe = true;
    const auto disarmed = encoded(encoder, failsafe, kStart + milliseconds(200));
    ASSERT_EQ(disarmed.size(), 3U);
    EXPECT_EQ(message_of_frames<ArmingStatus>(std::span(disarmed).last(1)).status,
              ArmingStatus::kDisarmed);
}

/// The new encoder sends the same frames as the old one would: transfer ids, times of permissions,
/// and disarmed motors because the output was in control once.
TEST(ActuatorOutput, GoesOnWhereAnotherConfigurationTakesOver) {
    const CommandOutputFormat format{
        .kind = CommandKind::motors, .first = 0, .channels = 1, .arms = true};
    CommandEncoder before(format);
    CommandEncoder next(format);
    before.send_as(kIdentity);
    next.send_as(kIdentity);
    encoded(before, pulses({1200}));
    next.continue_from(before);
    ChannelFrame failsafe = pulses({1000});
    failsafe.failsafe = true;
    for (auto since = milliseconds(100); since <= milliseconds(400); since += milliseconds(100)) {
        EXPECT_EQ(encoded(next, failsafe, kStart + since),
                  encoded(before, failsafe, kStart + since))
            << since.count() << " ms after the reload";
    }
}

TEST(ActuatorOutput, SaysNothingInTheNameOfNobody) {
    CommandEncoder encoder({});
    EXPECT_TRUE(encoded(encoder, pulses({1500})).empty());
}

}  // namespace
}  // namespace tribus::dronecan::actuators_test
