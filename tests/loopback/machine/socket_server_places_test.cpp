#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <deque>
#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/machine/served_turns.h"

/// A server accepts clients, refuses some, and lets some give way to others.
namespace tribus::test::socket_server_places_test {
namespace {

using namespace std::chrono_literals;

constexpr uid_t kNobody = 65534;

class ServedPlaces : public ServedTurns {};

class FiveTurns : public ServedTurns {
  protected:
    FiveTurns() : ServedTurns(5) {
        ::chmod(folder_.path().c_str(), 0755);
        ::chmod(path_.c_str(), 0666);
    }
    /// A client of another user.
    Guest nobody(const std::string& says) {
        EXPECT_EQ(::seteuid(kNobody), 0);
        Guest guest(path_);
        EXPECT_EQ(::seteuid(0), 0);
        guest.say(says);
        serve(1ms);
        return guest;
    }
};

class SilentTurns : public ServedTurns {
  protected:
    SilentTurns() : ServedTurns(1, "") {}
};

TEST_F(ServedPlaces, AcceptsNoMoreAtOnceThanItHasPlaces) {
    std::deque<Guest> guests;
    for (int i = 0; i < 5; ++i) {
        guests.emplace_back(path_);
    }
    serve();
    EXPECT_EQ(count(), 4U);
    EXPECT_EQ(server_->dropped(), 0U);
    EXPECT_TRUE(calls());
    serve();
    EXPECT_EQ(count(), 4U);
    EXPECT_EQ(server_->dropped(), 1U);
    EXPECT_EQ(guests[0].read(), "(closed)") << "the first one of those who are equally quiet";
    EXPECT_EQ(guests[3].read(), "");
}

TEST_F(ServedPlaces, RefusesOneMoreThanWaitForTheirAnswers) {
    std::deque<Guest> guests;
    for (int i = 0; i < 4; ++i) {
        guests.push_back(guest("late\n"));
    }
    Guest more = guest("late\n");
    EXPECT_EQ(more.read(), "full(closed)");
    EXPECT_EQ(count(), 4U);
    EXPECT_EQ(server_->dropped(), 0U);
    guests.pop_back();
    serve();
    Guest one = guest("late\n");
    EXPECT_EQ(one.read(), "");
    EXPECT_EQ(count(), 4U);
}

TEST_F(ServedPlaces, RefusesOneMoreThanReadTheirAnswers) {
    std::deque<Guest> guests;
    for (int i = 0; i < 4; ++i) {
        guests.push_back(guest("long\n"));
    }
    EXPECT_EQ(guest("late\n").read(), "full(closed)");
}

TEST_F(ServedPlaces, RefusesOneMoreThanWatch) {
    std::deque<Guest> guests;
    for (int i = 0; i < 4; ++i) {
        guests.push_back(guest("repeat\n"));
    }
    EXPECT_EQ(guest("late\n").read(), "full(closed)");
}

TEST_F(ServedPlaces, RefusesOneWhoHasLeftAlready) {
    std::deque<Guest> guests;
    for (int i = 0; i < 4; ++i) {
        guests.push_back(guest("late\n"));
    }
    // Another test may have told this process to ignore it.
    auto* const before = std::signal(SIGPIPE, SIG_DFL);
    Guest(path_).leave();
    serve();
    std::signal(SIGPIPE, before);
    EXPECT_EQ(count(), 4U);
}

TEST_F(SilentTurns, RefuseWithoutAWord) {
    const Guest first = guest("late\n");
    EXPECT_EQ(guest("late\n").read(), "(closed)");
}

TEST_F(FiveTurns, TakeAPlaceOfWhoHasTwoMore) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root can be somebody else";
    }
    std::deque<Guest> others;
    std::deque<Guest> own;
    for (int i = 0; i < 4; ++i) {
        others.push_back(nobody("repeat\n"));
    }
    own.push_back(guest("repeat\n"));
    own.push_back(guest("repeat\n"));
    EXPECT_EQ(count(), 5U);
    EXPECT_EQ(own[1].read(), "");
    EXPECT_EQ(others[0].read(), "(closed)") << "the one that was quiet longest";
    EXPECT_EQ(server_->dropped(), 1U);
    // Three and two.
    EXPECT_EQ(guest("repeat\n").read(), "full(closed)");
    EXPECT_EQ(nobody("repeat\n").read(), "full(closed)");
    EXPECT_EQ(server_->dropped(), 1U);
}

TEST_F(FiveTurns, TakeThePlaceOfOneWhoIsIdleRatherThanOfOneWhoWatches) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root can be somebody else";
    }
    std::deque<Guest> others;
    for (const char* says : {"repeat\n", "repeat\n", "", "", "late\n"}) {
        others.push_back(nobody(says));
    }
    const Guest own = guest("late\n");
    EXPECT_EQ(others[0].read(), "");
    EXPECT_EQ(others[2].read(), "(closed)");
    EXPECT_EQ(others[3].read(), "");
}

TEST_F(FiveTurns, TakeNoPlaceOfAnIdleOneWhoseUserHasFewer) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root can be somebody else";
    }
    Guest idle = guest("");
    std::deque<Guest> others;
    for (int i = 0; i < 4; ++i) {
        others.push_back(nobody("repeat\n"));
    }
    EXPECT_EQ(nobody("").read(), "full(closed)");
    EXPECT_EQ(idle.read(), "");
}

}  // namespace
}  // namespace tribus::test::socket_server_places_test
