#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <string>
#include <string_view>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/replace_file.h"
#include "app/client/ask_daemon.h"
#include "tests/loopback/first_channel.h"

/// Trials of a text that the configuration file does not have.
namespace tribus::test::draft_test {
namespace {

constexpr std::string_view kReversed = "[pipeline.main.channels]\n1 = { from = 1, reverse = true }";

/// A draft on trial whose text is in `draft_`; channel 1 is 1900.
class DraftOnTrial : public FirstChannel {
  protected:
    std::string socket() const { return folder() / "control"; }
    static void expect_seamless_end(Program& program) {
        EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the reload was not seamless";
        expect_clean_end(program);
    }
    Program& begin_draft() {
        file_ = write_config(main_job(kPatientInput, "", kReversed));
        draft_ = content(file_);
        Program& program = run(write_config(main_job(kPatientInput)));
        before_ = content(file_);
        expect_first_channel(1100);
        EXPECT_EQ(said_by("draft")["type"], "draft");
        std::ofstream(folder() / "draft/draft.toml") << draft_;
        EXPECT_EQ(said_by("reload draft 1000s")["taken"], true);
        expect_first_channel(1900);
        return program;
    }
    static std::string content(const std::string& file) {
        std::ifstream in(file);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    nlohmann::json said_by(std::string_view request) const {
        const auto answer = ask_daemon(socket(), request, kPatience);
        return answer ? *answer : nlohmann::json{{"error", answer.error()}};
    }

    std::string file_;
    std::string draft_;
    std::string before_;
};

/// Otherwise it would run on while the file, which the next start reads, has another text.
TEST_F(DraftOnTrial, IsConfirmedOnlyIfTheFileHasIt) {
    Program& program = begin_draft();
    const std::string refused = file_ +
                                " does not have the text of the draft that is on trial; write it "
                                "there, then confirm";
    EXPECT_EQ(said_by("confirm")["error"], refused);
    EXPECT_EQ(said_by("confirm 1")["error"], refused);
    EXPECT_EQ(said_by("status")["trial"], 1) << "it goes on";
    EXPECT_EQ(content(file_), before_);
    std::ofstream(file_) << draft_;
    EXPECT_EQ(said_by("confirm 1")["taken"], true);
    EXPECT_TRUE(said_by("status")["trial"].is_null());
    expect_first_channel(1900);
    expect_seamless_end(program);
}

/// Who can write the successor may write the file.
TEST_F(DraftOnTrial, TakesThePlaceOfTheFileWithItsSuccessor) {
    Program& program = begin_draft();
    ASSERT_TRUE(write_successor(file_, draft_, 0644));
    EXPECT_EQ(content(file_), before_);
    EXPECT_EQ(said_by("confirm 1")["taken"], true);
    EXPECT_EQ(content(file_), draft_);
    EXPECT_FALSE(std::filesystem::exists(successor_of(file_)));
    EXPECT_TRUE(said_by("status")["trial"].is_null());
    expect_first_channel(1900);
    expect_seamless_end(program);
}

TEST_F(DraftOnTrial, LeavesAFileThatSomebodyChangedMeanwhile) {
    Program& program = begin_draft();
    const std::string others = before_ + "# by hand\n";
    std::ofstream(file_) << others;
    ASSERT_TRUE(write_successor(file_, draft_, 0644));
    EXPECT_EQ(said_by("confirm")["error"],
              file_ + ": was changed by another since the draft went on trial");
    EXPECT_EQ(content(file_), others);
    EXPECT_EQ(said_by("status")["trial"], 1) << "it goes on";
    expect_seamless_end(program);
}

TEST_F(DraftOnTrial, LeavesTheFileIfTheSuccessorHasAnotherText) {
    Program& program = begin_draft();
    ASSERT_TRUE(write_successor(file_, draft_ + "# more\n", 0644));
    EXPECT_NE(said_by("confirm")["error"].get<std::string>().find("does not have the text"),
              std::string::npos);
    EXPECT_EQ(content(file_), before_);
    expect_seamless_end(program);
}

/// Whenever the daemon dies, the file has one text or the other as a whole, and what it said holds.
TEST_F(DraftOnTrial, IsKeptOrNotIfTheDaemonIsKilledWhileItKeeps) {
    int kept = 0;
    constexpr int kKills = 24;
    for (int i = 0; i < kKills; ++i) {
        Program& program = begin_draft();
        ASSERT_TRUE(write_successor(file_, draft_, 0644));
        auto answered = std::async(std::launch::async, [&] { return said_by("confirm 1"); });
        std::this_thread::sleep_for(i * std::chrono::microseconds(150));
        program.signal(SIGKILL);
        const bool taken = answered.get().value("taken", false);
        program.end();
        EXPECT_TRUE(content(file_) == draft_ || (content(file_) == before_ && !taken))
            << "killed after " << i * 150 << " us:\n"
            << content(file_);
        kept += content(file_) == draft_ ? 1 : 0;
    }
    RecordProperty("kept", kept);
    EXPECT_GT(kept, 0);
    EXPECT_LT(kept, kKills);
}

TEST_F(DraftOnTrial, IsNotConfirmedIfTheFileIsGone) {
    Program& program = begin_draft();
    std::filesystem::remove(file_);
    EXPECT_EQ(said_by("confirm")["error"].get<std::string>().find(file_ + ": cannot be read: "),
              0U);
    EXPECT_EQ(said_by("back")["taken"], true);
    expect_first_channel(1100);
    expect_seamless_end(program);
}

/// Then the text of the file is on trial, and the file has it.
TEST_F(DraftOnTrial, GivesItsPlaceToTheFileThatSighupBrings) {
    Program& program = begin_draft();
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("still on trial"));
    expect_first_channel(1100);
    EXPECT_EQ(said_by("confirm 1")["taken"], true);
    expect_seamless_end(program);
}

/// Its message would show the daemon's secrets to who may only write drafts.
TEST_F(DraftOnTrial, IsNotReadWhereALinkLeads) {
    Program& program = begin_draft();
    std::ofstream(folder() / "secret") << "treasure\n";
    std::filesystem::remove(folder() / "draft/draft.toml");
    std::filesystem::create_symlink(folder() / "secret", folder() / "draft/draft.toml");
    const auto outcome = said_by("reload draft 1000s");
    EXPECT_EQ(outcome["taken"], false);
    EXPECT_NE(outcome.dump().find("it is a symbolic link"), std::string::npos) << outcome;
    EXPECT_EQ(outcome.dump().find("treasure"), std::string::npos) << outcome;
    expect_seamless_end(program);
}

/// The command does not write where a daemon says, so a person does; Enter before is no loss.
TEST_F(DraftOnTrial, IsKeptByEnterOnceTheFileHasIt) {
    const std::string config = write_config(main_job(kPatientInput, "", kReversed));
    const std::string draft = folder() / "draft.text";
    std::filesystem::copy_file(config, draft);
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    FarEnd& terminal = device("terminal");
    Program& asked = start({"reload", "--socket", socket(), "--trial", "1000s", "--draft", draft},
                           {.executable = TRIBUS_PROGRAM, .terminal = terminal.path()});
    // It breaks its lines at words.
    const auto one_line = [&] {
        std::string said = asked.errors();
        std::ranges::replace(said, '\n', ' ');
        return said;
    };
    const auto says = [&](const std::string& text) {
        return eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            return one_line().find(text) != std::string::npos;
        });
    };
    EXPECT_TRUE(says("Enter keeps it")) << asked.errors();
    EXPECT_TRUE(says("Copy " + draft + " into the daemon's own file, then Enter"))
        << asked.errors();
    terminal.send(Bytes{'\n'});
    EXPECT_TRUE(says("write it there, then confirm")) << asked.errors();
    std::filesystem::copy_file(draft, config, std::filesystem::copy_options::overwrite_existing);
    terminal.send(Bytes{'\n'});
    EXPECT_TRUE(says("tribus: confirmed")) << asked.errors();
    EXPECT_EQ(asked.end(), 0);
    expect_first_channel(1900);
    expect_seamless_end(program);
}

}  // namespace
}  // namespace tribus::test::draft_test
