#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/web.h"

/// Doctor and learn from the page: the server opens no port, its helper does.
namespace tribus::test::web_ports_test {
namespace {

using nlohmann::json;

constexpr std::size_t kThrottle = 2;

class WebPorts : public Web {
  protected:
    WebPorts() {
        write_config(main_job(), name() + ".toml");
        serve();
    }
    BrowserAnswer learn(const Browser& browser, const std::string& verb) {
        return post_to(browser, "/api/learn/" + verb, {{"daemon", name()}, {"input", "receiver"}});
    }
    std::string receiver_path() const {
        return std::filesystem::canonical(folder() / "receiver").string();
    }
    /// The receiver sends these sticks from now on, or moving ones.
    void sends(std::optional<Sticks> sticks) {
        sticks_ = std::move(sticks);
        change_frame();
    }
    void change_frame() {
        Sticks moving(14, 1500);
        moving[0] = 1000 + 37 * (++step_ % 27);
        moving[kThrottle] = 1000 + 41 * (step_ % 24);
        repeater_.change(ibus_bytes(sticks_.value_or(moving)));
    }
    void receives_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            const auto before = repeater_.latest();
            repeater_.send_if_due();
            if (repeater_.latest() != before) {
                change_frame();
            }
        }
    }

    std::optional<Sticks> sticks_;
    int step_ = 0;
};

TEST_F(WebPorts, DoctorLooksForAllAndListensForThoseWhoMayChange) {
    const Browser look = paired({"--look"});
    const json report = post_to(look, "/api/doctor", {{"device", nullptr}}).json();
    EXPECT_TRUE(report["findings"].is_array()) << report;
    EXPECT_EQ(post_to(look, "/api/doctor", {{"device", receiver_path()}}).status, 403);
    const json heard =
        post_to(paired(), "/api/doctor", {{"device", receiver_path()}, {"seconds", 3}}).json();
    ASSERT_EQ(heard["ports"].size(), 1U) << heard;
    EXPECT_EQ(heard["ports"][0]["heard"]["protocol"], "ibus") << heard;
}

TEST_F(WebPorts, DoctorOpensNoFileThatIsNoDevice) {
    const Browser browser = paired();
    const BrowserAnswer answer = post_to(browser, "/api/doctor", {{"device", file()}});
    EXPECT_EQ(answer.status, 502);
    EXPECT_NE(answer.content.find("the helper for ports opens a device below /dev"),
              std::string::npos)
        << answer.content;
}

TEST_F(WebPorts, LearnGoesStepByStepToTheLinesForTheDraft) {
    const Browser browser = paired();
    EXPECT_EQ(learn(browser, "next").status, 409) << "nothing was begun";
    sends(std::nullopt);
    const json first = learn(browser, "start").json();
    ASSERT_EQ(first["step"], "waiting") << first;
    receives_for(std::chrono::seconds(2));
    EXPECT_EQ(learn(paired(), "start").status, 409) << "another browser";
    Sticks hands_off(14, 1500);
    hands_off[kThrottle] = 1000;
    sends(hands_off);
    EXPECT_EQ(learn(browser, "next").json()["step"], "off");
    Sticks lost = hands_off;
    lost[kThrottle] = 900;
    sends(lost);
    EXPECT_EQ(learn(browser, "next").json()["step"], "on");
    sends(hands_off);
    const json last = learn(browser, "next").json();
    EXPECT_EQ(last["step"], "done") << last;
    EXPECT_NE(last["lines"].dump().find("channel = 3, below = 9"), std::string::npos) << last;
    EXPECT_EQ(learn(browser, "next").status, 409) << "it is over";
}

TEST_F(WebPorts, LearnThatIsStoppedLetsThePortGo) {
    const Browser browser = paired();
    sends(std::nullopt);
    ASSERT_EQ(learn(browser, "start").json()["step"], "waiting");
    EXPECT_EQ(learn(browser, "stop").json()["step"], "broken");
    EXPECT_TRUE(eventually([&] { return learn(browser, "start").json()["step"] == "waiting"; }));
}

TEST_F(WebPorts, LearnOfAPortThatADaemonHasSaysWhoHasIt) {
    run(file());
    expect_first_channel(1100);
    const json step = learn(paired(), "start").json();
    EXPECT_EQ(step["step"], "broken");
    EXPECT_NE(step["text"].get<std::string>().find("another program uses it"), std::string::npos)
        << step;
}

TEST_F(WebPorts, LearnIsForThoseWhoMayChange) {
    EXPECT_EQ(learn(paired({"--look"}), "start").status, 403);
}

}  // namespace
}  // namespace tribus::test::web_ports_test
