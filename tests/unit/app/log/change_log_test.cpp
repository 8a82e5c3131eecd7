#include "app/log/change_log.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/log_in_memory.h"

namespace tribus::test::change_log_test {
namespace {

using namespace std::chrono_literals;

/// The log of changes that a test makes. It looks five times a second, as the daemon.
class ChangeLogTest : public testing::Test {
  protected:
    void input(Instant at, const std::string& was, const std::string& now) {
        look_until(at);
        changes_.add({.at = at,
                      .part = "input",
                      .name = "receiver",
                      .field = "cause",
                      .was = was,
                      .now = now,
                      .text = now,
                      .level = now == "good" ? LogLevel::info : LogLevel::warning,
                      .kind = "input"});
    }
    std::string said_until(Instant until) {
        look_until(until);
        return logged_.take_lines([](const std::string& /*line*/) { return true; });
    }

    std::string said_by_flush() {
        log_.flush();
        return logged_.take_lines([](const std::string& /*line*/) { return true; });
    }

    ChangeJournal changes_;

  private:
    void look_until(Instant until) {
        for (; next_ <= until; next_ += 200ms) {
            log_.look(changes_, next_);
        }
    }

    ChangeLog log_;
    LogInMemory logged_{"%l %v"};
    Instant next_{};
};

TEST_F(ChangeLogTest, HasALineForEachChangeAlsoForTwoBetweenTwoLooks) {
    input(Instant(1010ms), "good", "wire_silent");
    input(Instant(1050ms), "wire_silent", "good");
    EXPECT_EQ(said_until(Instant(2s)),
              "warning input receiver: wire_silent\ninfo input receiver: good\n");
    EXPECT_EQ(said_until(Instant(60s)), "");
}

TEST_F(ChangeLogTest, GathersWhatHasNoLineLeftAndItsCountsAddUp) {
    // Six lines in 30 s.
    Instant now(1s);
    for (int loss = 0; loss < 15; ++loss) {
        input(now, "good", "wire_silent");
        input(now + 20ms + loss * 1ms, "wire_silent", "good");
        now += 100ms;
    }
    const std::string lines = said_until(Instant(20s));
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 6) << lines;
    EXPECT_EQ(said_until(Instant(40s)),
              "info input receiver: good (23 changes before this not logged: 12 losses of 23 to 34 "
              "ms in 1.1 s)\n");
    EXPECT_EQ(said_until(Instant(100s)), "");
}

TEST_F(ChangeLogTest, DoesNotSayThatAnInputIsUnprovedWhichTheOutputSays) {
    input(Instant(1s), "never_seen", "unproved");
    EXPECT_EQ(said_until(Instant(2s)), "");
    input(Instant(3s), "unproved", "good");
    EXPECT_EQ(said_until(Instant(4s)), "info input receiver: good\n");
}

/// A backup that returns while another input has control.
TEST_F(ChangeLogTest, CountsLossesAfterWhichNoOutputUsesTheInput) {
    Instant now(1s);
    for (int loss = 0; loss < 10; ++loss) {
        input(now, "unproved", "wire_silent");
        input(now + 20ms, "wire_silent", "unproved");
        now += 100ms;
    }
    const std::string lines = said_until(Instant(20s));
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 6) << lines;
    EXPECT_EQ(said_until(Instant(40s)),
              "warning input receiver: unproved (7 changes before this not logged: 4 losses of 20 "
              "to 20 ms in 0.3 s)\n");
}

TEST_F(ChangeLogTest, SaysAtTheEndWhatHadNoLineLeft) {
    for (int change = 0; change < 8; ++change) {
        input(Instant(1s + change * 100ms), change % 2 == 0 ? "good" : "wire_silent",
              change % 2 == 0 ? "wire_silent" : "good");
    }
    said_until(Instant(5s));
    EXPECT_EQ(said_by_flush(),
              "info input receiver: good (1 change before this not logged: 1 loss of 100 to 100 ms "
              "in 0.1 s)\n");
}

TEST_F(ChangeLogTest, SaysThatAnInputWithTheNameOfAStateHasTakenOver) {
    changes_.add({.at = Instant(1s),
                  .part = "output",
                  .name = "servos",
                  .field = "input",
                  .was = "main",
                  .now = "unproved",
                  .text = "under control of unproved",
                  .level = LogLevel::info,
                  .kind = "output"});
    EXPECT_EQ(said_until(Instant(2s)), "info output servos: under control of unproved\n");
}

TEST_F(ChangeLogTest, DoesNotRepeatASentence) {
    for (int i = 0; i < 2; ++i) {
        changes_.add({.at = Instant(1s),
                      .part = "output",
                      .name = "servos",
                      .field = "state",
                      .now = "failsafe",
                      .text = "in failsafe",
                      .kind = "output"});
    }
    EXPECT_EQ(said_until(Instant(60s)), "warning output servos: in failsafe\n");
}

TEST_F(ChangeLogTest, LeavesOutWhatOthersLog) {
    changes_.add({.part = "value", .name = "pack", .field = "state", .now = "stale"});
    changes_.add({.part = "configuration", .name = "car", .field = "state", .now = "kept"});
    EXPECT_EQ(said_until(Instant(1s)), "");
}

/// As the engine tells 10,000 losses: each has its line, or is counted in one.
TEST_F(ChangeLogTest, CountsTenThousandLosses) {
    constexpr int kLosses = 10'000;
    Instant now(1s);
    for (int loss = 0; loss < kLosses; ++loss) {
        input(now, "good", "wire_silent");
        input(now + 20ms, "wire_silent", "good");
        now += 50ms;
    }
    const std::string lines = said_until(now + 60s);
    std::uint64_t changes = 0;
    const std::regex pattern("input receiver: [a-z_]+(?: \\(([0-9]+) changes? before)?");
    for (std::sregex_iterator line(lines.begin(), lines.end(), pattern), end; line != end; ++line) {
        changes += 1 + ((*line)[1].matched ? std::stoull((*line)[1]) : 0);
    }
    EXPECT_EQ(changes, 2U * kLosses);
}

}  // namespace
}  // namespace tribus::test::change_log_test
