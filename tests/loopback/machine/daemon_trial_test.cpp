#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/machine/hanging_file.h"
#include "tests/loopback/machine/running_daemon.h"

/// Configurations on trial, and what becomes of them.
namespace tribus::test::daemon_trial_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

/// `servos` runs; `motors` is on trial.
class TrialOfADaemon : public RunningDaemon {
  protected:
    void begin(Duration time = 1000s) {
        start();
        const Instant before = monotonic_now();
        const ReloadOutcome outcome = reload(job("motors"), time);
        EXPECT_TRUE(outcome.taken);
        EXPECT_EQ(outcome.trial, 1U);
        EXPECT_GE(daemon_->due(), before + time);
        EXPECT_LE(daemon_->due(), monotonic_now() + time);
        manager_.told();
    }
    void TearDown() override {
        EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
    }
    void hang_up() {
        daemon_->note_hang_up();
        // The reload before it may have been just now.
        daemon_->go_on(std::max(daemon_->due(), monotonic_now()));
        EXPECT_GE(daemon_->descriptor(), 0);
        go_on_when_done(monotonic_now());
    }
    nlohmann::json status() { return nlohmann::json::parse(answer("status")); }
};

class TrialOfADraft : public TrialOfADaemon {
  protected:
    void begin_draft() {
        start();
        EXPECT_EQ(reload_draft(job("motors"), 1000s).trial, 1U);
        EXPECT_EQ(output_name(), "motors");
        manager_.told();
    }
};

TEST_F(TrialOfADaemon, HasANumberAndAnEnd) {
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    begin(10s);
    EXPECT_EQ(daemon_->trial(), 1U);
    EXPECT_EQ(output_name(), "motors");
    EXPECT_EQ(said("on trial"), "on trial for 10 s: without confirmation the daemon goes back\n");
    EXPECT_EQ(said("reloaded"), "");
    EXPECT_EQ(status()["trial"], 1);
    EXPECT_GT(status()["trial_left_us"], 0);
    EXPECT_LE(status()["trial_left_us"], 10'000'000);
}

TEST_F(TrialOfADaemon, IsToldInWholeSecondsRoundedUp) {
    begin(1500ms);
    EXPECT_EQ(said("on trial for 2 s:"),
              "on trial for 2 s: without confirmation the daemon goes back\n");
}

TEST_F(TrialOfADaemon, EndsByItselfAtItsEndAndNotBefore) {
    begin(10s);
    const Instant end = daemon_->due();
    daemon_->go_on(end - 1ns);
    EXPECT_EQ(daemon_->trial(), 1U);
    EXPECT_EQ(daemon_->descriptor(), -1);
    daemon_->go_on(end);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_GE(daemon_->descriptor(), 0);
    EXPECT_EQ(daemon_->due(), kNever) << "it goes back, however long that takes";
    EXPECT_TRUE(has_said("the trial was not confirmed\ngoing back to the configuration before; " +
                         file_ + " still holds the one that was on trial\n"))
        << logged_.text();
    go_on_when_done(end);
    EXPECT_EQ(output_name(), "servos");
    EXPECT_TRUE(status()["trial"].is_null());
    EXPECT_TRUE(status()["trial_left_us"].is_null());
    const Lines told = manager_.told();
    ASSERT_EQ(told.size(), 2U);
    EXPECT_TRUE(told[0].starts_with("RELOADING=1\n"));
    EXPECT_EQ(told[1], "READY=1");
}

TEST_F(TrialOfADaemon, StaysIfConfirmed) {
    begin();
    const auto change = daemon_->begin_confirming();
    EXPECT_EQ(change, 2U);
    ASSERT_TRUE(daemon_->outcome_of(2)) << "at once";
    EXPECT_TRUE(daemon_->outcome_of(2)->taken);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_EQ(daemon_->due(), kNever);
    EXPECT_TRUE(status()["trial"].is_null());
    EXPECT_EQ(said("confirmed"), "confirmed: the configuration stays\n");
    EXPECT_EQ(manager_.told(), Lines{});
    EXPECT_EQ(output_name(), "motors");
}

TEST_F(TrialOfADaemon, GoesBackWhereAsked) {
    begin();
    const std::uint64_t change = daemon_->begin_going_back().value();
    EXPECT_EQ(change, 2U);
    EXPECT_EQ(daemon_->outcome_of(1)->trial, 1U) << "its outcome is still known";
    EXPECT_TRUE(outcome_of(change).taken);
    EXPECT_EQ(output_name(), "servos");
    EXPECT_EQ(said("the trial was"), "");
}

TEST_F(TrialOfADaemon, AfterATrialGoesBackToWhatWasConfirmedLast) {
    begin();
    EXPECT_EQ(reload(job("wheels"), 500s).trial, 2U);
    EXPECT_EQ(daemon_->trial(), 2U);
    outcome_of(daemon_->begin_going_back());
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(TrialOfADaemon, IsEndedByAReloadThatIsNone) {
    begin();
    const ReloadOutcome outcome = reload(job("wheels"));
    EXPECT_TRUE(outcome.taken);
    EXPECT_EQ(outcome.trial, std::nullopt);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_EQ(daemon_->due(), kNever);
    EXPECT_EQ(said("still on trial"), "");
}

TEST_F(TrialOfADaemon, OutlastsAReloadThatIsRefused) {
    begin();
    const ReloadOutcome outcome =
        reload(job("wheels") + "[output.more]\nprotocol = \"sbus\"\ndevice = \"" +
               (folder_ / "nobody") + "\"\n[pipeline.more]\nfrom = \"receiver\"\nto = \"more\"\n");
    EXPECT_FALSE(outcome.taken);
    EXPECT_EQ(outcome.trial, std::nullopt);
    EXPECT_EQ(daemon_->trial(), 1U);
    EXPECT_EQ(output_name(), "motors");
}

TEST_F(TrialOfADaemon, IsNotConfirmedByAHangUp) {
    begin();
    const Instant end = daemon_->due();
    write(job("wheels"));
    hang_up();
    EXPECT_EQ(output_name(), "wheels");
    EXPECT_EQ(said("still on trial"), "still on trial: SIGHUP does not confirm it\n");
    EXPECT_EQ(daemon_->trial(), 1U);
    EXPECT_EQ(daemon_->due(), end);
    EXPECT_EQ(daemon_->outcome_of(2)->trial, 1U);
    outcome_of(daemon_->begin_going_back());
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(TrialOfADaemon, EndsAmidAReloadWhichIsAbandoned) {
    begin(10s);
    const Instant end = daemon_->due();
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_reload(), 2U);
    EXPECT_EQ(daemon_->due(), end);
    daemon_->go_on(end);
    const auto abandoned = daemon_->outcome_of(2);
    ASSERT_TRUE(abandoned);
    EXPECT_FALSE(abandoned->taken);
    EXPECT_EQ(abandoned->lines, Lines{"abandoned: the daemon went back from the trial before it"});
    go_on_when_done(end);
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(TrialOfADaemon, LeavesAReloadItsMinute) {
    begin();
    const Instant end = daemon_->due();
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_reload(), 2U);
    EXPECT_LT(daemon_->due(), end - 900s);
    EXPECT_EQ(daemon_->begin_confirming(), std::nullopt) << "one change at a time";
    EXPECT_EQ(daemon_->trial(), 1U);
}

TEST_F(TrialOfADaemon, EndsAtItsEndAlthoughAHangUpWaits) {
    begin(10s);
    const Instant end = daemon_->due();
    daemon_->note_hang_up();
    EXPECT_LT(daemon_->due(), end);
    daemon_->go_on(end);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    go_on_when_done(end);
    EXPECT_EQ(output_name(), "servos");
    EXPECT_EQ(daemon_->due(), end + 100ms) << "the hang-up has its turn then";
}

TEST_F(TrialOfADaemon, GoesBackWithAStopWhereADeviceIsGone) {
    const FarEnd more(folder_ / "more");
    start(job("servos"));
    std::string text = job("motors");
    text.replace(text.find(servos_.path()), servos_.path().size(), more.path());
    ASSERT_EQ(reload(text, 1000s).trial, 1U);
    servos_.pull();
    said("");
    const ReloadOutcome outcome = outcome_of(daemon_->begin_going_back());
    EXPECT_TRUE(outcome.taken);
    EXPECT_EQ(output_name(), "servos");
    EXPECT_TRUE(has_said("starting it anyway, with a stop: outputs go into failsafe\nstarted "))
        << logged_.text();
    EXPECT_EQ(status()["outputs"][0]["name"], "servos");
    daemon_->look(monotonic_now());
    EXPECT_EQ(manager_.told().back().substr(0, 14), "STATUS=servos:");
}

TEST_F(TrialOfADaemon, GoesBackWithoutAStopWhereNothingIsGone) {
    begin();
    said("");
    EXPECT_TRUE(outcome_of(daemon_->begin_going_back()).taken);
    EXPECT_EQ(said("starting it anyway"), "");
}

TEST_F(TrialOfADraft, IsReadAsIfTheFileHadIt) {
    start();
    testing::internal::CaptureStderr();
    const ReloadOutcome outcome = reload_draft("[", 10s);
    testing::internal::GetCapturedStderr();
    EXPECT_FALSE(outcome.taken);
    EXPECT_EQ(outcome.lines.front().find(file_ + ":1:"), 0U) << outcome.lines.front();
    EXPECT_EQ(daemon_->trial(), std::nullopt);
}

TEST_F(TrialOfADraft, EndsAtTheFile) {
    begin_draft();
    outcome_of(daemon_->begin_going_back());
    EXPECT_EQ(output_name(), "servos");
    EXPECT_EQ(said("going back"),
              "going back to the configuration before, which " + file_ + " still holds\n");
}

TEST_F(TrialOfADraft, StaysOnlyIfTheFileHasIt) {
    begin_draft();
    const ReloadOutcome refused = outcome_of(daemon_->begin_confirming());
    EXPECT_FALSE(refused.taken);
    EXPECT_EQ(refused.lines,
              Lines{file_ + " does not have the text of the draft that is on trial; write "
                            "it there, then confirm"});
    EXPECT_EQ(daemon_->trial(), 1U);
    write(job("motors"));
    const ReloadOutcome kept = outcome_of(daemon_->begin_confirming());
    EXPECT_TRUE(kept.taken);
    EXPECT_EQ(kept.lines, Lines{});
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_EQ(said("confirmed"), "confirmed: the configuration stays\n");
    EXPECT_EQ(manager_.told(), Lines{}) << "nothing was reloaded";
}

TEST_F(TrialOfADraft, GoesOnIfTheFileIsGone) {
    begin_draft();
    std::filesystem::remove(file_);
    const ReloadOutcome refused = outcome_of(daemon_->begin_confirming());
    EXPECT_FALSE(refused.taken);
    EXPECT_EQ(refused.lines, Lines{file_ + ": cannot be read: No such file or directory; give the "
                                           "path of a configuration file"});
    EXPECT_EQ(daemon_->trial(), 1U);
}

TEST_F(TrialOfADraft, GoesOnIfTheFileIsNotReadWithinAMinute) {
    begin_draft();
    said("");
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_confirming(), 2U);
    daemon_->go_on(daemon_->due());
    const auto refused = daemon_->outcome_of(2);
    ASSERT_TRUE(refused);
    EXPECT_FALSE(refused->taken);
    EXPECT_EQ(refused->lines, Lines{file_ + ": was not read within a minute"});
    EXPECT_EQ(daemon_->trial(), 1U);
    EXPECT_EQ(said(""), "") << "no reload is refused";
}

/// Then the text of the file is on trial, and the file has it.
TEST_F(TrialOfADraft, IsNoneOfADraftAfterAHangUp) {
    begin_draft();
    hang_up();
    EXPECT_EQ(output_name(), "servos");
    EXPECT_TRUE(daemon_->outcome_of(daemon_->begin_confirming().value())->taken);
}

}  // namespace
}  // namespace tribus::test::daemon_trial_test
