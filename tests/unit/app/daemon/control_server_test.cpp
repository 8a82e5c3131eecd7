#include "app/daemon/control_server.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <deque>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace tribus::control_server_test {
namespace {

constexpr Duration kMs = std::chrono::milliseconds(1);

/// A client of the socket that reads only when told to.
class Guest {
  public:
    explicit Guest(const std::string& path) {
        auto socket = connect_local(path);
        EXPECT_TRUE(socket);
        if (socket) {
            socket_ = std::move(*socket);
        }
    }
    void say(const std::string& text) {
        ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL);
    }
    /// Returns all bytes that wait, with "(closed)" after the end of the stream.
    std::string read() {
        std::string all;
        std::array<char, 65536> bytes;
        for (;;) {
            const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (count <= 0) {
                return all + (count == 0 ? "(closed)" : "");
            }
            all.append(bytes.data(), static_cast<std::size_t>(count));
        }
    }
    void say_no_more() { ::shutdown(socket_.get(), SHUT_WR); }
    void leave() { socket_.reset(); }

  private:
    UniqueFd socket_;
};

/// A server whose status contains a number that grows with each request. The test moves the clock.
class Control : public testing::Test {
  protected:
    Control() {
        auto opened = ControlServer::open(folder_ / "control");
        EXPECT_TRUE(opened) << opened.error();
        control_ = std::move(*opened);
        control_->add("status", [this](auto) {
            return "{\"n\":" + std::to_string(++told_) + ",\"fill\":\"" + fill_ + "\"}";
        });
    }
    void pass(Duration time) {
        now_ += time;
        control_->serve(now_);
    }
    void pass_in_steps(int steps, Duration step) {
        for (int i = 0; i < steps; ++i) {
            pass(step);
        }
    }

    test::TemporaryFolder folder_;
    std::unique_ptr<ControlServer> control_;
    Instant now_{std::chrono::hours(1)};
    int told_ = 0;
    std::string fill_;
};

TEST_F(Control, AnswersOneObjectALine) {
    Guest guest(folder_ / "control");
    guest.say("status\n");
    pass(kMs);
    EXPECT_EQ(guest.read(), "{\"n\":1,\"fill\":\"\"}\n");
}

TEST_F(Control, ThatOnlyTellsSaysWhereChangesGo) {
    control_->tell_only("/run/tribus/car/control");
    Guest guest(folder_ / "control");
    guest.say("reload 30s\nstatus\n");
    pass(kMs);
    EXPECT_EQ(guest.read(),
              R"({"type":"error","error":"\"reload\" is refused: this socket only tells, and what )"
              R"(changes something goes to /run/tribus/car/control; allowed here: )"
              R"(\"watch [PERIOD]\", \"status\""})"
              "\n{\"n\":1,\"fill\":\"\"}\n");
}

TEST_F(Control, AnswersSeveralRequestsInOrder) {
    Guest guest(folder_ / "control");
    guest.say("status\nstatus\r\nstatus\n");
    pass(kMs);
    EXPECT_EQ(guest.read(),
              "{\"n\":1,\"fill\":\"\"}\n{\"n\":2,\"fill\":\"\"}\n{\"n\":3,\"fill\":\"\"}\n");
}

TEST_F(Control, WaitsForTheRestOfHalfARequest) {
    Guest guest(folder_ / "control");
    guest.say("sta");
    pass(kMs);
    EXPECT_EQ(guest.read(), "");
    guest.say("tus\n");
    pass(kMs);
    EXPECT_EQ(guest.read(), "{\"n\":1,\"fill\":\"\"}\n");
}

TEST_F(Control, AnswersOneWhoSaysNoMoreAndClosesThen) {
    Guest guest(folder_ / "control");
    guest.say("status\n");
    guest.say_no_more();
    pass_in_steps(2, kMs);
    EXPECT_EQ(guest.read(), "{\"n\":1,\"fill\":\"\"}\n(closed)");
}

TEST_F(Control, RefusesWhatIsNoRequestAndSaysWhatIs) {
    Guest guest(folder_ / "control");
    guest.say("stauts\n");
    pass(kMs);
    EXPECT_EQ(guest.read(),
              "{\"type\":\"error\",\"error\":\"\\\"stauts\\\" is not a request; allowed: "
              "\\\"watch [PERIOD]\\\", \\\"status\\\"\"}\n");
}

/// A slow answer does not delay other clients. The next request of the same client waits for the
/// answer, even if that request is too long.
TEST_F(Control, AnswersLateWhatTakesAWhile) {
    bool done = false;
    control_->add_late("work", [&](auto) -> ControlServer::LateAnswer {
        return [&] { return done ? std::optional<std::string>("{\"done\":true}") : std::nullopt; };
    });
    Guest patient(folder_ / "control");
    Guest other(folder_ / "control");
    patient.say("work\nstatus\n" + std::string(300, 'x') + "\n");
    patient.say_no_more();
    pass_in_steps(5, kMs);
    EXPECT_EQ(patient.read(), "");
    other.say("status\n");
    pass(kMs);
    EXPECT_EQ(other.read(), "{\"n\":1,\"fill\":\"\"}\n");
    done = true;
    pass_in_steps(5, kMs);
    EXPECT_EQ(patient.read().find("{\"done\":true}\n{\"n\":2,\"fill\":\"\"}\n"), 0U);
}

TEST_F(Control, GarbageGetsAnAnswerThatIsText) {
    Guest guest(folder_ / "control");
    guest.say(std::string("\0\xff\xfe\x1b[2J\n", 8));
    pass(kMs);
    const std::string answer = guest.read();
    EXPECT_NE(answer.find("is not a request"), std::string::npos) << answer;
    EXPECT_EQ(answer.find('\x1b'), std::string::npos);
    EXPECT_EQ(answer.find('\xff'), std::string::npos);
}

TEST_F(Control, ARequestWithoutEndIsRefusedAndItsSenderDropped) {
    Guest guest(folder_ / "control");
    guest.say(std::string(100000, 'x'));
    pass(kMs);
    EXPECT_NE(guest.read().find("at most 255 bytes"), std::string::npos);
    pass_in_steps(2, kMs);
    EXPECT_TRUE(control_->watched()) << "more may come, which would reset the answer";
    pass_in_steps(3, 1000 * kMs);
    EXPECT_FALSE(control_->watched());
}

TEST_F(Control, WatchRepeatsAtItsPeriod) {
    Guest guest(folder_ / "control");
    guest.say("watch 100ms\n");
    pass(kMs);
    EXPECT_EQ(guest.read(), "{\"n\":1,\"fill\":\"\"}\n");
    EXPECT_EQ(control_->due(), now_ + 100 * kMs);
    pass(99 * kMs);
    EXPECT_EQ(guest.read(), "");
    pass(kMs);
    EXPECT_EQ(guest.read(), "{\"n\":2,\"fill\":\"\"}\n");
}

TEST_F(Control, WatchRefusesAPeriodThatIsNone) {
    Guest guest(folder_ / "control");
    guest.say("watch 1us\nwatch soon\nwatch 1s 2s\n");
    pass(kMs);
    const std::string answers = guest.read();
    EXPECT_EQ(std::count(answers.begin(), answers.end(), '\n'), 3);
    EXPECT_EQ(answers.find("\"n\""), std::string::npos) << answers;
}

/// Only the latest object counts: one that a client does not read in time is not kept.
TEST_F(Control, OneWhoDoesNotReadMissesObjectsAndGetsAFreshOneAfterwards) {
    Guest guest(folder_ / "control");
    guest.say("watch 100ms\n");
    pass(kMs);
    pass_in_steps(50, 100 * kMs);
    EXPECT_EQ(guest.read(), "{\"n\":1,\"fill\":\"\"}\n");
    pass(100 * kMs);
    EXPECT_EQ(guest.read(), "{\"n\":2,\"fill\":\"\"}\n");
}

TEST_F(Control, OneWhoNeverReadsIsDroppedAfterTenSeconds) {
    Guest guest(folder_ / "control");
    guest.say("watch 100ms\n");
    pass(kMs);
    pass_in_steps(99, 100 * kMs);
    EXPECT_TRUE(control_->watched());
    pass_in_steps(2, 100 * kMs);
    EXPECT_FALSE(control_->watched());
}

TEST_F(Control, AnObjectThatDoesNotFitIsSentInPartsAndWhole) {
    fill_ = std::string(2'000'000, 'y');
    Guest guest(folder_ / "control");
    guest.say("watch 100ms\n");
    pass(kMs);
    std::string all = guest.read();
    EXPECT_LT(all.size(), fill_.size());
    while (all.find('\n') == std::string::npos && now_ < Instant{} + std::chrono::hours(2)) {
        pass(kMs);
        all += guest.read();
    }
    EXPECT_EQ(all, "{\"n\":1,\"fill\":\"" + fill_ + "\"}\n");
}

TEST_F(Control, OneWhoAsksNothingIsDroppedAfterAMinute) {
    Guest guest(folder_ / "control");
    pass(kMs);
    EXPECT_TRUE(control_->watched());
    EXPECT_EQ(control_->due(), now_ + std::chrono::seconds(60));
    pass(std::chrono::seconds(60));
    EXPECT_FALSE(control_->watched());
    EXPECT_EQ(guest.read(), "(closed)");
}

TEST_F(Control, OneWhoLeavesMakesRoom) {
    Guest guest(folder_ / "control");
    guest.say("watch 60s\n");
    pass(kMs);
    EXPECT_TRUE(control_->watched());
    guest.leave();
    pass(kMs);
    EXPECT_FALSE(control_->watched());
}

TEST_F(Control, ServesSixteenAndTellsTheNextOneThatItIsTooMany) {
    std::deque<Guest> guests;
    for (int i = 0; i < 16; ++i) {
        guests.emplace_back(folder_ / "control").say("watch 100ms\n");
        pass(kMs);
    }
    Guest one_more(folder_ / "control");
    pass(kMs);
    EXPECT_EQ(one_more.read(),
              "{\"type\":\"error\",\"error\":\"too many clients; try again later\"}\n(closed)");
    pass(100 * kMs);
    for (Guest& guest : guests) {
        EXPECT_NE(guest.read().find("\"n\""), std::string::npos);
    }
}

TEST_F(Control, LongestQuietOfSixteenWhoAskNothingGivesWay) {
    std::deque<Guest> guests;
    for (int i = 0; i < 16; ++i) {
        guests.emplace_back(folder_ / "control");
        pass(kMs);
    }
    guests.front().say("status\n");
    pass(kMs);
    EXPECT_NE(guests.front().read(), "");
    Guest one_more(folder_ / "control");
    one_more.say("status\n");
    pass(kMs);
    EXPECT_EQ(one_more.read(), "{\"n\":2,\"fill\":\"\"}\n");
    EXPECT_EQ(guests[0].read(), "");
    EXPECT_EQ(guests[1].read(), "(closed)");
    EXPECT_EQ(guests[2].read(), "");
}

/// A reload gets in, no matter how many places another user has taken.
TEST_F(Control, OneOfSixteenWhoWatchGivesWayToAnotherUser) {
    if (::geteuid() != 0) {
        GTEST_SKIP() << "only root can be somebody else";
    }
    ::chmod(folder_.path().c_str(), 0755);
    ::chmod((folder_ / "control").c_str(), 0666);
    std::deque<Guest> guests;
    constexpr uid_t kNobody = 65534;
    ASSERT_EQ(::seteuid(kNobody), 0);
    for (int i = 0; i < 16; ++i) {
        guests.emplace_back(folder_ / "control").say("watch 1s\n");
        pass(kMs);
    }
    Guest of_the_same(folder_ / "control");
    ASSERT_EQ(::seteuid(0), 0);
    pass(kMs);
    EXPECT_NE(of_the_same.read().find("too many clients"), std::string::npos);
    Guest of_another(folder_ / "control");
    of_another.say("status\n");
    pass(kMs);
    EXPECT_NE(of_another.read().find("\"n\":17"), std::string::npos);
}

TEST_F(Control, OneWhoDoesNotReadTakesNothingFromOthers) {
    Guest silent(folder_ / "control");
    silent.say("watch 50ms\n");
    Guest reader(folder_ / "control");
    reader.say("watch 100ms\n");
    pass(kMs);
    for (int i = 0; i < 10; ++i) {
        reader.read();
        pass(100 * kMs);
        EXPECT_NE(reader.read(), "");
    }
}

}  // namespace
}  // namespace tribus::control_server_test
