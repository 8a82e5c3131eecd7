#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/client/control_socket.h"
#include "tests/loopback/first_channel.h"
#include "tests/support/pages.h"

namespace tribus::test::status_test {
namespace {

using nlohmann::json;

std::vector<json> objects_in(const std::string& text) {
    std::vector<json> objects;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        objects.push_back(json::parse(line, nullptr, false));
    }
    return objects;
}

class StatusCommand : public FirstChannel {
  protected:
    std::string socket() const { return folder() / "control"; }
    Program& begin() {
        Program& program = run(write_config(main_job(kPatientInput)));
        expect_first_channel(1100);
        return program;
    }
    Program& status(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"status", "--socket", socket()});
        return start(arguments);
    }
    /// Keeps the receiver going until `done`.
    template <class Done>
    bool with_receiver(Done done) {
        return eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            return done();
        });
    }
    json summary() {
        Program& asked = status({"--format", "json"});
        EXPECT_TRUE(with_receiver([&] { return !asked.runs(); }));
        EXPECT_EQ(asked.end(), 0) << asked.errors();
        EXPECT_EQ(count_of("\n", asked.output()), 1U) << asked.output();
        return json::parse(asked.output(), nullptr, false);
    }
    static bool has(const json& summary, const std::string& field, const json& value) {
        for (const char* const parts : {"inputs", "outputs", "devices"}) {
            for (const json& part : summary[parts]) {
                if (part.contains(field) && part[field] == value) {
                    return true;
                }
            }
        }
        return false;
    }
    /// Waits until `watching` has printed a change of this field to `now`. If a busy machine held
    /// the daemon up for seconds, a second summary comes in place of changes.
    bool tells(const Program& watching, const std::string& field, const json& now) {
        return with_receiver([&] {
            int summaries = 0;
            for (const json& object : objects_in(watching.output())) {
                if (!object.is_object()) {
                    continue;
                }
                if (object["type"] == "summary") {
                    if (++summaries > 1 && has(object, field, now)) {
                        return true;
                    }
                } else if (object["field"] == field && object["now"] == now) {
                    return true;
                }
            }
            return false;
        });
    }
};

TEST_F(StatusCommand, TellsWhoControlsWhat) {
    Program& program = begin();
    json told;
    EXPECT_TRUE(eventually([&] {
        told = summary();
        return told["outputs"][0]["state"] == "control";
    })) << told;
    EXPECT_EQ(told["type"], "summary");
    EXPECT_EQ(told["file"], (folder() / "tribus.toml").string());
    EXPECT_EQ(told["figures_old"], false);
    EXPECT_EQ(told["inputs"][0]["good"], true);
    EXPECT_EQ(told["outputs"][0]["input"], "receiver");
    EXPECT_EQ(told["devices"].size(), 2U);
    EXPECT_EQ(told["gone"], json::array());
    Program& asked = status({});
    EXPECT_TRUE(with_receiver([&] { return !asked.runs(); }));
    EXPECT_EQ(asked.end(), 0);
    EXPECT_NE(asked.output().find("\noutput servos: under control of receiver\n"),
              std::string::npos)
        << asked.output();
    expect_clean_end(program);
}

TEST_F(StatusCommand, NamesTheDeviceThatIsGone) {
    Program& program = begin();
    receiver_.pull();
    EXPECT_TRUE(eventually([&] { return summary()["gone"] == json{receiver_.path()}; }));
    expect_clean_end(program);
}

TEST_F(StatusCommand, WithoutADaemonFailsAndPrintsNoResult) {
    for (const bool watch : {false, true}) {
        Program& lonely = status(watch ? std::vector<std::string>{"--format", "json", "--watch"}
                                       : std::vector<std::string>{"--format", "json"});
        EXPECT_EQ(lonely.end(), 1);
        EXPECT_EQ(lonely.output(), "");
        EXPECT_EQ(lonely.errors().find("tribus: no daemon answers at " + socket()), 0U)
            << lonely.errors();
    }
}

TEST_F(StatusCommand, FailsIfTheDaemonHangs) {
    Program& program = begin();
    program.signal(SIGSTOP);
    Program& asked = status({"--format", "json"});
    Program& watching = status({"--format", "json", "--watch"});
    EXPECT_EQ(asked.end(), 1);
    EXPECT_EQ(asked.output(), "");
    EXPECT_NE(asked.errors().find("does not answer"), std::string::npos) << asked.errors();
    EXPECT_EQ(watching.end(), 1);
    EXPECT_EQ(watching.output(), "");
    program.signal(SIGCONT);
    expect_clean_end(program);
}

TEST_F(StatusCommand, InAWrongFormIsWrongUse) {
    EXPECT_EQ(status({"--format", "xml"}).end(), 2);
}

TEST_F(StatusCommand, WatchTellsEachChange) {
    Program& program = begin();
    Program& watching = status({"--format", "json", "--watch"});
    EXPECT_TRUE(with_receiver([&] { return !watching.output().empty(); }));
    EXPECT_EQ(objects_in(watching.output())[0]["type"], "summary");
    receiver_.pull();
    EXPECT_TRUE(tells(watching, "state", "gone")) << watching.output();
    EXPECT_TRUE(tells(watching, "cause", "wire_silent")) << watching.output();
    EXPECT_TRUE(tells(watching, "state", "failsafe")) << watching.output();
    receiver_.plug_in();
    EXPECT_TRUE(tells(watching, "state", "there")) << watching.output();
    EXPECT_TRUE(tells(watching, "state", "control")) << watching.output();
    watching.signal(SIGTERM);
    EXPECT_EQ(watching.end(), 0);
    expect_clean_end(program);
}

TEST_F(StatusCommand, WatchSaysThatTheDaemonIsGoneAndWhenItIsBack) {
    Program& first = begin();
    Program& watching = status({"--format", "json", "--watch"});
    EXPECT_TRUE(with_receiver([&] { return !watching.output().empty(); }));
    first.signal(SIGKILL);
    first.end();
    EXPECT_TRUE(tells(watching, "answers", false));
    const auto gone = objects_in(watching.output()).back();
    EXPECT_NE(gone["why"].get<std::string>().find("is gone"), std::string::npos) << gone;
    Program& second = run(folder() / "tribus.toml");
    EXPECT_TRUE(tells(watching, "answers", true));
    EXPECT_TRUE(with_receiver([&] {
        return count_of("\"type\":\"summary\"", watching.output()) == 2;
    })) << watching.output();
    expect_clean_end(second);
}

TEST_F(StatusCommand, WatchSaysThatTheDaemonIsSilent) {
    Program& program = begin();
    Program& watching = status({"--watch"});
    EXPECT_TRUE(with_receiver([&] { return !watching.output().empty(); }));
    program.signal(SIGSTOP);
    const std::string silent = " daemon tribus: does not answer: it runs but is silent";
    EXPECT_TRUE(eventually([&] { return count_of(silent, watching.output()) == 1; }))
        << watching.output();
    program.signal(SIGCONT);
    // The first status may still have the figures from before the stop.
    EXPECT_TRUE(with_receiver([&] {
        const std::string text = watching.output();
        const std::size_t back = text.find(" daemon tribus: answers again\ntribus: ");
        return back != std::string::npos &&
               text.find("output servos: under control of receiver", back) != std::string::npos;
    })) << watching.output();
    EXPECT_EQ(count_of(silent, watching.output()), 1U);
    expect_clean_end(program);
}

/// The names of the fields and the kinds of their values, also in the first entry of lists.
void expect_same_shape(const json& shown, const json& real, const std::string& where) {
    ASSERT_EQ(shown.is_object(), real.is_object()) << where;
    if (!shown.is_object()) {
        EXPECT_TRUE(shown.type() == real.type() || (shown.is_number() && real.is_number()) ||
                    shown.is_null() || real.is_null())
            << where;
        return;
    }
    for (const auto& [key, value] : real.items()) {
        ASSERT_TRUE(shown.contains(key)) << where << "." << key << " is not on the page";
        const bool list = value.is_array() && !value.empty() && !shown[key].empty();
        expect_same_shape(list ? shown[key][0] : shown[key], list ? value[0] : value,
                          where + "." + key);
    }
    EXPECT_EQ(shown.size(), real.size()) << where << " has fields that the program does not print";
}

TEST_F(StatusCommand, IsAsThePageShowsIt) {
    const std::filesystem::path page =
        std::filesystem::path(TRIBUS_SOURCE_DIR) / "docs" / "commands.md";
    const std::string text = text_of_file(page);
    std::vector<json> shown;
    for (const Fence& fence : fences_of(page)) {
        const json object = json::parse(fence.text, nullptr, false);
        if (fence.language == "json" && object.is_object() &&
            (object["type"] == "summary" || object["type"] == "change")) {
            shown.push_back(object);
        }
    }
    ASSERT_EQ(shown.size(), 2U);
    Program& program = begin();
    expect_same_shape(shown[0], summary(), "summary");
    Program& watching = status({"--format", "json", "--watch"});
    EXPECT_TRUE(with_receiver([&] { return !watching.output().empty(); }));
    receiver_.pull();
    EXPECT_TRUE(tells(watching, "state", "gone"));
    expect_same_shape(shown[1], objects_in(watching.output())[1], "change");
    for (const auto& [key, value] : shown[0].items()) {
        EXPECT_NE(text.find("`" + key + "`"), std::string::npos) << key << " is in no table";
    }
    expect_clean_end(program);
}

/// A draft on trial: the daemon's own file is never touched.
class DraftCommand : public StatusCommand {
  protected:
    Program& begin_with_draft() {
        Program& program = begin();
        own_ = text_of_file(folder() / "tribus.toml");
        draft_ =
            write_config(main_job(kPatientInput, "",
                                  "[pipeline.main.channels]\n1 = { from = 1, reverse = true }"),
                         "other.toml");
        return program;
    }
    int reload(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), {"reload", "--socket", socket()});
        Program& asked = start(arguments);
        EXPECT_TRUE(with_receiver([&] { return !asked.runs(); }));
        said_ = asked.errors();
        return asked.end().value_or(-1);
    }

    std::string own_;
    std::string draft_;
    std::string said_;
};

TEST_F(DraftCommand, RunsUntilItsTimeIsOver) {
    Program& program = begin_with_draft();
    const auto before = summary();
    EXPECT_EQ(reload({"--trial", "5s", "--draft", draft_}), 0) << said_;
    expect_first_channel(1900);
    const auto trial = summary();
    EXPECT_EQ(trial["trial"], 1);
    EXPECT_NE(trial["fingerprint"], before["fingerprint"]);
    expect_first_channel(1100);
    EXPECT_EQ(summary()["fingerprint"], before["fingerprint"]);
    EXPECT_EQ(text_of_file(folder() / "tribus.toml"), own_);
    EXPECT_EQ(count_of("tribus.toml still holds\n", program.errors()), 1U) << program.errors();
    expect_clean_end(program);
}

TEST_F(DraftCommand, IsKeptOnlyUnderItsNumber) {
    Program& program = begin_with_draft();
    EXPECT_EQ(reload({"--trial", "1000s", "--draft", draft_}), 0) << said_;
    EXPECT_EQ(reload({"--confirm", "--number", "2"}), 1);
    EXPECT_EQ(said_, "tribus: that trial is over; the present one is number 1\n");
    EXPECT_EQ(reload({"--back", "--number", "2"}), 1);
    EXPECT_EQ(summary()["trial"], 1);
    std::filesystem::copy_file(draft_, folder() / "tribus.toml",
                               std::filesystem::copy_options::overwrite_existing);
    EXPECT_EQ(reload({"--confirm", "--number", "1"}), 0) << said_;
    EXPECT_TRUE(summary()["trial"].is_null());
    expect_first_channel(1900);
    expect_clean_end(program);
}

TEST_F(DraftCommand, WithMistakesOrWithoutAFileIsRefused) {
    Program& program = begin_with_draft();
    std::ofstream(draft_, std::ios::app) << "form = 1\n";
    EXPECT_EQ(reload({"--trial", "1000s", "--draft", draft_}), 1);
    EXPECT_NE(said_.find("refused; the configuration before stays"), std::string::npos) << said_;
    EXPECT_EQ(reload({"--trial", "1000s", "--draft", "/nowhere/x.toml"}), 1);
    EXPECT_EQ(said_, "tribus: /nowhere/x.toml: No such file or directory\n");
    EXPECT_EQ(reload({"--draft", draft_}), 2);
    EXPECT_EQ(reload({"--number", "1"}), 2);
    EXPECT_EQ(said_, "tribus: --number goes with --confirm or --back\n");
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// The place of drafts belongs to the daemon's user. For root it must lead nowhere else.
TEST_F(DraftCommand, IsNotWrittenThroughALink) {
    Program& program = begin_with_draft();
    const std::filesystem::path place = draft_file(socket());
    const std::filesystem::path elsewhere = folder() / "elsewhere";
    std::filesystem::create_directory(elsewhere);
    std::filesystem::create_directory_symlink(elsewhere, place.parent_path());
    EXPECT_EQ(reload({"--trial", "1000s", "--draft", draft_}), 1);
    EXPECT_TRUE(std::filesystem::is_empty(elsewhere)) << said_;
    std::filesystem::remove(place.parent_path());
    std::filesystem::create_directory(place.parent_path());
    std::filesystem::create_symlink(elsewhere / "file", place);
    EXPECT_EQ(reload({"--trial", "1000s", "--draft", draft_}), 0) << said_;
    EXPECT_TRUE(std::filesystem::is_empty(elsewhere)) << said_;
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::status_test
