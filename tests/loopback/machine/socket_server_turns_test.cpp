#include <chrono>
#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/machine/served_turns.h"
#include "tests/support/fewer_descriptors.h"

/// A server waits for clients, hears them and drops them, in virtual time.
namespace tribus::test::socket_server_turns_test {
namespace {

using namespace std::chrono_literals;

TEST(SocketServerThatCannotBeMade, SaysWhy) {
    const auto no_listener = SocketServer::make(UniqueFd(), {}, {});
    ASSERT_FALSE(no_listener);
    EXPECT_EQ(no_listener.error(), "epoll: Bad file descriptor");
    const FewerDescriptors none(0);
    const auto no_descriptor = SocketServer::make(UniqueFd(), {}, {});
    ASSERT_FALSE(no_descriptor);
    EXPECT_EQ(no_descriptor.error(), "epoll: Too many open files");
}

TEST_F(ServedTurns, CallsForAConnectionUntilItIsTaken) {
    EXPECT_FALSE(calls());
    EXPECT_EQ(server_->due(), kNever);
    const Guest first(path_);
    EXPECT_TRUE(calls());
    serve();
    EXPECT_FALSE(calls());
    EXPECT_EQ(count(), 1U);
}

TEST_F(ServedTurns, CallsForWhatAClientSays) {
    Guest first = guest("");
    first.say("lat");
    EXPECT_TRUE(calls());
    serve();
    EXPECT_FALSE(calls());
}

TEST_F(ServedTurns, CallsForRoomAndNotForRequestsWhileAnAnswerIsSent) {
    Guest first = guest("long\n");
    first.say("long\n");
    EXPECT_FALSE(calls()) << "there is no room yet";
    first.read();
    EXPECT_TRUE(calls());
}

TEST_F(ServedTurns, DoesNotCallForOneWhoSaysNoMoreAndWaits) {
    Guest first = guest("late\n");
    first.say_no_more();
    serve();
    EXPECT_FALSE(calls());
    EXPECT_EQ(count(), 1U);
    late_answer_ = "here";
    serve();
    EXPECT_EQ(first.read(), "here(closed)");
    EXPECT_EQ(server_->dropped(), 0U);
}

TEST_F(ServedTurns, DoesNotCallForMoreThanARequest) {
    Guest first = guest("late\n" + std::string(100, 'x'));
    serve();
    EXPECT_FALSE(calls());
    EXPECT_EQ(count(), 1U);
}

TEST_F(ServedTurns, WaitsForOneWhoIsToReadTenSecondsBehindTheLastByte) {
    Guest first = guest("long\n");
    EXPECT_EQ(until_due(), 10s);
    serve(9s);
    first.read();
    serve();
    EXPECT_EQ(until_due(), 10s) << "it has read something";
    serve(10s);
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(server_->dropped(), 1U);
    EXPECT_EQ(server_->due(), kNever);
}

TEST_F(ServedTurns, WaitsForARequestFiveSecondsAndForItsRestFour) {
    Guest first = guest("");
    EXPECT_EQ(until_due(), 5s);
    serve(2s);
    first.say("lat");
    serve();
    EXPECT_EQ(until_due(), 4s);
    serve(4s);
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(server_->dropped(), 1U);
}

TEST_F(ServedTurns, WaitsForALateAnswerForEver) {
    const Guest first = guest("late\n");
    EXPECT_EQ(server_->due(), kNever);
}

TEST_F(ServedTurns, SendsWhatIsRepeatedWhenItIsDueAndNotBefore) {
    Guest first = guest("repeat\n");
    EXPECT_EQ(until_due(), 3s);
    serve(3s - 1ns);
    EXPECT_EQ(first.read(), "");
    serve(1ns);
    EXPECT_EQ(first.read(), ".");
    EXPECT_EQ(until_due(), 3s);
}

TEST_F(ServedTurns, KeepsOneWhoReadsWhatIsRepeated) {
    Guest first = guest("repeat\n");
    for (int i = 0; i < 10; ++i) {
        serve(3s);
        EXPECT_EQ(first.read(), ".") << i;
        serve();
    }
    EXPECT_EQ(count(), 1U);
}

TEST_F(ServedTurns, KeepsOneWhoSaysNoMoreAndGetsWhatIsRepeated) {
    Guest first = guest("repeat\n");
    first.say_no_more();
    serve();
    serve(3s);
    EXPECT_EQ(first.read(), ".");
    EXPECT_EQ(count(), 1U);
}

TEST_F(ServedTurns, SendsNothingRepeatedToOneWhoHasNotReadTheLast) {
    Guest first = guest("repeat\n");
    serve(3s);
    serve(3s);
    EXPECT_EQ(first.read(), ".");
    serve(3s);
    EXPECT_EQ(first.read(), ".");
}

TEST_F(ServedTurns, DropsOneWhomTheRepetitionRejects) {
    const Guest first = guest("repeat\n");
    keeps_ = false;
    serve(3s);
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(server_->dropped(), 0U);
}

TEST_F(ServedTurns, DropsOneWhoseRequestIsRejected) {
    Guest first = guest("drop\n");
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(first.read(), "(closed)");
}

TEST_F(ServedTurns, DropsOneWhoLeavesAmidAnAnswer) {
    Guest first = guest("long\n");
    first.leave();
    serve();
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(server_->dropped(), 0U);
}

TEST_F(ServedTurns, DropsOneWhoLeavesWithoutAnAnswer) {
    Guest first = guest("late\n");
    first.leave();
    serve();
    EXPECT_EQ(count(), 0U);
}

TEST_F(ServedTurns, DropsOneWhoHasLeftRatherThanRepeat) {
    Guest first = guest("repeat\n");
    first.leave();
    serve();
    EXPECT_EQ(count(), 0U);
}

TEST_F(ServedTurns, DropsOneWhoLeavesWithoutReadingAnAnswer) {
    Guest first = guest("repeat\n");
    serve(3s);
    first.leave();
    serve();
    EXPECT_EQ(count(), 0U);
}

TEST_F(ServedTurns, HearsNoMoreFromOneWhoseLastAnswerIsSent) {
    Guest first = guest("bye\n");
    first.say("drop\n");
    std::string all;
    for (int i = 0; i < 1000 && count() > 0; ++i) {
        all += first.read();
        serve();
    }
    EXPECT_EQ(all + first.read(), long_ + "(closed)");
}

TEST_F(ServedTurns, AnswersTheNextRequestBehindALongAnswer) {
    Guest first = guest("long\nlong\n");
    std::string all;
    for (int i = 0; i < 1000 && all.size() < 2 * long_.size(); ++i) {
        all += first.read();
        serve();
    }
    EXPECT_EQ(all.size(), 2 * long_.size());
    EXPECT_EQ(count(), 1U);
}

TEST_F(ServedTurns, PauseForASecondWithoutDescriptors) {
    const Guest first(path_);
    {
        const FewerDescriptors none(0);
        serve();
    }
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(until_due(), 1s);
    EXPECT_FALSE(calls()) << "trying at once would take a whole processor";
    serve(1s - 1ns);
    EXPECT_EQ(count(), 0U);
    EXPECT_EQ(until_due(), 1ns);
    serve(1ns);
    EXPECT_EQ(count(), 1U);
    EXPECT_EQ(until_due(), 5s);
    const Guest second(path_);
    EXPECT_TRUE(calls());
    serve();
    EXPECT_EQ(count(), 2U);
}

}  // namespace
}  // namespace tribus::test::socket_server_turns_test
