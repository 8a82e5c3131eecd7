#include <chrono>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "transports/codecs/authenticated/receiver.h"
#include "transports/codecs/authenticated/sender.h"

/// Everything that somebody on the way can do in a few steps: an attacker who has no key keeps
/// every message, and delivers each to either end, at any time, in any order, as often as wanted,
/// or never. Meanwhile each end may start again.
namespace tribus::test::attacker_test {
namespace {

using namespace authenticated;
using namespace std::chrono_literals;

constexpr int kSteps = 9;
constexpr std::size_t kMostMessages = 5;
constexpr Duration kTick = 120ms;

struct Message {
    std::vector<std::uint8_t> bytes;
    Instant sent{};
};

struct World {
    explicit World(const LinkMacs& macs)
        : receiver(macs, std::nullopt, seed(1)), sender(macs, seed(1)) {}

    static RandomSeed seed(std::uint8_t start) { return {start}; }

    Receiver receiver;
    Sender sender;
    std::uint8_t starts = 1;
    Instant now = Instant{} + 1h;
    Instant receiver_began = now;
    std::vector<Message> messages;
    /// Places in `messages` of what the receiver has accepted since it started.
    std::set<std::size_t> accepted;
};

class Attacker : public ::testing::Test {
  protected:
    /// Tries all that can be done in `steps` from here on.
    void explore(const World& before, int steps) {
        ++worlds_;
        if (steps == 0 || HasFatalFailure()) {
            return;
        }
        World ticked = before;
        ticked.now += kTick;
        explore(ticked, steps - 1);
        if (before.messages.size() < kMostMessages) {
            say_hello(before, steps);
            snapshot(before, steps);
        }
        start_again(before, steps);
        for (std::size_t place = 0; place < before.messages.size(); ++place) {
            deliver(before, place, steps);
        }
    }

    void say_hello(const World& before, int steps) {
        World world = before;
        HelloMessage message{};
        if (world.sender.write_hello(message, world.now)) {
            world.messages.push_back({{message.begin(), message.end()}, world.now});
            explore(world, steps - 1);
        }
    }

    void snapshot(const World& before, int steps) {
        World world = before;
        ChannelFrame sticks;
        sticks.received = world.now;
        SnapshotMessage message{};
        if (world.sender.write(sticks, message, world.now)) {
            world.messages.push_back({{message.begin(), message.end()}, world.now});
            explore(world, steps - 1);
        }
    }

    void start_again(const World& before, int steps) {
        World sender_new = before;
        sender_new.sender = Sender(macs_, World::seed(++sender_new.starts));
        explore(sender_new, steps - 1);
        World receiver_new = before;
        receiver_new.receiver = Receiver(macs_, std::nullopt, World::seed(++receiver_new.starts));
        receiver_new.receiver_began = receiver_new.now;
        receiver_new.accepted.clear();
        explore(receiver_new, steps - 1);
    }

    void deliver(const World& before, std::size_t place, int steps) {
        World world = before;
        const Message& message = before.messages[place];
        if (const auto frame = world.receiver.next(message.bytes, world.now)) {
            ++accepted_;
            ASSERT_TRUE(world.accepted.empty() || place > *world.accepted.rbegin())
                << "twice, or behind a newer one";
            world.accepted.insert(place);
            ASSERT_LE(frame->received, message.sent) << "younger than it is";
            ASSERT_GE(message.sent, world.receiver_began) << "from before the start";
        }
        ChallengeMessage answer{};
        if (world.receiver.answer(answer, world.now) && world.messages.size() < kMostMessages) {
            world.messages.push_back({{answer.begin(), answer.end()}, world.now});
        }
        const bool heard = world.sender.hear(message.bytes, world.now);
        heard_ += heard ? 1U : 0U;
        explore(world, steps - 1);
    }

    LinkMacs macs_{SecretKey{1}, "attacked"};
    std::size_t worlds_ = 0;
    std::size_t accepted_ = 0;
    std::size_t heard_ = 0;
};

TEST_F(Attacker, GetsNothingAcceptedTwiceOrYoungerThanItIsOrFromBeforeAStart) {
    explore(World(macs_), kSteps);
    RecordProperty("worlds", std::to_string(worlds_));
    EXPECT_GT(accepted_, 100U) << "the link works in few of these worlds";
    EXPECT_GT(heard_, 100U);
}

}  // namespace
}  // namespace tribus::test::attacker_test
