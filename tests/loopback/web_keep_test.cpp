#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/replace_file.h"
#include "app/client/ask_daemon.h"
#include "tests/loopback/browser.h"
#include "tests/loopback/web.h"

/// Who keeps a draft, and what the file has then, whichever program dies meanwhile (docs/web.md).
namespace tribus::test::web_keep_test {
namespace {

/// Keeping is asked for while the daemon hangs, and then both or one of the programs dies: the file
/// has the text that runs, and no other file is left.
class WebKeep : public Web {
  protected:
    /// A draft on trial for so many seconds, by a daemon that hangs and is asked to keep it.
    Program& keep_while_it_hangs(int seconds) {
        Program& daemon = run_daemon();
        server_ = &serve();
        const Browser browser = paired();
        before_ = content();
        after_ = reversed();
        const std::string tag = browser.get(api("configuration")).header("ETag");
        trial_ =
            post(browser, "draft", {{"toml", after_}, {"seconds", seconds}}, {{"If-Match", tag}})
                .json()["trial"];
        expect_first_channel(1900);
        daemon.signal(SIGSTOP);
        browser.post_and_leave(api("confirm"), {{"trial", trial_}});
        EXPECT_TRUE(eventually([&] { return std::filesystem::exists(successor_of(file())); }));
        EXPECT_EQ(content(), before_) << "the daemon alone decides";
        return daemon;
    }
    bool leaves_no_successor() {
        return eventually([&] { return !std::filesystem::exists(successor_of(file())); });
    }

    Program* server_ = nullptr;
    std::string before_;
    std::string after_;
    nlohmann::json trial_;
};

TEST_F(WebKeep, ADaemonThatGoesOnInTimeKeepsItAlsoIfThePageIsGone) {
    keep_while_it_hangs(1000).signal(SIGCONT);
    EXPECT_TRUE(eventually([&] { return content() == after_; }));
    expect_first_channel(1900);
    EXPECT_TRUE(leaves_no_successor());
}

TEST_F(WebKeep, IsAskedForOnceAtATime) {
    Program& daemon = keep_while_it_hangs(1000);
    const Browser browser = paired();
    const BrowserAnswer second = post(browser, "confirm", {{"trial", trial_}});
    EXPECT_EQ(second.status, 409);
    EXPECT_EQ(second.json()["error"], "this draft is being kept already");
    daemon.signal(SIGCONT);
    EXPECT_TRUE(eventually([&] { return content() == after_; })) << "the first one goes on";
    EXPECT_TRUE(leaves_no_successor());
}

TEST_F(WebKeep, ADaemonThatGoesOnAfterTheTrialHasNotKeptIt) {
    Program& daemon = keep_while_it_hangs(4);
    std::this_thread::sleep_for(std::chrono::milliseconds(4200));
    daemon.signal(SIGCONT);
    EXPECT_TRUE(leaves_no_successor());
    expect_first_channel(1100);
    EXPECT_EQ(content(), before_);
}

TEST_F(WebKeep, ADaemonThatDiesHasNotKeptIt) {
    keep_while_it_hangs(1000).signal(SIGKILL);
    EXPECT_TRUE(leaves_no_successor());
    EXPECT_EQ(content(), before_);
    const Browser browser = paired();
    const BrowserAnswer dead = post(browser, "confirm", {{"trial", trial_}});
    EXPECT_EQ(dead.status, 502) << dead.content;
    EXPECT_EQ(content(), before_);
    EXPECT_TRUE(leaves_no_successor());
}

/// It may die before it has asked, or while the answer is under way.
TEST_F(WebKeep, IfTheServerDiesTheFileHasWhatTheDaemonKept) {
    Program& daemon = keep_while_it_hangs(1000);
    server_->signal(SIGKILL);
    daemon.signal(SIGCONT);
    const auto status = [&] {
        return ask_daemon((folder() / "control").string(), "status", kPatience).value();
    };
    const bool kept =
        eventually([&] { return status()["trial"].is_null(); }, std::chrono::seconds(2));
    EXPECT_EQ(content(), kept ? after_ : before_);
    expect_first_channel(1900);
}

TEST_F(WebKeep, IfBothDieTheFileIsAsBeforeAndTheNextTrialIsKept) {
    keep_while_it_hangs(1000).signal(SIGKILL);
    server_->signal(SIGKILL);
    EXPECT_EQ(content(), before_);
    run_daemon();
    expect_first_channel(1100);
    serve();
    const Browser browser = paired();
    const auto next = try_reversed(browser).json()["trial"];
    EXPECT_EQ(post(browser, "confirm", {{"trial", next}}).status, 200);
    EXPECT_EQ(content(), after_);
    EXPECT_TRUE(leaves_no_successor());
}

/// Then the text of the file is on trial in its place.
TEST_F(WebKeep, ADraftThatSighupReplacedIsNotSaidToBeKept) {
    Program& daemon = run_daemon();
    serve();
    const Browser browser = paired();
    const std::string before = content();
    const auto trial = try_reversed(browser).json()["trial"];
    expect_first_channel(1900);
    daemon.signal(SIGHUP);
    EXPECT_TRUE(daemon.says("still on trial"));
    EXPECT_EQ(post(browser, "confirm", {{"trial", trial}}).status, 409);
    EXPECT_EQ(content(), before);
    EXPECT_FALSE(std::filesystem::exists(successor_of(file())));
    expect_first_channel(1100);
}

}  // namespace
}  // namespace tribus::test::web_keep_test
