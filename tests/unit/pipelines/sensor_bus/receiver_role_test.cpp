#include "pipelines/sensor_bus/receiver_role.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "tests/unit/pipelines/sensor_bus/sensor_bus_bench.h"

namespace tribus::test::sensor_bus::receiver_role_test {
namespace {

constexpr Duration kSlot = 7700us;
constexpr int kStartSlots = 10 + 66;

/// Sensors on the wire of a receiver role, with literal replies.
class ReceiverRoleAtAWire : public testing::Test {
  protected:
    ReceiverRoleAtAWire() { make({}); }

    void make(ReceiverRoleSettings settings) {
        for (std::size_t i = 0; i < kMostSensors; ++i) {
            settings.readings[i] = {.raw = 2 * i, .fields = {2 * i + 1}};
        }
        settings.first_of_type = {{.type = 0x03, .fields = {30}}};
        role_.emplace(std::move(settings));
        role_->start(now_);
    }

    void set_type(std::uint8_t address, std::uint8_t type, std::uint8_t size) {
        replies_[0x80U + address] = request(0x80U + address);
        replies_[0x90U + address] =
            with_ibus_checksum({0x06, static_cast<std::uint8_t>(0x90U + address), type, size});
    }
    void set_value(std::uint8_t address, const Bytes& data) {
        Bytes reply{static_cast<std::uint8_t>(4 + data.size()),
                    static_cast<std::uint8_t>(0xA0U + address)};
        reply.insert(reply.end(), data.begin(), data.end());
        replies_[0xA0U + address] = with_ibus_checksum(reply);
    }
    void unplug(std::uint8_t address) {
        for (const unsigned command : {0x80U, 0x90U, 0xA0U}) {
            replies_.erase(command + address);
        }
    }

    /// Runs one slot. Returns its request.
    Bytes slot(bool answered = true) {
        const Bytes asked = turn(*role_, now_, board_);
        if (!asked.empty() && echoes_) {
            role_->receive(asked, now_ + 350us, board_);
        }
        const auto reply = asked.empty() ? replies_.end() : replies_.find(asked[1]);
        if (answered && reply != replies_.end()) {
            role_->receive(reply->second, now_ + 1500us, board_);
        }
        now_ += kSlot;
        return asked;
    }
    void start_up() {
        for (int i = 0; i < kStartSlots; ++i) {
            slot();
        }
    }
    /// Adds a sensor of 10,000 rpm at address 1. The next request is for its value.
    void find_speed() {
        set_type(1, 0x02, 2);
        set_value(1, {0x10, 0x27});
        start_up();
        asked(3);
    }
    /// Returns the requests of the next slots, such as "81 91 82 a1".
    std::string asked(int slots) {
        std::string text;
        for (int i = 0; i < slots; ++i) {
            const Bytes bytes = slot();
            text += (text.empty() ? "" : " ") + hex(bytes);
        }
        return text;
    }
    static std::string hex(const Bytes& bytes) {
        constexpr std::string_view kDigits = "0123456789abcdef";
        return bytes.empty() ? "-" : std::string{kDigits[bytes[1] >> 4U], kDigits[bytes[1] & 0xFU]};
    }

    SensorFault fault_of_first() const { return role_->faults()[0]; }

    ValueBoard board_{std::vector<NamedValue>(31, {"", "", 2s})};
    Instant now_ = kStart;
    bool echoes_ = true;
    /// Replies by command and address of the request.
    std::map<unsigned, Bytes> replies_;
    std::optional<ReceiverRole> role_;
};

TEST_F(ReceiverRoleAtAWire, BeginsWithTenPowerUpFramesAndHalfASecondOfSilence) {
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(slot(), (Bytes{0x04, 0xF0, 0x0B, 0xFF}));
    }
    for (int i = 0; i < 66; ++i) {
        EXPECT_TRUE(slot().empty()) << i;
    }
    EXPECT_EQ(slot(), (Bytes{0x04, 0x81, 0x7A, 0xFF}));
}

TEST_F(ReceiverRoleAtAWire, AsksForTheFirstSensorInEverySlotWhileThereIsNone) {
    start_up();
    for (int i = 0; i < 792; ++i) {
        EXPECT_EQ(slot(), request(0x81)) << i;
    }
    EXPECT_TRUE(role_->found().empty());
}

TEST_F(ReceiverRoleAtAWire, FindsSensorsOneByOneThenAsksThemInTurn) {
    set_type(1, 0x03, 2);
    set_type(2, 0x02, 2);
    set_value(1, {0xD2, 0x04});
    set_value(2, {0x10, 0x27});
    start_up();
    EXPECT_EQ(asked(9), "81 91 82 92 83 a1 a2 a1 a2");
    EXPECT_EQ(role_->found().size(), 2U);
    EXPECT_EQ(role_->found()[1], (FoundSensor{.type = 0x02, .size = 2}));
    EXPECT_EQ(board_.fresh(1, now_), 12.34);
    EXPECT_EQ(board_.fresh(0, now_), 1234) << "raw";
    EXPECT_EQ(board_.tag(0), 0x03);
    EXPECT_EQ(board_.fresh(3, now_), 10'000);
    EXPECT_EQ(board_.fresh(30, now_), 12.34) << "the first of its type";
}

TEST_F(ReceiverRoleAtAWire, LooksForAFurtherSensorInOneSlotOf66) {
    set_type(1, 0x02, 2);
    set_value(1, {0, 0});
    start_up();
    EXPECT_EQ(asked(3), "81 91 82");
    std::vector<int> probes;
    for (int i = 0; i < 660; ++i) {
        if (slot() == request(0x82)) {
            probes.push_back(i);
        }
    }
    ASSERT_EQ(probes.size(), 10U);
    for (std::size_t i = 1; i < probes.size(); ++i) {
        EXPECT_EQ(probes[i] - probes[i - 1], 66);
    }
}

TEST_F(ReceiverRoleAtAWire, FindsASensorThatIsPluggedInLater) {
    set_type(1, 0x02, 2);
    set_value(1, {0, 0});
    start_up();
    asked(100);
    set_type(2, 0x01, 2);
    set_value(2, {0x67, 0x02});
    asked(70);
    EXPECT_EQ(role_->found().size(), 2U);
    EXPECT_DOUBLE_EQ(*board_.fresh(3, now_), 21.5);
}

TEST_F(ReceiverRoleAtAWire, AsksAgainInTheNextSlotAfterAMissAndGoesOn) {
    set_type(1, 0x02, 2);
    set_type(2, 0x02, 2);
    set_value(1, {0, 0});
    set_value(2, {0, 0});
    start_up();
    asked(5);
    EXPECT_EQ(hex(slot(false)), "a1");
    EXPECT_EQ(asked(4), "a1 a2 a1 a2");
    EXPECT_EQ(role_->counts().misses, 1U);
}

TEST_F(ReceiverRoleAtAWire, GivesTheOthersTheirTurnWhileOneDoesNotAnswer) {
    set_type(1, 0x02, 2);
    set_type(2, 0x02, 2);
    set_value(2, {0, 0});
    start_up();
    asked(5);
    EXPECT_EQ(asked(6), "a1 a1 a2 a1 a1 a2");
}

TEST_F(ReceiverRoleAtAWire, LosesASensorAfterTheMissesThatAreAllowedAndThoseBehindIt) {
    make({.drop_after = 4});
    set_type(1, 0x02, 2);
    set_type(2, 0x02, 2);
    set_value(1, {7, 0});
    set_value(2, {8, 0});
    start_up();
    asked(8);
    EXPECT_EQ(board_.fresh(3, now_), 8);
    unplug(1);
    unplug(2);
    EXPECT_EQ(asked(10), "a2 a2 a1 a1 a2 a2 82 a1 a1 81");
    EXPECT_TRUE(role_->found().empty());
    EXPECT_EQ(board_.fresh(1, now_), std::nullopt);
    EXPECT_EQ(board_.fresh(3, now_), std::nullopt);
}

TEST_F(ReceiverRoleAtAWire, AsksTheFirstOneNextAfterTheLossOfTheLast) {
    make({.drop_after = 2});
    for (std::uint8_t address = 1; address <= 3; ++address) {
        set_type(address, 0x02, 2);
        set_value(address, {7, 0});
    }
    start_up();
    EXPECT_EQ(asked(10), "81 91 82 92 83 93 84 a1 a2 a3");
    unplug(3);
    EXPECT_EQ(asked(8), "a1 a2 a3 a3 83 a1 a2 a1");
    EXPECT_EQ(role_->counts().lost_sensors, 1U);
}

TEST_F(ReceiverRoleAtAWire, KeepsWhatASensorSaysWhileOneBeforeItIsSoughtAgain) {
    make({.drop_after = 4});
    set_type(1, 0x02, 2);
    set_type(2, 0x02, 2);
    set_value(2, {8, 0});
    start_up();
    asked(5);
    for (int i = 0; i < 1000; ++i) {
        slot();
        ASSERT_TRUE(i < 10 || board_.fresh(3, now_) == 8) << i;
    }
    EXPECT_GT(role_->counts().lost_sensors, 100U);
}

TEST_F(ReceiverRoleAtAWire, NeverTakesItsOwnRequestForAReply) {
    start_up();
    asked(100);
    EXPECT_TRUE(role_->found().empty());
    EXPECT_EQ(role_->echo().returned, 10U + 100U);
}

TEST_F(ReceiverRoleAtAWire, FindsOutThatItHasTwoWires) {
    echoes_ = false;
    set_type(1, 0x03, 2);
    set_value(1, {0xD2, 0x04});
    start_up();
    EXPECT_EQ(asked(4), "81 91 82 a1");
    EXPECT_EQ(board_.fresh(1, now_), 12.34);
}

TEST_F(ReceiverRoleAtAWire, RefusesAnswersToSomethingElse) {
    set_type(1, 0x02, 2);
    start_up();
    asked(3);
    for (const Bytes& wrong :
         {with_ibus_checksum({0x06, 0xA2, 1, 0}), with_ibus_checksum({0x06, 0x91, 1, 0}),
          with_ibus_checksum({0x08, 0xA1, 1, 0, 0, 0})}) {
        replies_[0xA1] = wrong;
        slot();
        EXPECT_FALSE(board_.ever(1));
    }
    EXPECT_EQ(role_->counts().wrong, 3U);
}

TEST_F(ReceiverRoleAtAWire, TakesNoReplyInWhichTheLineDamagedAByte) {
    find_speed();
    const Bytes asked = turn(*role_, now_, board_);
    ASSERT_EQ(asked, request(0xA1));
    role_->receive(asked, now_ + 350us, board_);
    const std::span reply(replies_.at(0xA1));
    role_->receive(reply.first(3), now_ + 1500us, board_);
    role_->damaged_byte(now_ + 1500us);
    role_->receive(reply.subspan(3), now_ + 1500us, board_);
    EXPECT_EQ(board_.fresh(1, now_ + 2ms), std::nullopt);
}

TEST_F(ReceiverRoleAtAWire, HearsTheReplyBehindAnEchoInWhichTheLineDamagedAByte) {
    find_speed();
    const Bytes asked = turn(*role_, now_, board_);
    const std::span echo(asked);
    role_->receive(echo.first(2), now_ + 350us, board_);
    role_->damaged_byte(now_ + 350us);
    role_->receive(echo.last(1), now_ + 350us, board_);
    role_->receive(replies_.at(0xA1), now_ + 1500us, board_);
    EXPECT_EQ(board_.fresh(1, now_ + 2ms), 10'000);
}

TEST_F(ReceiverRoleAtAWire, ReadsTheSizeFromTheTypeReplyWhateverTheTableSays) {
    set_type(1, 0x02, 4);
    set_value(1, {0x40, 0x42, 0x0F, 0x00});
    start_up();
    asked(6);
    EXPECT_EQ(board_.fresh(1, now_), 1'000'000);
}

TEST_F(ReceiverRoleAtAWire, TellsTheRawNumberOfATypeThatNobodyKnows) {
    set_type(1, 0x2E, 2);
    set_value(1, {0xFF, 0xFF});
    start_up();
    asked(6);
    EXPECT_EQ(board_.fresh(0, now_), 65535);
    EXPECT_EQ(board_.tag(0), 0x2E);
    EXPECT_FALSE(board_.ever(1));
}

TEST_F(ReceiverRoleAtAWire, TellsThatASensorHasNoNumber) {
    set_type(1, 0x03, 2);
    set_value(1, {0x01, 0x00});
    start_up();
    asked(5);
    EXPECT_TRUE(board_.fresh(1, now_));
    set_value(1, {0x00, 0x80});
    asked(2);
    EXPECT_EQ(board_.fresh(1, now_), std::nullopt);
    EXPECT_EQ(board_.fresh(30, now_), std::nullopt);
}

TEST_F(ReceiverRoleAtAWire, SkipsWholeSlotsThatItMissed) {
    start_up();
    slot();
    now_ += 3 * kSlot + 1ms;
    const Instant late = now_;
    EXPECT_FALSE(turn(*role_, late, board_).empty());
    EXPECT_EQ(role_->due(), late - 1ms + kSlot) << "the grid stays where it was";
}

TEST_F(ReceiverRoleAtAWire, BeginsAnewWhenItsDeviceIsBack) {
    set_type(1, 0x02, 2);
    set_value(1, {7, 0});
    start_up();
    asked(6);
    role_->device_lost(board_);
    EXPECT_EQ(board_.fresh(1, now_), std::nullopt);
    for (int i = 0; i < 300; ++i) {
        EXPECT_FALSE(role_->run(now_, board_).empty());
        role_->dropped();
        now_ += kSlot;
    }
    start_up();
    EXPECT_EQ(asked(4), "81 91 82 a1");
}

TEST_F(ReceiverRoleAtAWire, FindsAsManyAsThereAreAddresses) {
    for (std::uint8_t address = 1; address <= 15; ++address) {
        set_type(address, 0x02, 2);
        set_value(address, {address, 0});
    }
    start_up();
    asked(30 + 15 + 200);
    EXPECT_EQ(role_->found().size(), 15U);
    for (std::size_t i = 0; i < 15; ++i) {
        EXPECT_EQ(board_.fresh(2 * i + 1, now_), i + 1);
    }
}

TEST_F(ReceiverRoleAtAWire, KeepsASensorThatAnswersBeforeItHasMissedTooOftenInARow) {
    make({.drop_after = 4});
    set_type(1, 0x02, 2);
    set_value(1, {7, 0});
    start_up();
    asked(4);
    for (int times = 0; times < 10; ++times) {
        slot(false);
        slot(false);
        slot(false);
        slot();
        slot();
    }
    EXPECT_EQ(role_->found().size(), 1U);
    EXPECT_EQ(role_->counts().lost_sensors, 0U);
}

TEST_F(ReceiverRoleAtAWire, SaysThatASensorAnswersButNeverTellsItsType) {
    set_type(1, 0x02, 2);
    replies_.erase(0x91);
    start_up();
    EXPECT_EQ(asked(7), "81 91 91 81 91 91 81");
    EXPECT_EQ(fault_of_first(), (SensorFault{.kind = SensorFault::Kind::no_type}));
    EXPECT_TRUE(role_->found().empty());
    unplug(1);
    asked(7);
    EXPECT_NE(fault_of_first(), SensorFault{}) << "a few requests may be lost";
    asked(6);
    EXPECT_EQ(fault_of_first(), SensorFault{}) << "it is gone";
}

TEST_F(ReceiverRoleAtAWire, SaysThatValuesHaveAnotherSizeThanTheSensorSaid) {
    set_type(1, 0x02, 2);
    set_value(1, {0x10, 0x27, 0, 0});
    start_up();
    asked(500);
    EXPECT_EQ(fault_of_first(),
              (SensorFault{.kind = SensorFault::Kind::wrong_size, .sent_size = 4}));
    EXPECT_EQ(role_->counts().lost_sensors, 0U) << "it answers";
    EXPECT_FALSE(board_.ever(1));
    set_value(1, {0x10, 0x27});
    asked(2);
    EXPECT_EQ(fault_of_first(), SensorFault{});
    EXPECT_EQ(board_.fresh(1, now_), 10'000);
}

TEST_F(ReceiverRoleAtAWire, AsksForTheTypeOnceForEachFourValuesOfAnotherSize) {
    make({.drop_after = 4});
    set_type(1, 0x02, 2);
    set_value(1, {0x10, 0x27, 0, 0});
    start_up();
    EXPECT_EQ(asked(14), "81 91 82 a1 a1 a1 a1 91 a1 a1 a1 a1 91 a1");
}

TEST_F(ReceiverRoleAtAWire, FindsOutThatAnotherSensorWasPluggedInBetweenTwoRequests) {
    make({.drop_after = 4});
    find_speed();
    set_type(1, 0x2E, 4);
    set_value(1, {1, 0, 0, 0});
    EXPECT_EQ(asked(8), "a1 a1 a1 a1 91 82 a1 a1");
    EXPECT_EQ(role_->found()[0], (FoundSensor{.type = 0x2E, .size = 4}));
    EXPECT_EQ(fault_of_first(), SensorFault{});
    EXPECT_EQ(board_.fresh(0, now_), 1);
}

}  // namespace
}  // namespace tribus::test::sensor_bus::receiver_role_test
