#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/dronecan_frames.h"
#include "transports/codecs/dronecan/actuators.h"
#include "transports/codecs/dronecan/rc.h"

/// Old messages that are repeated in a ring, and nodes whose messages cannot be read.
namespace tribus::dronecan::old_messages_test {
namespace {

using namespace test;
using std::chrono::milliseconds;

constexpr Duration kPeriod = milliseconds(20);
constexpr unsigned kTransferIds = 32;

std::vector<CanFrame> sticks(NodeId source, unsigned transfer_id) {
    RcInput message;
    message.rcin = {1000, 1100, 1200, 1300};
    return frames_of_message(message, source, transfer_id % kTransferIds);
}

std::vector<CanFrame> servos(NodeId source, unsigned transfer_id) {
    ArrayCommand message;
    message.commands.push_back(
        {.actuator_id = 1, .command_type = ActuatorCommand::kUnitless, .command_value = 0.5F});
    return frames_of_message(message, source, transfer_id % kTransferIds);
}

std::vector<CanFrame> motors(NodeId source, unsigned transfer_id) {
    EscRawCommand message;
    message.cmd = {100, 200};
    return frames_of_message(message, source, transfer_id % kTransferIds);
}

struct Kind {
    const char* name;
    std::vector<CanFrame> (*frames)(NodeId source, unsigned transfer_id);
    /// Id of a single frame of node 7 that cannot be read.
    std::uint32_t broken_id;
    std::unique_ptr<CanDecoder> (*decoder)();
};

const std::vector<Kind> kKinds{
    {"RcInput", sticks, 0x08047407, [] { return std::unique_ptr<CanDecoder>(new RcDecoder({})); }},
    {"Servos", servos, 0x0803F207,
     [] { return std::unique_ptr<CanDecoder>(new CommandDecoder({})); }},
    {"Motors", motors, 0x08040607,
     [] {
         return std::unique_ptr<CanDecoder>(
             new CommandDecoder({.kind = CommandKind::motors, .first = 0}));
     }},
};

class OldMessages : public testing::TestWithParam<Kind> {
  protected:
    /// Returns whether these frames are accepted one period later.
    bool believes(const std::vector<CanFrame>& frames) {
        now_ += kPeriod;
        bool any = false;
        for (const CanFrame& frame : frames) {
            any = decoder_->next(frame, now_).has_value() || any;
        }
        return any;
    }
    bool believes(unsigned transfer_id) { return believes(GetParam().frames(42, transfer_id)); }

    std::unique_ptr<CanDecoder> decoder_ = GetParam().decoder();
    Instant now_ = kStart;
};

TEST_P(OldMessages, InARingAreNeverBelievedUnlessTheyAreAllTransferIds) {
    for (unsigned length = 2; length < kTransferIds; ++length) {
        decoder_ = GetParam().decoder();
        for (unsigned id = 0; id < 100; ++id) {
            ASSERT_TRUE(believes(id));
        }
        for (unsigned turn = 0; turn < 500; ++turn) {
            EXPECT_FALSE(believes(100 - length + turn % length)) << length << ", " << turn;
        }
        EXPECT_EQ(count_named(decoder_->rejected(), "other source"), 0U);
    }
}

TEST_P(OldMessages, LostOnesAreToldFromOldOnesByTheTimeThatPassed) {
    unsigned id = 0;
    for (unsigned lost = 0; lost < kTransferIds - 1; ++lost) {
        id += lost;
        now_ += kPeriod * static_cast<int>(lost);
        for (unsigned message = 0; message < 40; ++message, ++id) {
            EXPECT_TRUE(believes(id)) << lost << " lost, message " << message;
        }
    }
}

TEST_P(OldMessages, AfterARestartWithoutAPauseAllTransferIdsMustPass) {
    for (unsigned id = 0; id < 10; ++id) {
        believes(id);
    }
    for (unsigned id = 0; id < kTransferIds; ++id) {
        EXPECT_FALSE(believes(id)) << id;
    }
    EXPECT_TRUE(believes(0U));
}

TEST_P(OldMessages, AfterARestartOfTwoSecondsTheFirstOneCounts) {
    for (unsigned id = 0; id < 10; ++id) {
        believes(id);
    }
    now_ += std::chrono::seconds(2);
    EXPECT_TRUE(believes(0U));
}

TEST_P(OldMessages, ANodeThatSendsOnlyBrokenOnesFirstDoesNotLockOutAGoodOne) {
    for (unsigned id = 0; id < 10; ++id) {
        EXPECT_FALSE(believes(frames_from(GetParam().broken_id, {"01C" + std::to_string(id)})));
        EXPECT_TRUE(believes(id)) << id;
    }
    EXPECT_GT(count_named(decoder_->rejected(), "layout"), 0U);
    EXPECT_FALSE(believes(GetParam().frames(7, 20))) << "the good one is the source now";
}

INSTANTIATE_TEST_SUITE_P(Kinds, OldMessages, testing::ValuesIn(kKinds),
                         [](const testing::TestParamInfo<Kind>& kind) {
                             return std::string(kind.param.name);
                         });

// Status 5 (valid, link quality), quality 100, no channel.
TEST(RcInputDecoder, ANodeThatSendsMessagesWithoutChannelsDoesNotLockOutAGoodOne) {
    RcDecoder decoder({});
    decoder.next(frames_from(0x0804740A, {"05006400C0"})[0], kStart);
    bool any = false;
    for (const CanFrame& frame : sticks(42, 0)) {
        any = decoder.next(frame, kStart + milliseconds(1)).has_value() || any;
    }
    EXPECT_TRUE(any);
}

}  // namespace
}  // namespace tribus::dronecan::old_messages_test
