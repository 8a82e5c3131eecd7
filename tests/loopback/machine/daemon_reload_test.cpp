#include <poll.h>
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/machine/hanging_file.h"
#include "tests/loopback/machine/running_daemon.h"

/// Reloads of a daemon, in the test's own time where that matters.
namespace tribus::test::daemon_reload_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

/// As long as it is there, this program opens nothing.
class NoDescriptors {
  public:
    NoDescriptors() {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        const rlimit none{.rlim_cur = 3, .rlim_max = before_.rlim_max};
        ::setrlimit(RLIMIT_NOFILE, &none);
    }
    NoDescriptors(const NoDescriptors&) = delete;
    NoDescriptors& operator=(const NoDescriptors&) = delete;
    ~NoDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

  private:
    rlimit before_{};
};

class DaemonReload : public RunningDaemon {
  protected:
    void TearDown() override {
        EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
    }
    static bool is_readable(int descriptor) {
        pollfd state{.fd = descriptor, .events = POLLIN, .revents = 0};
        return ::poll(&state, 1, 30'000) == 1;
    }
    static constexpr std::string_view kOther = "[runtime]\nrealtime = \"off\"\npriority = 70\n";
};
class HangUp : public DaemonReload {};

TEST_F(DaemonReload, TakesTheFileAsItIsNow) {
    start();
    manager_.told();
    write(job("motors"));
    EXPECT_EQ(daemon_->descriptor(), -1);
    EXPECT_EQ(daemon_->due(), kNever);
    const auto change = daemon_->begin_reload();
    EXPECT_EQ(change, 1U);
    EXPECT_GE(daemon_->descriptor(), 0);
    const ReloadOutcome outcome = outcome_of(change);
    EXPECT_TRUE(outcome.taken);
    EXPECT_EQ(outcome.lines, Lines{});
    EXPECT_EQ(outcome.trial, std::nullopt);
    EXPECT_EQ(daemon_->descriptor(), -1);
    EXPECT_EQ(daemon_->due(), kNever);
    EXPECT_EQ(output_name(), "motors");
    EXPECT_EQ(said("reloaded"), "reloaded " + file_ + ": 1 input, 1 output, 1 pipeline\n");
    const Lines told = manager_.told();
    ASSERT_EQ(told.size(), 2U);
    EXPECT_TRUE(told[0].starts_with("RELOADING=1\nMONOTONIC_USEC=")) << told[0];
    EXPECT_EQ(told[1], "READY=1");
    EXPECT_EQ(nlohmann::json::parse(answer("status"))["outputs"][0]["name"], "motors");
    EXPECT_EQ(daemon_->begin_reload(), 2U);
}

TEST_F(DaemonReload, IsTheOnlyChangeAtATime) {
    start();
    HangingFile file(file_);
    const auto change = daemon_->begin_reload();
    daemon_->go_on(monotonic_now());
    EXPECT_EQ(daemon_->outcome_of(1), std::nullopt);
    EXPECT_EQ(daemon_->begin_reload(), std::nullopt);
    EXPECT_EQ(daemon_->begin_reload_of_draft(1s), std::nullopt);
    file.answer();
    EXPECT_TRUE(outcome_of(change).taken);
}

TEST_F(DaemonReload, IsRefusedIfTheFileWasNotReadWithinAMinute) {
    start();
    manager_.told();
    HangingFile file(file_);
    const Instant before = monotonic_now();
    ASSERT_EQ(daemon_->begin_reload(), 1U);
    const Instant due = daemon_->due();
    EXPECT_GE(due, before + 60s);
    EXPECT_LE(due, monotonic_now() + 60s);
    daemon_->go_on(due - 1ns);
    EXPECT_EQ(daemon_->outcome_of(1), std::nullopt);
    daemon_->go_on(due);
    const auto outcome = daemon_->outcome_of(1);
    ASSERT_TRUE(outcome);
    EXPECT_FALSE(outcome->taken);
    EXPECT_EQ(outcome->lines, Lines{file_ + ": was not read within a minute"});
    EXPECT_EQ(daemon_->descriptor(), -1);
    EXPECT_EQ(said("reload refused"), "reload refused: " + file_ +
                                          " cannot be read as a whole; the old configuration "
                                          "runs on\n");
    EXPECT_EQ(manager_.told().back(), "READY=1");
}

TEST_F(DaemonReload, NamesEachMistakeWhereTheFileHasSome) {
    start();
    manager_.told();
    testing::internal::CaptureStderr();
    const ReloadOutcome outcome = reload("[input.receiver]\n[outptu.servos]\n");
    const std::string printed = testing::internal::GetCapturedStderr();
    EXPECT_FALSE(outcome.taken);
    std::string lines;
    for (const std::string& line : outcome.lines) {
        lines += line + "\n";
    }
    EXPECT_EQ(lines.find(file_ + ":1:"), 0U) << lines;
    EXPECT_NE(lines.find("\n" + file_ + ":2:"), std::string::npos) << lines;
    EXPECT_EQ(printed, lines);
    EXPECT_EQ(said("reload refused"),
              "reload refused: " + file_ + " has mistakes; the old configuration runs on\n");
    EXPECT_EQ(manager_.told().back(), "READY=1");
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(DaemonReload, IsRefusedIfTheFileIsGone) {
    start();
    std::filesystem::remove(file_);
    const ReloadOutcome outcome = outcome_of(daemon_->begin_reload());
    EXPECT_FALSE(outcome.taken);
    EXPECT_EQ(outcome.lines, Lines{file_ + ": cannot be read: No such file or directory; give the "
                                           "path of a configuration file"});
    EXPECT_TRUE(has_said(" cannot be read as a whole; the old configuration runs on\n"));
}

TEST_F(DaemonReload, ForADeviceThatIsNotThereIsRefused) {
    start();
    manager_.told();
    const std::string nobody = folder_ / "nobody";
    const ReloadOutcome outcome =
        reload(job("servos") + "[output.more]\nprotocol = \"sbus\"\ndevice = \"" + nobody +
               "\"\n[pipeline.more]\nfrom = \"receiver\"\nto = \"more\"\n");
    EXPECT_FALSE(outcome.taken);
    ASSERT_EQ(outcome.lines.size(), 1U);
    EXPECT_NE(outcome.lines[0].find(nobody), std::string::npos);
    EXPECT_TRUE(has_said(outcome.lines[0] + "\n"));
    EXPECT_EQ(said("reload refused"),
              "reload refused: " + file_ + " cannot be set up; the old configuration runs on\n");
    EXPECT_EQ(manager_.told().back(), "READY=1");
    EXPECT_EQ(daemon_->configuration().outputs.size(), 1U);
}

TEST_F(DaemonReload, ThatChangesTheSchedulingStopsTheOutputsAndSaysWhy) {
    start();
    manager_.told();
    said("");
    const ReloadOutcome outcome = reload(job("servos", std::string(kOther)));
    EXPECT_TRUE(outcome.taken);
    EXPECT_EQ(outcome.lines, Lines{"[runtime] changes the scheduling of the data thread"});
    EXPECT_EQ(daemon_->configuration().runtime.priority, 70);
    EXPECT_EQ(said(""),
              "reload with a stop, outputs go into failsafe: [runtime] changes the scheduling of "
              "the data thread\nstarted " +
                  file_ + ": 1 input, 1 output, 1 pipeline\n");
    EXPECT_EQ(manager_.told().back(), "READY=1");
    EXPECT_EQ(nlohmann::json::parse(answer("status"))["outputs"][0]["name"], "servos");
    daemon_->look(monotonic_now());
}

TEST_F(DaemonReload, WithAStopGoesBackWhereADeviceIsNotThere) {
    start();
    said("");
    const std::string nobody = folder_ / "nobody";
    const ReloadOutcome outcome =
        reload(job("motors", std::string(kOther) +
                                 "[output.more]\nprotocol = \"sbus\"\n"
                                 "device = \"" +
                                 nobody +
                                 "\"\n[pipeline.more]\nfrom = \"receiver\"\n"
                                 "to = \"more\"\n"));
    EXPECT_FALSE(outcome.taken);
    ASSERT_EQ(outcome.lines.size(), 1U);
    EXPECT_NE(outcome.lines[0].find(nobody), std::string::npos);
    EXPECT_TRUE(has_said(outcome.lines[0] + "\nreload failed; back to the old configuration\n"
                                            "started "))
        << logged_.text();
    EXPECT_EQ(output_name(), "servos");
    EXPECT_EQ(nlohmann::json::parse(answer("status"))["outputs"][0]["name"], "servos");
}

TEST_F(DaemonReload, WithAStopWaitsForADeviceOfTheOldOneThatIsGoneMeanwhile) {
    start();
    servos_.pull();
    const ReloadOutcome outcome = reload(job("motors", std::string(kOther)));
    EXPECT_FALSE(outcome.taken);
    EXPECT_TRUE(daemon_->runs());
    EXPECT_EQ(output_name(), "servos");
}

/// The program ends then.
TEST_F(DaemonReload, AfterWhichNothingCanBeStartedEndsAll) {
    start();
    ASSERT_EQ(reload(job("servos"), 100s).trial, 1U);
    const Instant trial_end = daemon_->due();
    write(job("motors", std::string(kOther)));
    ASSERT_EQ(daemon_->begin_reload(), 2U);
    ASSERT_TRUE(is_readable(daemon_->descriptor())) << "it is read and built";
    {
        const NoDescriptors none;
        daemon_->go_on(monotonic_now());
    }
    EXPECT_FALSE(daemon_->runs());
    const std::string nothing = R"({"type":"error","error":"nothing runs any more"})";
    EXPECT_EQ(answer("status"), nothing);
    EXPECT_EQ(answer("reload"), nothing);
    EXPECT_EQ(answer("confirm"), R"({"type":"error","error":"no configuration is on trial"})");
    daemon_->note_hang_up();
    daemon_->go_on(trial_end + 1s);
    EXPECT_EQ(daemon_->descriptor(), -1) << "nothing begins any more";
}

TEST_F(DaemonReload, IsRememberedBehindFifteenOthers) {
    start();
    testing::internal::CaptureStderr();
    for (std::uint64_t number = 1; number <= 16; ++number) {
        reload("[");
        manager_.told();
    }
    EXPECT_TRUE(daemon_->outcome_of(1));
    reload("[");
    testing::internal::GetCapturedStderr();
    EXPECT_FALSE(daemon_->outcome_of(1));
    EXPECT_TRUE(daemon_->outcome_of(2));
    EXPECT_TRUE(daemon_->outcome_of(17));
}

TEST_F(DaemonReload, RepeatsNothingOfAnOutputThatGoesOn) {
    start();
    ASSERT_TRUE(says_under_frames("output servos: under control of receiver\n"));
    EXPECT_NE(said("output servos: "), "");
    EXPECT_TRUE(reload(job("servos", "", "receiver")).taken);
    daemon_->look(monotonic_now());
    EXPECT_EQ(said("output servos: under control"), "");
}

TEST_F(DaemonReload, SaysWhoIsInControlUnderItsNewName) {
    start();
    ASSERT_TRUE(says_under_frames("output servos: under control of receiver\n"));
    EXPECT_TRUE(reload(job("servos", "", "radio")).taken);
    EXPECT_TRUE(says_under_frames("output servos: under control of radio\n"));
}

TEST_F(DaemonReload, OpensADeviceWithOtherLineSettingsAtOnce) {
    start();
    std::string text = job("servos");
    text.replace(text.find("sbus"), 4, "ibus");
    EXPECT_TRUE(reload(text).taken);
    const auto ports = nlohmann::json::parse(answer("status"))["ports"];
    ASSERT_EQ(ports.size(), 2U);
    EXPECT_TRUE(ports[0]["present"]);
    EXPECT_TRUE(ports[1]["present"]);
}

TEST_F(HangUp, BeginsAReloadWithoutANumberForAnybody) {
    start();
    manager_.told();
    write(job("motors"));
    daemon_->note_hang_up();
    EXPECT_EQ(daemon_->due(), Instant{});
    daemon_->go_on(monotonic_now());
    EXPECT_GE(daemon_->descriptor(), 0);
    go_on_when_done(monotonic_now());
    EXPECT_EQ(output_name(), "motors");
    EXPECT_EQ(daemon_->due(), kNever) << "it is done";
    EXPECT_EQ(manager_.told().size(), 2U);
    EXPECT_EQ(said("still on trial"), "");
    EXPECT_EQ(said("confirmed"), "");
}

TEST_F(HangUp, BeginsNoReloadWithin100MsOfTheOneBefore) {
    start();
    const Instant done = monotonic_now();
    daemon_->begin_reload();
    go_on_when_done(done);
    daemon_->note_hang_up();
    EXPECT_EQ(daemon_->due(), done + 100ms);
    daemon_->go_on(done + 100ms - 1ns);
    EXPECT_EQ(daemon_->descriptor(), -1);
    daemon_->go_on(done + 100ms);
    EXPECT_GE(daemon_->descriptor(), 0);
}

TEST_F(HangUp, WaitsForTheChangeThatIsUnderWay) {
    start();
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_reload(), 1U);
    const Instant due = daemon_->due();
    daemon_->note_hang_up();
    daemon_->go_on(monotonic_now());
    EXPECT_EQ(daemon_->due(), due);
    file.answer();
    outcome_of(1);
    EXPECT_LT(daemon_->due(), due) << "it is its turn";
}

}  // namespace
}  // namespace tribus::test::daemon_reload_test
