#include "pipelines/sensor_bus/sensor_role.h"

#include <gtest/gtest.h>

#include <span>
#include <utility>

#include "tests/unit/pipelines/sensor_bus/sensor_bus_bench.h"

namespace tribus::test::sensor_bus::sensor_role_test {
namespace {

constexpr Duration kSlot = 7700us;

/// A voltage (0), which has a code for "not available", and a temperature (1), which has none.
class SensorRoleOfTwo : public testing::Test {
  protected:
    SensorRoleOfTwo() { make({}); }

    void make(SensorRoleSettings settings) {
        if (settings.sensors.empty()) {
            settings.sensors = {sensor("external_voltage", 0), sensor("temperature", 1)};
        }
        role_.emplace(std::move(settings));
        role_->start(now_);
        board_.set(0, 12.34, now_);
        board_.set(1, 21.5, now_);
    }
    /// Returns the answer to one frame of the receiver at the end of its slot.
    Bytes answer(const Bytes& asked) {
        role_->receive(asked, now_, board_);
        const Bytes said = turn(*role_, std::min(role_->due(), now_ + kSlot), board_);
        if (!said.empty()) {
            role_->receive(said, now_ + 800us, board_);
        }
        now_ += kSlot;
        return said;
    }

    ValueBoard board_{{{"battery", "V", 1s}, {"motor", "degC", 1s}}};
    Instant now_ = kStart;
    std::optional<SensorRole> role_;
};

TEST_F(SensorRoleOfTwo, AnswersADiscoverRequestWithTheSameBytes) {
    EXPECT_EQ(answer({0x04, 0x81, 0x7A, 0xFF}), (Bytes{0x04, 0x81, 0x7A, 0xFF}));
    EXPECT_EQ(answer({0x04, 0x82, 0x79, 0xFF}), (Bytes{0x04, 0x82, 0x79, 0xFF}));
}

TEST_F(SensorRoleOfTwo, TellsTypeAndSize) {
    EXPECT_EQ(answer({0x04, 0x91, 0x6A, 0xFF}), with_ibus_checksum({0x06, 0x91, 0x03, 0x02}));
    EXPECT_EQ(answer(request(0x92)), with_ibus_checksum({0x06, 0x92, 0x01, 0x02}));
}

TEST_F(SensorRoleOfTwo, TellsItsValues) {
    EXPECT_EQ(answer({0x04, 0xA1, 0x5A, 0xFF}), with_ibus_checksum({0x06, 0xA1, 0xD2, 0x04}))
        << "1234";
    EXPECT_EQ(answer(request(0xA2)), with_ibus_checksum({0x06, 0xA2, 0x67, 0x02}))
        << "(21.5 + 40) * 10";
}

TEST_F(SensorRoleOfTwo, IsSilentToOtherAddressesAndToPowerUpFrames) {
    EXPECT_TRUE(answer(request(0x83)).empty());
    EXPECT_TRUE(answer(request(0xA3)).empty());
    EXPECT_TRUE(answer({0x04, 0xF0, 0x0B, 0xFF}).empty());
}

TEST_F(SensorRoleOfTwo, TakesNoRequestInWhichTheLineDamagedAByte) {
    const Bytes asked{0x04, 0xA1, 0x5A, 0xFF};
    role_->receive(std::span(asked).first(2), now_, board_);
    role_->damaged_byte(now_);
    role_->receive(std::span(asked).subspan(2), now_, board_);
    EXPECT_TRUE(turn(*role_, std::min(role_->due(), now_ + kSlot), board_).empty());
}

TEST_F(SensorRoleOfTwo, NeverAnswersTheReplyOfAnother) {
    EXPECT_TRUE(answer(with_ibus_checksum({0x06, 0xA1, 0x00, 0x00})).empty());
    EXPECT_TRUE(answer(with_ibus_checksum({0x06, 0x91, 0x00, 0x02})).empty());
}

TEST_F(SensorRoleOfTwo, AnswersAfterAWaitAndNotBefore) {
    role_->receive(request(0xA1), now_, board_);
    EXPECT_EQ(role_->due(), now_ + 200us);
    EXPECT_TRUE(turn(*role_, now_ + 199us, board_).empty());
    EXPECT_FALSE(turn(*role_, now_ + 200us, board_).empty());
    EXPECT_EQ(role_->due(), kNever);
}

TEST_F(SensorRoleOfTwo, WithholdsAnAnswerWhoseTurnComesTooLate) {
    role_->receive(request(0xA1), now_, board_);
    EXPECT_FALSE(turn(*role_, now_ + 1ms, board_).empty());
    role_->receive(request(0xA1), now_ + kSlot, board_);
    EXPECT_TRUE(turn(*role_, now_ + kSlot + 1001us, board_).empty());
    EXPECT_EQ(role_->counts().late, 1U);
    EXPECT_EQ(role_->counts().answered, 1U);
}

TEST_F(SensorRoleOfTwo, WithholdsTheAnswerToARequestThatSomethingFollowsAlready) {
    Bytes both = request(0xA1);
    const Bytes next = request(0xA2);
    both.insert(both.end(), next.begin(), next.end());
    EXPECT_EQ(answer(both), with_ibus_checksum({0x06, 0xA2, 0x67, 0x02}));
    EXPECT_EQ(role_->counts().late, 1U);
}

TEST_F(SensorRoleOfTwo, WithholdsAnAnswerIfSomebodySpeaksBeforeIt) {
    role_->receive(request(0xA1), now_, board_);
    role_->receive(Bytes{0x20}, now_ + 100us, board_);
    EXPECT_TRUE(turn(*role_, now_ + 200us, board_).empty());
    EXPECT_EQ(role_->counts().late, 1U);
}

TEST_F(SensorRoleOfTwo, WithholdsTheAnswerToARequestThatWasReadLateByTheRhythm) {
    for (int slot = 0; slot < 100; ++slot) {
        EXPECT_FALSE(answer(request(0xA1)).empty()) << slot;
    }
    now_ += 3ms;
    EXPECT_TRUE(answer(request(0xA1)).empty());
    now_ -= 3ms;
    EXPECT_FALSE(answer(request(0xA1)).empty());
    EXPECT_EQ(role_->counts().late, 1U);
}

TEST_F(SensorRoleOfTwo, AnswersAReceiverThatBeginsAnewInAnotherRhythm) {
    for (int slot = 0; slot < 100; ++slot) {
        answer(request(0xA1));
    }
    now_ += 3ms;
    int silent = 0;
    for (int slot = 0; slot < 20; ++slot) {
        silent += answer(request(0xA1)).empty() ? 1 : 0;
    }
    EXPECT_LE(silent, 2);
}

TEST_F(SensorRoleOfTwo, AnswersAReceiverThatHasNoRhythm) {
    int silent = 0;
    for (int slot = 0; slot < 1000; ++slot) {
        now_ += 1us * (slot * 7919 % 9000) - 4ms;
        silent += answer(request(0xA1)).empty() ? 1 : 0;
    }
    EXPECT_EQ(silent, 0);
}

TEST_F(SensorRoleOfTwo, AnswersInTheMillisecondOfEachSlotWhateverTheJitterOfItsReads) {
    for (int slot = 0; slot < 1000; ++slot) {
        const Duration jitter = 10us * (slot * 37 % 31);
        now_ += jitter;
        EXPECT_FALSE(answer(request(0xA1)).empty()) << slot;
        now_ -= jitter;
    }
}

TEST_F(SensorRoleOfTwo, SaysANewValueOneSlotLaterAtTheLatest) {
    answer(request(0xA2));
    board_.set(0, 11, now_);
    answer(request(0xA2));
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x4C, 0x04}));
}

TEST_F(SensorRoleOfTwo, SaysNotAvailableForAStaleValueWhereTheTypeHasACode) {
    now_ += 2s;
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x00, 0x80}));
}

TEST_F(SensorRoleOfTwo, DoesNotAnswerForAStaleValueWhereTheTypeHasNone) {
    now_ += 2s;
    EXPECT_TRUE(answer(request(0xA2)).empty());
    EXPECT_EQ(role_->counts().stale, 1U);
    EXPECT_FALSE(answer(request(0x82)).empty()) << "the sensors behind it are found all the same";
    board_.set(1, 30, now_);
    EXPECT_EQ(answer(request(0xA2)), with_ibus_checksum({0x06, 0xA2, 0xBC, 0x02}));
}

TEST_F(SensorRoleOfTwo, SaysTheNumberThatTheUserWantsForAStaleValue) {
    SensorSettings temperature = sensor("temperature", 1);
    temperature.when_stale = -40;
    make({.first_address = 1, .sensors = {temperature}});
    now_ += 2s;
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x00, 0x00}));
}

TEST_F(SensorRoleOfTwo, NeverSaysAValueThatGrewStaleAfterItWasPrepared) {
    answer(request(0xA1));
    const Instant stale = kStart + 1s + 1ns;
    now_ = stale - 1us;
    role_->receive(request(0xA3), now_, board_);
    now_ = stale;
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x00, 0x80}));
}

TEST_F(SensorRoleOfTwo, SaysANegativeNumberAsSuchOrNone) {
    // A battery current has no sign in FlySky's meaning, an external voltage has one.
    make({.sensors = {sensor("battery_current", 0), sensor("external_voltage", 0)}});
    board_.set(0, -5, now_);
    EXPECT_TRUE(answer(request(0xA1)).empty());
    EXPECT_EQ(answer(request(0xA2)), with_ibus_checksum({0x06, 0xA2, 0x0C, 0xFE})) << "-500";
    board_.set(0, -0.004, now_);
    now_ += kSlot;
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x00, 0x00})) << "rounded";
}

TEST_F(SensorRoleOfTwo, SaysTheNumberThatTheUserWantsForANegativeOneWithoutASign) {
    auto current = sensor("battery_current", 0);
    current.when_stale = 0;
    make({.sensors = {current}});
    board_.set(0, -5, now_);
    EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0x00, 0x00}));
}

TEST_F(SensorRoleOfTwo, SaturatesAtTheEndsOfTheType) {
    for (const auto& [number, low, high] :
         {std::tuple{1e9, 0xFF, 0x7F}, std::tuple{-1e9, 0x01, 0x80}}) {
        board_.set(0, number, now_);
        answer(request(0xA3));
        EXPECT_EQ(answer(request(0xA1)),
                  with_ibus_checksum({0x06, 0xA1, static_cast<std::uint8_t>(low),
                                      static_cast<std::uint8_t>(high)}));
    }
    board_.set(1, -300, now_);
    answer(request(0xA3));
    EXPECT_EQ(answer(request(0xA2)), with_ibus_checksum({0x06, 0xA2, 0x00, 0x00}));
    board_.set(1, 1e9, now_);
    answer(request(0xA3));
    EXPECT_EQ(answer(request(0xA2)), with_ibus_checksum({0x06, 0xA2, 0xFF, 0xFF}));
}

TEST_F(SensorRoleOfTwo, TakesItsOwnEchoForNothingElse) {
    for (int slot = 0; slot < 10; ++slot) {
        answer(request(0x81));
    }
    EXPECT_EQ(role_->counts().requests, 10U);
    EXPECT_EQ(role_->echo().returned, 10U);
    EXPECT_EQ(role_->echo().collisions, 0U);
}

TEST_F(SensorRoleOfTwo, AnswersOnTwoWiresToo) {
    make({.receives_echo = false});
    for (int slot = 0; slot < 3; ++slot) {
        role_->receive(request(0x81), now_, board_);
        EXPECT_EQ(turn(*role_, now_ + 200us, board_), request(0x81));
        now_ += 1ms;
    }
}

TEST_F(SensorRoleOfTwo, AnswersBetweenServoFramesOnTheSameWire) {
    Bytes servo{0x20, 0x40};
    for (int channel = 0; channel < 14; ++channel) {
        servo.push_back(0xDC);
        servo.push_back(0x05);
    }
    const Bytes frame = with_ibus_checksum(servo);
    for (int slot = 0; slot < 10; ++slot) {
        role_->receive(frame, now_ - 800us, board_);
        EXPECT_EQ(answer(request(0xA1)), with_ibus_checksum({0x06, 0xA1, 0xD2, 0x04})) << slot;
    }
    EXPECT_EQ(role_->parser().servo_frames(), 10U);
}

TEST_F(SensorRoleOfTwo, KeepsToItsFixedAddresses) {
    make({.first_address = 4});
    EXPECT_TRUE(answer(request(0x81)).empty());
    EXPECT_EQ(answer(request(0x84)), request(0x84));
    EXPECT_EQ(answer(request(0x95)), with_ibus_checksum({0x06, 0x95, 0x01, 0x02}));
}

TEST_F(SensorRoleOfTwo, TakesTheAddressOfTheFirstDiscoverRequestInAChain) {
    make({.first_address = std::nullopt});
    EXPECT_TRUE(answer(request(0xA1)).empty()) << "of the sensor before us in the chain";
    EXPECT_EQ(answer(request(0x83)), request(0x83));
    EXPECT_EQ(answer(request(0x84)), request(0x84));
    EXPECT_TRUE(answer(request(0x85)).empty()) << "passed on: there are only two";
    EXPECT_TRUE(answer(request(0x81)).empty());
    EXPECT_EQ(answer(request(0xA3)), with_ibus_checksum({0x06, 0xA3, 0xD2, 0x04}));
}

TEST_F(SensorRoleOfTwo, LetsGoOfItsAddressInAChainWhenTheReceiverBeginsAnew) {
    make({.first_address = std::nullopt});
    answer(request(0x83));
    now_ += 600ms;
    EXPECT_EQ(answer(request(0x82)), request(0x82));
    answer({0x04, 0xF0, 0x0B, 0xFF});
    EXPECT_EQ(answer(request(0x81)), request(0x81));
}

TEST_F(SensorRoleOfTwo, AnswersAgainAfterDamage) {
    role_->receive(Bytes{0x04, 0xA1}, now_, board_);
    role_->damaged_byte(now_);
    role_->receive(Bytes{0xFF}, now_, board_);
    EXPECT_EQ(role_->due(), kNever);
    now_ += kSlot;
    EXPECT_FALSE(answer(request(0xA1)).empty());
}

TEST_F(SensorRoleOfTwo, DoesNotAnswerWhereAnyFieldOfAValueIsStale) {
    SensorSettings pair;
    pair.type = {.name = "pair",
                 .id = 0x70,
                 .size = 4,
                 .fields = {{.name = "first", .unit = "", .first_bit = 0},
                            {.name = "second", .unit = "", .first_bit = 16}}};
    for (const std::size_t stale : {0U, 1U}) {
        const std::size_t fresh = 1 - stale;
        pair.sources.assign(2, std::nullopt);
        pair.sources[stale] = FieldSource{.value = 0};
        pair.sources[fresh] = FieldSource{.value = 1};
        make({.sensors = {pair}});
        EXPECT_FALSE(answer(request(0xA1)).empty());
        board_.remove(0);
        answer(request(0xA1));
        EXPECT_TRUE(answer(request(0xA1)).empty()) << stale;
    }
}

TEST_F(SensorRoleOfTwo, GivesAnAnswerThatIsDueAfterAReload) {
    role_->receive(request(0xA1), now_, board_);
    SensorRole next({.sensors = {sensor("external_voltage", 0), sensor("temperature", 1)}});
    next.start(now_);
    next.continue_from(*role_);
    EXPECT_EQ(next.due(), now_ + 200us);
    EXPECT_EQ(turn(next, now_ + 200us, board_), with_ibus_checksum({0x06, 0xA1, 0xD2, 0x04}));
}

}  // namespace
}  // namespace tribus::test::sensor_bus::sensor_role_test
