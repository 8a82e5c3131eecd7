#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/daemon/control_server.h"
#include "tests/loopback/machine/guest.h"
#include "tests/support/temporary_folder.h"

/// Requests of a control server and their words, in virtual time.
namespace tribus::test::control_answers_test {
namespace {

using namespace std::chrono_literals;

class ControlAnswers : public testing::Test {
  protected:
    ControlAnswers() {
        auto opened = ControlServer::open(folder_ / "control");
        EXPECT_TRUE(opened) << opened.error();
        control_ = std::move(*opened);
        control_->add("status", [](auto) { return "status"; });
        control_->add("echo", joined);
        control_->add_late("slowly", [](auto words) {
            return [text = joined(words)] { return std::optional(text); };
        });
    }
    static std::string joined(std::span<const std::string> words) {
        std::string text = "words:";
        for (const std::string& word : words) {
            text += " [" + word + "]";
        }
        return text;
    }
    std::string answer(const std::string& says) {
        Guest guest(folder_ / "control");
        guest.say(says);
        for (int i = 0; i < 3; ++i) {
            control_->serve(now_);
        }
        return guest.read();
    }

    TemporaryFolder folder_;
    std::unique_ptr<ControlServer> control_;
    Instant now_{1h};
};

const std::string kNoPeriod =
    R"({"type":"error","error":"\"watch\" takes a period from \"50ms\" to \"60s\", or none"})"
    "\n";

TEST(ControlServerThatCannotBeOpened, SaysWhy) {
    const TemporaryFolder folder;
    std::ofstream(folder / "file") << "mine";
    const auto taken = ControlServer::open(folder / "file");
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error(),
              (folder / "file") + " exists and is not a socket; choose another --socket");
}

TEST_F(ControlAnswers, GetTheWordsBehindTheName) {
    EXPECT_EQ(answer("echo\n"), "words:\n");
    EXPECT_EQ(answer(" echo  a\tb \n"), "words: [a] [b]\n");
    EXPECT_EQ(answer("slowly a b\n"), "words: [a] [b]\n");
    EXPECT_EQ(answer("slowly\necho\n"), "words:\nwords:\n");
}

TEST_F(ControlAnswers, GiveNothingForAnEmptyLine) {
    EXPECT_EQ(answer("\n  \n\r\necho\n"), "words:\n");
}

TEST_F(ControlAnswers, TakeTheLatestOfTwoOfAName) {
    control_->add("echo", [](auto) { return "other"; });
    EXPECT_EQ(answer("echo\n"), "other\n");
}

TEST_F(ControlAnswers, NameAllRequestsInTheirOrder) {
    EXPECT_EQ(answer("stop now\n"),
              R"({"type":"error","error":"\"stop\" is not a request; allowed: )"
              R"(\"watch [PERIOD]\", \"echo\", \"slowly\", \"status\""})"
              "\n");
}

TEST_F(ControlAnswers, TakeRequestsOf255Bytes) {
    EXPECT_EQ(answer("echo " + std::string(250, 'x') + "\n"),
              "words: [" + std::string(250, 'x') + "]\n");
    const std::string refused =
        R"({"type":"error","error":"a request must have at most 255 bytes"})"
        "\n(closed)";
    EXPECT_EQ(answer("echo " + std::string(251, 'x')), refused);
    EXPECT_EQ(answer("echo\necho " + std::string(300, 'x') + "\n"), "words:\n" + refused);
}

TEST_F(ControlAnswers, WatchFrom50MsToAMinute) {
    for (const auto& [says, period] : {std::pair<const char*, Duration>("watch\n", 200ms),
                                       {"watch 50ms\n", 50ms},
                                       {"watch 60s\n", 60s}}) {
        Guest guest(folder_ / "control");
        guest.say(says);
        control_->serve(now_);
        EXPECT_EQ(guest.read(), "status\n") << says;
        control_->serve(now_ + std::min(period, Duration(5s)) - 1ns);
        EXPECT_EQ(guest.read(), "") << says;
        for (Instant at = now_; at < now_ + period; at += period / 10) {
            control_->serve(at);
        }
        EXPECT_EQ(guest.read(), "") << says;
        control_->serve(now_ + period);
        EXPECT_EQ(guest.read(), "status\n") << says;
        guest.leave();
        control_->serve(now_ + period);
        now_ += 1h;
    }
}

TEST_F(ControlAnswers, WatchAtNoOtherPeriod) {
    for (const char* says :
         {"watch 49ms\n", "watch 61s\n", "watch soon\n", "watch 1s 1s\n", "watch -1s\n"}) {
        EXPECT_EQ(answer(says), kNoPeriod) << says;
    }
}

TEST_F(ControlAnswers, AreKeptForNobodyWhoLeavesMeanwhile) {
    for (const char* says : {"leave\n", "leave_late\n"}) {
        Guest guest(folder_ / "control");
        control_->add("leave", [&](auto) {
            guest.leave();
            return "text";
        });
        control_->add_late("leave_late", [&](auto) {
            return [&] {
                guest.leave();
                return std::optional<std::string>("text");
            };
        });
        guest.say(says);
        control_->serve(now_);
        EXPECT_FALSE(control_->watched()) << says;
    }
}

TEST_F(ControlAnswers, AreWatchedWhileAClientIsThere) {
    EXPECT_FALSE(control_->watched());
    Guest guest(folder_ / "control");
    control_->serve(now_);
    EXPECT_TRUE(control_->watched());
    guest.leave();
    control_->serve(now_);
    EXPECT_FALSE(control_->watched());
}

}  // namespace
}  // namespace tribus::test::control_answers_test
