#include "app/daemon/control_requests.h"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/show/effective.h"
#include "tests/loopback/machine/hanging_file.h"
#include "tests/loopback/machine/running_daemon.h"

/// Requests at the control socket that change something, with their whole answers.
namespace tribus::test::control_requests_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

std::string error(const std::string& text) {
    return nlohmann::ordered_json{{"type", "error"}, {"error", text}}.dump();
}

const std::string kTaken = R"({"type":"outcome","taken":true,"lines":[],"trial":null})";
const std::string kOnTrial1 = R"({"type":"outcome","taken":true,"lines":[],"trial":1})";

class ControlRequest : public RunningDaemon {
  protected:
    void TearDown() override {
        EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
    }
    void begin_trial() {
        start();
        write(job("motors"));
        EXPECT_EQ(answer("reload 1000s"), kOnTrial1);
    }
    mode_t draft_folder_mode() const {
        struct stat folder {};
        EXPECT_EQ(::stat((folder_ / "draft").c_str(), &folder), 0);
        return folder.st_mode & 07777U;
    }
};

TEST_F(ControlRequest, ReloadTakesTheFile) {
    start();
    write(job("motors"));
    EXPECT_EQ(answer("reload"), kTaken);
    EXPECT_EQ(output_name(), "motors");
    EXPECT_EQ(daemon_->outcome_of(2), std::nullopt) << "it was one change";
}

TEST_F(ControlRequest, ReloadNamesEachMistake) {
    start();
    write("[output");
    testing::internal::CaptureStderr();
    const auto outcome = nlohmann::json::parse(answer("reload"));
    testing::internal::GetCapturedStderr();
    EXPECT_EQ(outcome["taken"], false);
    EXPECT_EQ(outcome["lines"].size(), 1U);
    EXPECT_EQ(outcome["lines"][0].get<std::string>().find(file_ + ":1:"), 0U) << outcome;
    EXPECT_TRUE(outcome["trial"].is_null());
}

TEST_F(ControlRequest, ReloadOnTrialTakesFromASecondToAnHour) {
    start();
    EXPECT_EQ(answer("reload 1s"), kOnTrial1);
    EXPECT_EQ(answer("reload 3600s"), R"({"type":"outcome","taken":true,"lines":[],"trial":2})");
}

TEST_F(ControlRequest, ReloadTakesNothingElse) {
    start();
    for (const char* request : {"reload 999ms", "reload 3601s", "reload soon", "reload 1s 1s",
                                "reload draft", "reload draft 999ms", "reload draft 3601s",
                                "reload draft 1s 1s", "reload 1s draft", "reload 1s 1s 1s"}) {
        EXPECT_EQ(answer(request),
                  error("\"reload\" takes the length of a trial, from \"1s\" to \"3600s\", or "
                        "nothing; \"reload draft\" needs it"))
            << request;
    }
    EXPECT_EQ(daemon_->outcome_of(1), std::nullopt);
}

TEST_F(ControlRequest, ReloadDraftTakesTheDraft) {
    start();
    write_draft(job("motors"));
    EXPECT_EQ(answer("reload draft 1000s"), kOnTrial1);
    EXPECT_EQ(output_name(), "motors");
}

TEST_F(ControlRequest, ReloadWaitsForTheChangeThatIsUnderWay) {
    start();
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_reload(), 1U);
    Guest guest(folder_ / "control");
    guest.say("reload 100s\n");
    for (int i = 0; i < 3; ++i) {
        daemon_->go_on(monotonic_now());
        serve();
    }
    EXPECT_EQ(guest.read(), "");
    file.answer();
    EXPECT_EQ(answer_to(guest), kOnTrial1);
    EXPECT_TRUE(daemon_->outcome_of(2));
}

TEST_F(ControlRequest, DraftMakesItsFolderForUserAndGroup) {
    start();
    const std::string made =
        nlohmann::ordered_json{{"type", "draft"}, {"file", folder_ / "draft/draft.toml"}}.dump();
    EXPECT_EQ(answer("draft"), made);
    EXPECT_EQ(draft_folder_mode(), 0770U);
    fs::permissions(folder_ / "draft", fs::perms::owner_all);
    EXPECT_EQ(answer("draft"), made) << "it is there";
    EXPECT_EQ(draft_folder_mode(), 0770U);
}

TEST_F(ControlRequest, DraftIsRefusedWhereAFileOrALinkIsInTheWay) {
    start();
    std::ofstream(folder_ / "draft") << "mine";
    EXPECT_EQ(answer("draft"), error((folder_ / "draft") + ": Not a directory"));
    fs::remove(folder_ / "draft");
    fs::create_directory(folder_ / "other");
    fs::create_directory_symlink(folder_ / "other", folder_ / "draft");
    EXPECT_EQ(answer("draft"), error((folder_ / "draft") + ": Not a directory"));
}

TEST_F(ControlRequest, DraftIsRefusedWhereTheFolderAboveIsGone) {
    start();
    Guest guest(folder_ / "control");
    serve();
    fs::remove_all(folder_.path());
    guest.say("draft\n");
    EXPECT_EQ(answer_to(guest), error((folder_ / "draft") + ": No such file or directory"));
}

TEST_F(ControlRequest, ConfirmAndBackNeedATrial) {
    start();
    EXPECT_EQ(answer("confirm"), error("no configuration is on trial"));
    EXPECT_EQ(answer("confirm 1"), error("no configuration is on trial"));
    EXPECT_EQ(answer("back"), error("no configuration is on trial"));
    EXPECT_EQ(answer("back 1"), error("no configuration is on trial"));
}

TEST_F(ControlRequest, ConfirmAndBackTakeNoOtherTrialThanThePresentOne) {
    begin_trial();
    for (const char* request : {"confirm 2", "confirm one", "confirm 1 1", "confirm 2 1", "back 2",
                                "back 1 1", "back 2 1", "back one"}) {
        EXPECT_EQ(answer(request), error("that trial is over; the present one is number 1"))
            << request;
    }
    EXPECT_EQ(daemon_->trial(), 1U);
}

TEST_F(ControlRequest, ConfirmKeepsThePresentTrial) {
    begin_trial();
    EXPECT_EQ(answer("confirm"), kTaken);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_EQ(output_name(), "motors");
}

TEST_F(ControlRequest, ConfirmKeepsATrialByItsNumber) {
    begin_trial();
    EXPECT_EQ(answer("confirm 1"), kTaken);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
}

TEST_F(ControlRequest, ConfirmOfADraftSaysWhyNot) {
    start();
    write_draft(job("motors"));
    EXPECT_EQ(answer("reload draft 1000s"), kOnTrial1);
    EXPECT_EQ(answer("confirm"),
              error(file_ + " does not have the text of the draft that is on trial; "
                            "write it there, then confirm"));
    EXPECT_EQ(daemon_->trial(), 1U);
    write(job("motors"));
    EXPECT_EQ(answer("confirm"), kTaken);
}

/// While it waits for a reload, the trial that it means is replaced.
TEST_F(ControlRequest, ConfirmKeepsNoTrialThatBeginsLater) {
    begin_trial();
    HangingFile file(file_);
    ASSERT_EQ(daemon_->begin_reload(500s), 2U);
    Guest guest(folder_ / "control");
    guest.say("confirm\n");
    serve();
    EXPECT_EQ(guest.read(), "");
    file.answer();
    EXPECT_EQ(answer_to(guest), error("that trial is over; the present one is number 2"));
    EXPECT_EQ(daemon_->trial(), 2U);
}

TEST_F(ControlRequest, BackEndsThePresentTrial) {
    begin_trial();
    EXPECT_EQ(answer("back"), kTaken);
    EXPECT_EQ(daemon_->trial(), std::nullopt);
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(ControlRequest, BackEndsATrialByItsNumber) {
    begin_trial();
    EXPECT_EQ(answer("back 1"), kTaken);
    EXPECT_EQ(output_name(), "servos");
}

TEST_F(ControlRequest, ConfigurationIsTheWholeOneOnBothSockets) {
    start();
    const std::string whole =
        nlohmann::ordered_json{{"type", "configuration"},
                               {"file", file_},
                               {"toml", effective_toml(daemon_->configuration())}}
            .dump();
    EXPECT_EQ(answer("configuration"), whole);
    EXPECT_EQ(answer_at("look", "configuration"), whole);
}

TEST_F(ControlRequest, IsRefusedByADaemonThatRunsNothing) {
    const std::string nothing = error("nothing runs any more");
    EXPECT_EQ(answer("configuration"), nothing);
    EXPECT_EQ(answer_at("look", "configuration"), nothing);
    EXPECT_EQ(answer("reload"), nothing);
    EXPECT_EQ(answer("confirm"), error("no configuration is on trial"));
    EXPECT_EQ(answer("back"), error("no configuration is on trial"));
    EXPECT_EQ(manager_.told(), std::vector<std::string>{});
    EXPECT_EQ(daemon_->descriptor(), -1);
}

TEST_F(ControlRequest, ThatChangesSomethingIsNoneOfTheSocketThatOnlyTells) {
    start();
    for (const char* request : {"reload", "back", "draft", "confirm"}) {
        EXPECT_EQ(
            answer_at("look", request),
            error("\"" + std::string(request) +
                  "\" is refused: this socket only tells, and what changes something goes to " +
                  (folder_ / "control") +
                  "; allowed here: \"watch [PERIOD]\", \"changes\", \"configuration\", "
                  "\"histograms\", "
                  "\"metrics\", \"record\", \"recordings\", \"status\""));
    }
}

TEST_F(ControlRequest, ThatIsNoneGetsTheListOfAll) {
    start();
    EXPECT_EQ(
        answer("stop"),
        error("\"stop\" is not a request; allowed: \"watch [PERIOD]\", \"back\", \"changes\", "
              "\"configuration\", \"confirm\", \"draft\", \"histograms\", \"metrics\", "
              "\"record\", \"recordings\", \"reload\", \"status\""));
}

}  // namespace
}  // namespace tribus::test::control_requests_test
