#include "app/monitor/monitor_screen.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/monitor/monitor_keys.h"

namespace tribus::monitor_screen_test {
namespace {

using nlohmann::json;

constexpr std::string_view kStatus = R"({"type":"status","name":"car","file":"/etc/car.toml",
"uptime_us":5000000,"figures_age_us":40000,"missing_realtime":[],
"inputs":[{"name":"main","protocol":"ibus","port":"/dev/ttyAMA5","state":"good","cause":"good",
"rate_hz":142.8,"age_us":3000,"channels":[1100,1500,988.125],"rejected":{"checksum":2}},
{"name":"backup","protocol":"sbus","port":"/dev/ttyUSB0","state":"failsafe",
"cause":"wire_silent","state_age_us":12000000,"rate_hz":0,"age_us":null,"channels":[]}],
"outputs":[{"name":"servos","protocol":"sbus","port":"/dev/ttyAMA3","inputs":["main","backup"],
"state":"control","input":"main","rate_hz":71.4,"channels":[1900,1500,988],
"lateness":{"p50_us":41,"p99_us":80},"deadline_misses":0,"dropped":{"busy":0}}],
"ports":[{"name":"/dev/ttyUSB0","kind":"serial","present":false},
{"name":"can0","kind":"can","present":true,"can":{"state":"bus_off","sent":7}}],
"values":[{"name":"pack.voltage","number":12.5,"unit":"V","stale":true}]})";

/// Returns the lines without escape sequences.
std::vector<std::string> lines_of(const std::string& screen) {
    std::vector<std::string> lines(1);
    for (std::size_t i = 0; i < screen.size(); ++i) {
        if (screen[i] == '\x1b') {
            i = screen.find_first_of("ABCDEFGHJKm", i + 2);
        } else if (screen[i] == '\n') {
            lines.emplace_back();
        } else if (screen[i] != '\r') {
            lines.back() += screen[i];
        }
    }
    return lines;
}

class MonitorScreen : public testing::Test {
  protected:
    MonitorScreen() { view_.status = json::parse(kStatus); }
    std::string plain() const {
        std::string text;
        for (const std::string& line : lines_of(draw_monitor(view_, style_))) {
            text += line + "\n";
        }
        return text;
    }
    bool shows(const std::string& text) const { return plain().find(text) != std::string::npos; }

    MonitorView view_;
    ScreenStyle style_{.columns = 120, .rows = 40, .unicode = false, .colour = false};
};

TEST_F(MonitorScreen, ShowsThatAConfigurationIsOnTrialAndForHowLong) {
    EXPECT_FALSE(shows("on trial"));
    view_.status["trial_left_us"] = 25'000'000;
    EXPECT_TRUE(shows("tribus car  up 5.00 s  on trial, 25.00 s left  /etc/car.toml")) << plain();
}

/// Text from the socket must not write elsewhere on the screen or set a title.
TEST_F(MonitorScreen, ShowsNoControlCharactersOfTheDaemon) {
    view_.status["name"] = "\x1b[2Jcar\n\x7F";
    EXPECT_TRUE(shows("tribus ?[2Jcar??  up")) << plain();
    EXPECT_EQ(monitor_line(view_).find("?[2Jcar??  "), 0U);
}

/// In UTF-8 they are two bytes. Terminals take U+009B for the start of a sequence.
TEST_F(MonitorScreen, ShowsNoControlCharactersAboveAscii) {
    view_.status["name"] =
        "\xC2\x9B"
        "2Jm\xC3\xBCll\xC2\xA0";
    EXPECT_TRUE(shows("tribus ?2Jm\xC3\xBCll\xC2\xA0  up")) << plain();
    EXPECT_EQ(monitor_line(view_).find("?2Jm\xC3\xBCll\xC2\xA0  "), 0U);
}

TEST_F(MonitorScreen, ShowsEveryInputWithItsCause) {
    EXPECT_TRUE(shows("main         ibus     good")) << plain();
    EXPECT_TRUE(shows("142.8/s  age 3.0 ms  rejected 2"));
    EXPECT_TRUE(shows("backup       sbus     wire silent 12.00 s")) << plain();
}

TEST_F(MonitorScreen, ShowsWhoControlsAnOutputAndHowLateItIs) {
    EXPECT_TRUE(shows("servos       sbus     control of main")) << plain();
    EXPECT_TRUE(shows("71.4/s  late 41 us p99 80 us  missed 0  dropped 0"));
}

TEST_F(MonitorScreen, ShowsPortsThatAreGoneAndBusesThatAreOff) {
    EXPECT_TRUE(shows("/dev/ttyUSB0         GONE")) << plain();
    EXPECT_TRUE(shows("can0                 bus off   received 0  sent 7"));
}

TEST_F(MonitorScreen, MarksAStaleValue) {
    EXPECT_TRUE(shows("12.5 V  stale")) << plain();
}

TEST_F(MonitorScreen, ShowsChannelsOfAnOutputBesideThoseOfItsInput) {
    view_.selected = 2;
    EXPECT_TRUE(shows("> servos"));
    const auto lines = lines_of(draw_monitor(view_, style_));
    bool found = false;
    for (const std::string& line : lines) {
        found =
            found || (line.starts_with(" 1  1100 ") && line.find(" 1900 ") != std::string::npos);
    }
    EXPECT_TRUE(found) << plain();
}

TEST_F(MonitorScreen, ShowsAnOutputBesideItsInputFirst) {
    EXPECT_TRUE(shows("> servos")) << plain();
    EXPECT_TRUE(shows("CHANNELS main")) << plain();
}

TEST_F(MonitorScreen, HasAScaleAboveTheBarsWithItsEnds) {
    style_.columns = 80;
    const std::string scale = "900           1500          2100";
    EXPECT_TRUE(shows("         " + scale + "       " + scale)) << plain();
    view_.selected = 0;
    EXPECT_TRUE(shows("         900 ")) << plain();
}

/// 4 inputs, 4 outputs with 18 channels, 6 ports: three screens.
TEST_F(MonitorScreen, ReachesEveryChannelAndPortOn80x24) {
    style_.columns = 80;
    style_.rows = 24;
    json input = view_.status["inputs"][0];
    for (int channel = 4; channel <= 18; ++channel) {
        input["channels"].push_back(1500 + channel);
    }
    view_.status["inputs"] = json::array({input, input, input, input});
    const json output = view_.status["outputs"][0];
    view_.status["outputs"] = json::array({output, output, output, output});
    const json port = view_.status["ports"][0];
    view_.status["ports"] = json::array({port, port, port, port, port});
    json last = port;
    last["name"] = "/dev/last";
    view_.status["ports"].push_back(last);
    std::string all = plain();
    EXPECT_FALSE(shows("1518")) << "no need to scroll";
    EXPECT_FALSE(shows("/dev/last")) << "no need to scroll";
    EXPECT_TRUE(shows("  1-20 of 39")) << plain();
    EXPECT_TRUE(shows("... 10 more channels, 6 ports, 1 value below\n")) << plain();
    for (int page = 0; page < 3; ++page) {
        view_.top = top_after_pages(view_, style_, 1);
        all += plain();
    }
    for (int channel = 4; channel <= 18; ++channel) {
        EXPECT_NE(all.find(std::to_string(1500 + channel)), std::string::npos) << channel;
    }
    EXPECT_NE(all.find("/dev/last"), std::string::npos) << all;
    EXPECT_TRUE(shows("... 4 more inputs, 4 outputs, ")) << plain();
    EXPECT_FALSE(shows(" below\n")) << plain();
    EXPECT_EQ(top_after_pages(view_, style_, 1), view_.top) << "behind the end";
    for (int page = 0; page < 3; ++page) {
        view_.top = top_after_pages(view_, style_, -1);
    }
    EXPECT_EQ(view_.top, 0U);
}

/// Whatever the size and wherever it stands: each row is in sight or counted.
TEST_F(MonitorScreen, ShowsAllThatTheSelectedOutputWaitsForOn40Columns) {
    view_.status["outputs"][0]["state"] = "failsafe";
    view_.status["outputs"][0]["waits_for"] =
        "main: good for 0.2 of 0.5 s; 13 of its latest 100 frames marked frame-lost";
    style_.columns = 200;
    EXPECT_FALSE(shows("\nwaits for main")) << "the line of the output has room for it";
    style_ = {.columns = 40, .rows = 24, .unicode = false, .colour = false};
    EXPECT_TRUE(
        shows("\nwaits for main: good for 0.2 of 0.5 s;\n"
              "13 of its latest 100 frames marked\nframe-lost\n"))
        << plain();
}

TEST_F(MonitorScreen, CountsAllThatIsOutOfSight) {
    const json input = view_.status["inputs"][0];
    view_.status["inputs"] = json::array({input, input, input, input, input, input, input, input});
    style_.columns = 60;
    for (style_.rows = 10; style_.rows < 30; ++style_.rows) {
        for (view_.top = 0; view_.top < 30; ++view_.top) {
            const std::string text = plain();
            int inputs = 0;
            for (const std::string& line : lines_of(draw_monitor(view_, style_))) {
                inputs += line.find(" main         ibus ") != std::string::npos ? 1 : 0;
                const std::size_t more = line.find(" more input");
                inputs += more != std::string::npos && line.starts_with("... ")
                              ? std::stoi(line.substr(4, more))
                              : 0;
            }
            EXPECT_EQ(inputs, 8) << style_.rows << " rows, top " << view_.top << "\n" << text;
        }
    }
}

TEST_F(MonitorScreen, MarksColumnsThatItCuts) {
    style_.columns = 40;
    EXPECT_TRUE(shows("  main         ibus     good           >\n")) << plain();
    style_.unicode = true;
    EXPECT_TRUE(shows("  main         ibus     good           …\n")) << plain();
}

TEST_F(MonitorScreen, TellsAsMuchAboutTheKeysAsFitsBesideThePlace) {
    style_.rows = 10;
    const std::vector<std::pair<std::size_t, std::string>> lines{
        {120, "up/down selects  PgUp/PgDn scrolls  p pauses  q quits  1-6 of 15\n"},
        {60, "up/down PgUp/PgDn  p pauses  q quits  1-6 of 15\n"},
        {40, "PgUp/PgDn  q quits  1-6 of 15\n"},
        {20, "q quits  1-6 of 15\n"}};
    for (const auto& [columns, keys] : lines) {
        style_.columns = columns;
        EXPECT_TRUE(shows("\n" + keys)) << plain();
    }
}

TEST_F(MonitorScreen, MarksASentenceThatNeedsMoreRowsThanThereAre) {
    style_.columns = 20;
    style_.rows = 4;
    view_.connected = false;
    view_.notice = "no daemon answers at /run/tribus/a-name-that-is-long.sock: Connection refused";
    EXPECT_TRUE(shows("\n>\n")) << plain();
}

TEST_F(MonitorScreen, NamesSensorsThatAnswerAndCannotBeRead) {
    view_.status["sensor_buses"] = json::parse(
        R"([{"name":"probes","role":"receiver","found":[{"address":1}],"counts":{},
             "faults":[{"address":1,"fault":"wrong_size"},{"address":2,"fault":"no_type"}]}])");
    EXPECT_TRUE(shows("address 1: wrong size  address 2: no type")) << plain();
}

TEST_F(MonitorScreen, ScrollsToWhatIsSelected) {
    style_.rows = 5;
    view_.selected = 2;
    view_.top = top_that_shows_selected(view_, style_);
    EXPECT_TRUE(shows("> servos")) << plain();
    view_.selected = 0;
    view_.top = top_that_shows_selected(view_, style_);
    EXPECT_TRUE(shows("> main")) << plain();
}

TEST_F(MonitorScreen, SaysAllOfALongSentenceAboutADaemonThatIsGone) {
    style_.columns = 40;
    view_.connected = false;
    view_.notice = "no daemon answers at /run/tribus/a-name-that-is-long.sock: Connection refused";
    view_.age = std::chrono::seconds(3);
    std::string text = plain();
    std::ranges::replace(text, '\n', ' ');
    EXPECT_NE(text.find("no daemon answers at /run/tribus/a-name-that-is-long.sock: Connection"),
              std::string::npos)
        << plain();
    EXPECT_NE(text.find("the figures are from 3.04 s ago"), std::string::npos) << plain();
}

TEST_F(MonitorScreen, SaysLiveOnlyWhileFiguresAreFresh) {
    EXPECT_TRUE(shows("live, 40 ms old"));
    view_.age = std::chrono::milliseconds(1200);
    EXPECT_FALSE(shows("live"));
    EXPECT_TRUE(shows("THE DAEMON DOES NOT ANSWER; the figures are from 1.24 s ago")) << plain();
}

TEST_F(MonitorScreen, SaysThatTheDataThreadStandsStillWhereOnlyThatDoes) {
    view_.status["figures_age_us"] = 5000000;
    EXPECT_TRUE(shows("THE DATA THREAD STANDS STILL; the figures are from 5.00 s ago")) << plain();
    EXPECT_FALSE(shows("live"));
}

TEST_F(MonitorScreen, SaysThatTheDaemonIsGone) {
    view_.connected = false;
    view_.notice = "the daemon is gone; waiting for it";
    view_.age = std::chrono::seconds(3);
    EXPECT_TRUE(shows("the daemon is gone; waiting for it; the figures are from 3.04 s ago"));
}

TEST_F(MonitorScreen, ThatIsPausedTellsHowOldItIs) {
    view_.paused = true;
    view_.age = std::chrono::seconds(9);
    EXPECT_TRUE(shows("PAUSED; the figures are from 9.04 s ago"));
}

TEST_F(MonitorScreen, FitsIntoEverySize) {
    for (std::size_t columns = 1; columns < 130; columns += 3) {
        for (std::size_t rows = 3; rows < 45; rows += 7) {
            style_.columns = columns;
            style_.rows = rows;
            const auto lines = lines_of(draw_monitor(view_, style_));
            EXPECT_LE(lines.size(), rows);
            for (const std::string& line : lines) {
                EXPECT_LE(line.size(), columns) << line;
            }
        }
    }
}

TEST_F(MonitorScreen, HasNoColourWhereNoneIsWanted) {
    EXPECT_EQ(draw_monitor(view_, style_).find("\x1b[0m"), std::string::npos);
    style_.colour = true;
    EXPECT_NE(draw_monitor(view_, style_).find("\x1b[0m"), std::string::npos);
}

TEST_F(MonitorScreen, ShowsNothingWrongForWhatIsNoStatus) {
    for (const char* text : {"null", "[]", "7", R"({"inputs":7,"outputs":[7,{"channels":"x"}]})",
                             R"({"inputs":[{"name":"a\u001b[2Jb"}]})"}) {
        view_.status = json::parse(text);
        view_.selected = 1;
        EXPECT_EQ(draw_monitor(view_, style_).find("\x1b[2J"), std::string::npos);
    }
}

TEST_F(MonitorScreen, CountsWhatCanBeSelected) {
    EXPECT_EQ(selectable(view_.status), 3U);
    EXPECT_EQ(selectable(json()), 0U);
}

TEST_F(MonitorScreen, InOneLineSaysTheSame) {
    EXPECT_EQ(monitor_line(view_),
              "car  main good 142.8/s  backup wire silent 12.00 s 0.0/s  "
              "servos control of main 71.4/s late 80 us");
    view_.age = std::chrono::seconds(2);
    EXPECT_TRUE(monitor_line(view_).starts_with("car  STANDS STILL since 2.04 s"));
    view_.connected = false;
    view_.notice = "the daemon has gone";
    EXPECT_EQ(monitor_line(view_), "the daemon has gone");
}

TEST(MonitorKeys, AreThoseOfTheCursorAndOfTheHand) {
    using enum MonitorKey;
    EXPECT_EQ(keys_in("\x1b[B\x1b[A\t"), (std::vector{next, previous, next}));
    EXPECT_EQ(keys_in("\x1b[6~\x1b[5~du"), (std::vector{page_down, page_up, page_down, page_up}));
    EXPECT_EQ(keys_in("\x1bOBp jkq"), (std::vector{next, pause, pause, next, previous, quit}));
}

TEST(MonitorKeys, OthersArePassedOver) {
    EXPECT_TRUE(keys_in("\x1b[Cxyz\x1b").empty());
}

}  // namespace
}  // namespace tribus::monitor_screen_test
