#include <sys/types.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <future>
#include <iterator>
#include <list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/web.h"
#include "tests/support/sanitized.h"
#include "tests/support/shell.h"

/// Recordings and histograms of a real daemon, as the page gets them (docs/web.md).
namespace tribus::test::web_recordings_test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr const char* kAll = "/plot?from=0&to=3700000000&width=50";

class WebRecordings : public Web {
  protected:
    /// It waits longer than the server waits for a plot.
    Browser paired(std::vector<std::string> more = {}) {
        Browser browser = Web::paired(std::move(more));
        browser.be_patient(std::chrono::seconds(60));
        return browser;
    }
    fs::path recordings() const { return folder() / "recordings"; }
    Program& run_recorder(const std::string& more = "on_failsafe = false\n") {
        Program& daemon = run(write_config(
            main_job(kPatientInput) + "[recorder]\ndirectory = \"@recordings\"\n" + more,
            name() + ".toml"));
        expect_first_channel(1100);
        return daemon;
    }
    /// Asks for a recording and returns its name.
    std::string record(const Browser& browser) {
        expect_first_channel(1100);
        const json begun = post(browser, "record", json::object()).json();
        const std::string number = std::to_string(begun["number"].get<int>());
        json told;
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            told = browser.get(api("record/" + number)).json();
            return told["state"] == "written";
        })) << told;
        return fs::path(told["folder"].get<std::string>()).filename();
    }
    /// A daemon has recorded, and has ended.
    std::string recorded(const Browser& browser, Program& daemon) {
        const std::string id = record(browser);
        expect_clean_end(daemon);
        return id;
    }
    std::string one(const std::string& id, const std::string& what) const {
        return api("recordings/" + id + what);
    }
    /// A copy of a recording, with so many lines more of its input than a plot reads in a second.
    std::string long_copy(const std::string& id) const {
        const std::string copy = "2026-01-01T00-00-00Z-request";
        fs::copy(recordings() / id, recordings() / copy);
        std::ofstream file(recordings() / copy / "input-receiver.txt");
        file << "# t_us  bytes\n";
        for (int i = 0; i < 1'500'000; ++i) {
            file << i * 2000L << " 20 40 dc 05\n";
        }
        return copy;
    }
    /// The process that reads a recording.
    std::optional<pid_t> reader(const Program& server) const {
        const std::string id = std::to_string(server.pid());
        std::ifstream children("/proc/" + id + "/task/" + id + "/children");
        pid_t child = 0;
        children >> child;
        // Before it runs its program, the server waits for it.
        std::ifstream words("/proc/" + std::to_string(child) + "/cmdline");
        const std::string line{std::istreambuf_iterator<char>(words), {}};
        return line.find("plot") != std::string::npos ? std::optional(child) : std::nullopt;
    }
    std::future<BrowserAnswer> plot_meanwhile(const Browser& browser, const std::string& id) const {
        return std::async(std::launch::async,
                          [&browser, path = one(id, kAll)] { return browser.get(path); });
    }
};

const json* series_of(const json& plot, const std::string& name, int channel) {
    for (const json& one : plot["series"]) {
        if (one["name"] == name && one["channel"] == channel) {
            return &one;
        }
    }
    return nullptr;
}

TEST_F(WebRecordings, AreListedDrawnAndPacked) {
    run_recorder();
    serve();
    const Browser browser = paired();
    const json screens = browser.get("/api/me").json()["screens"];
    EXPECT_EQ(std::count(screens.begin(), screens.end(), "recordings"), 1);
    EXPECT_EQ(browser.get(api("recordings")).json()["recordings"], json::array());
    const std::string id = record(browser);
    const json list = browser.get(api("recordings")).json();
    EXPECT_EQ(list["directory"], recordings().string());
    ASSERT_EQ(list["recordings"].size(), 1U) << list;
    EXPECT_EQ(list["recordings"][0]["id"], id);
    EXPECT_EQ(list["recordings"][0]["cause"], "request");
    const BrowserAnswer answer = browser.get(one(id, kAll));
    ASSERT_EQ(answer.status, 200) << answer.content;
    const json plot = answer.json();
    EXPECT_EQ(plot["problem"], nullptr);
    EXPECT_EQ(plot["to_us"], plot["length_us"]);
    for (const std::string name : {"receiver", "servos"}) {
        const json* const series = series_of(plot, name, 1);
        ASSERT_NE(series, nullptr) << plot;
        ASSERT_EQ((*series)["least"].size(), 50U);
        EXPECT_EQ((*series)["kind"], name == "servos" ? "output" : "input");
        json last;
        for (const json& least : (*series)["least"]) {
            last = least.is_null() ? last : least;
        }
        EXPECT_NEAR(last.get<double>(), 1100, 1);
    }
    ASSERT_FALSE(plot["states"].empty());
    EXPECT_EQ(plot["states"].back()["state"], "control");
    EXPECT_EQ(plot["states"].back()["output"], "servos");
}

/// Both start processes of their own.
TEST_F(WebRecordings, AreDrawnAlsoAfterDoctorHasLooked) {
    run_recorder();
    serve();
    const Browser browser = paired();
    EXPECT_EQ(post_to(browser, "/api/doctor", {{"device", nullptr}}).status, 200);
    EXPECT_EQ(browser.get(one(record(browser), kAll)).status, 200);
}

TEST_F(WebRecordings, AnArchiveHoldsTheFolderAsItIs) {
    Program& daemon = run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    // Neither is of the recording.
    fs::create_symlink(file(), recordings() / id / "elsewhere");
    fs::create_directory(recordings() / id / "folder");
    std::ofstream(recordings() / id / ("config-1-" + std::string(100, 'n'))) << "long name";
    const BrowserAnswer answer = browser.get(one(id, ".tar"));
    ASSERT_EQ(answer.status, 200);
    EXPECT_EQ(answer.header("Content-Type"), "application/x-tar");
    EXPECT_EQ(answer.header("Content-Length"), std::to_string(answer.content.size()));
    EXPECT_EQ(answer.header("Content-Disposition"), "attachment; filename=\"" + id + ".tar\"");
    std::ofstream(folder() / "got.tar", std::ios::binary) << answer.content;
    fs::remove(recordings() / id / "elsewhere");
    fs::remove(recordings() / id / "folder");
    const Ended same =
        run_in_shell("cd " + folder().string() + " && mkdir got && tar -xf got.tar " +
                     "-C got && diff -r got/" + id + " recordings/" + id);
    EXPECT_EQ(same.status, 0) << same.output;
}

TEST_F(WebRecordings, ADaemonThatDoesNotRunHasThemInTheDirectoryOfItsFile) {
    Program& daemon = run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    EXPECT_EQ(browser.get(api("recordings")).json()["recordings"][0]["id"], id);
    EXPECT_EQ(browser.get(one(id, kAll)).status, 200);
    EXPECT_EQ(browser.get(api("histograms")).status, 502);
    write_config(main_job(kPatientInput) + "[recorder]\n", name() + ".toml");
    const BrowserAnswer nowhere = browser.get(api("recordings"));
    EXPECT_EQ(nowhere.status, 502);
    EXPECT_NE(nowhere.content.find("names no directory"), std::string::npos) << nowhere.content;
    write_config(main_job(kPatientInput), name() + ".toml");
    EXPECT_EQ(browser.get(api("recordings")).json()["directory"], nullptr);
    EXPECT_EQ(browser.get(one(id, kAll)).status, 404);
    write_config("[input.a]\nprotocol = \"x\"\n", name() + ".toml");
    const BrowserAnswer mistakes = browser.get(api("recordings"));
    EXPECT_EQ(mistakes.status, 502);
    EXPECT_NE(mistakes.content.find("has mistakes"), std::string::npos) << mistakes.content;
}

/// The file says another directory meanwhile.
TEST_F(WebRecordings, ADaemonThatRunsKnowsItsDirectoryBetterThanItsFile) {
    run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = record(browser);
    write_config(main_job(kPatientInput) + "[recorder]\ndirectory = \"/elsewhere\"\n",
                 name() + ".toml");
    EXPECT_EQ(browser.get(api("recordings")).json()["directory"], recordings().string());
    write_config(main_job(kPatientInput), name() + ".toml");
    EXPECT_EQ(browser.get(one(id, ".tar")).status, 200);
}

TEST_F(WebRecordings, NoNameAndNoLinkLeadsOutOfTheirDirectory) {
    Program& daemon = run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    const std::string linked = "2026-01-01T00-00-00Z-request";
    const std::string outside = "2026-01-02T00-00-00Z-request";
    fs::copy(recordings() / id, folder() / outside);
    fs::create_directory_symlink(folder() / outside, recordings() / linked);
    EXPECT_EQ(browser.get(api("recordings")).json()["recordings"].size(), 1U);
    for (const std::string& wrong : {linked, outside, "../" + outside, "..%2f" + outside,
                                     id + "/../../" + outside, std::string(".."), std::string("."),
                                     std::string("../recordings/" + id), id + "/", std::string()}) {
        EXPECT_EQ(browser.get(one(wrong, ".tar")).status, 404) << wrong;
        EXPECT_EQ(browser.get(one(wrong, kAll)).status, 404) << wrong;
    }
    EXPECT_EQ(browser.get(one(id, "/config.toml")).status, 404);
    fs::rename(recordings() / id / "input-receiver.txt", folder() / "stolen.txt");
    fs::create_symlink(folder() / "stolen.txt", recordings() / id / "input-receiver.txt");
    EXPECT_EQ(series_of(browser.get(one(id, kAll)).json(), "receiver", 1), nullptr);
    fs::rename(recordings() / id / "config.toml", folder() / "stolen.toml");
    fs::create_symlink(folder() / "stolen.toml", recordings() / id / "config.toml");
    EXPECT_EQ(browser.get(one(id, kAll)).status, 422);
}

TEST_F(WebRecordings, APlotNeedsARangeAndAWidth) {
    Program& daemon = run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    for (const std::string query :
         {"", "?from=0&to=1000", "?from=0&width=5", "?from=5&to=5&width=5", "?from=-1&to=5&width=5",
          "?from=0&to=1000&width=0", "?from=0&to=1000&width=4001", "?from=0x&to=1000&width=5",
          "?from=0&to=1000&width=5;ls"}) {
        EXPECT_EQ(browser.get(one(id, "/plot" + query)).status, 400) << query;
    }
    const json part = browser.get(one(id, "/plot?width=4000&to=20000&from=10000")).json();
    EXPECT_EQ(part["from_us"], 10'000);
    EXPECT_EQ(part["to_us"], 20'000);
}

TEST_F(WebRecordings, ADamagedOneIsDrawnAsFarAsItGoesAndHarmsNobody) {
    Program& daemon = run_recorder();
    serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    std::ofstream(recordings() / id / "input-receiver.txt", std::ios::app)
        << "999999999 20 40\nthis is no line of it\n";
    const json plot = browser.get(one(id, kAll)).json();
    EXPECT_NE(plot["problem"].get<std::string>().find("input-receiver.txt:"), std::string::npos)
        << plot["problem"];
    EXPECT_NE(series_of(plot, "servos", 1), nullptr);
    std::ofstream(recordings() / id / "input-receiver.txt") << std::string(100'000, '\x01');
    EXPECT_EQ(browser.get(one(id, kAll)).status, 200);
    std::ofstream(recordings() / id / "output-servos.txt")
        << "# t_us  bytes\n99999999999999999999 0f\n";
    EXPECT_EQ(browser.get(one(id, kAll)).status, 200);
    std::ofstream(recordings() / id / "config.toml") << "[input.a]\n";
    const BrowserAnswer wrong = browser.get(one(id, kAll));
    EXPECT_EQ(wrong.status, 422);
    EXPECT_NE(wrong.content.find("the configuration of the recording has mistakes"),
              std::string::npos)
        << wrong.content;
    fs::remove_all(recordings() / id);
    EXPECT_EQ(browser.get(one(id, kAll)).status, 404);
}

/// One for the whole server: it takes a processor and memory.
TEST_F(WebRecordings, ASecondPlotAtOnceIsToComeAgain) {
    Program& daemon = run_recorder();
    Program& server = serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    auto first = plot_meanwhile(browser, long_copy(id));
    ASSERT_TRUE(eventually([&] { return reader(server).has_value(); }));
    const BrowserAnswer second = browser.get(one(id, kAll));
    EXPECT_EQ(second.status, 503);
    EXPECT_EQ(second.header("Retry-After"), "1");
    EXPECT_EQ(browser.get(api("recordings")).status, 200) << "nobody else waits";
    // The server outlives its reader.
    ::kill(*reader(server), SIGKILL);
    const BrowserAnswer killed = first.get();
    EXPECT_EQ(killed.status, 422);
    EXPECT_NE(killed.content.find("ended by signal 9"), std::string::npos) << killed.content;
    EXPECT_EQ(browser.get(one(id, kAll)).status, 200);
}

/// Its reader is stopped for this.
TEST_F(WebRecordings, APlotThatTakesTooLongIsGivenUp) {
    Program& daemon = run_recorder();
    Program& server = serve();
    const Browser browser = paired();
    const std::string id = recorded(browser, daemon);
    auto first = plot_meanwhile(browser, long_copy(id));
    ASSERT_TRUE(eventually([&] { return reader(server).has_value(); }));
    ::kill(*reader(server), SIGSTOP);
    const BrowserAnswer late = first.get();
    EXPECT_EQ(late.status, 422);
    EXPECT_NE(late.content.find("takes longer than"), std::string::npos) << late.content;
    EXPECT_FALSE(reader(server).has_value());
    EXPECT_EQ(browser.get(one(id, kAll)).status, 200);
}

TEST_F(WebRecordings, AReaderThatStopsInAnArchiveHoldsUpNobodyAndTakesNoMemory) {
    run_recorder();
    Program& server = serve();
    const Browser browser = paired();
    const std::string id = record(browser);
    constexpr std::uintmax_t kLong = std::uintmax_t{200} << 20U;
    fs::resize_file(recordings() / id / "README.txt", kLong);
    EXPECT_TRUE(browser.get(api("recordings")).json()["recordings"][0]["bytes"] > kLong);
    std::list<EventStream> readers;
    for (int i = 0; i < 6; ++i) {
        readers.emplace_back(browser, port_, one(id, ".tar"));
    }
    EventStream stream(browser, port_, api("stream"));
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(stream.next("status"));
    }
    if (!kSanitized) {
        EXPECT_LT(server.memory_kib("VmRSS"), 12'000);
    }
    // A file that becomes shorter ends the connection: what came is too short, and so is seen.
    fs::resize_file(recordings() / id / "README.txt", 1000);
    EXPECT_TRUE(readers.front().ended());
    readers.clear();
    EXPECT_TRUE(stream.next("status"));
    EXPECT_EQ(browser.get(one(id, ".tar")).status, 200);
}

TEST_F(WebRecordings, AreNotForStrangers) {
    Program& daemon = run_recorder();
    serve();
    const std::string id = recorded(paired(), daemon);
    const Browser stranger(port_);
    for (const std::string& path :
         {api("recordings"), one(id, kAll), one(id, ".tar"), api("histograms")}) {
        EXPECT_EQ(stranger.get(path).status, 401) << path;
    }
    EXPECT_EQ(paired({"--look"}).get(one(id, ".tar")).status, 200) << "looking is enough";
}

TEST_F(WebRecordings, HistogramsHaveWhatTheStatusHasQuantilesOf) {
    run_recorder();
    serve();
    const Browser browser = paired();
    const json told = browser.get(api("histograms")).json();
    EXPECT_EQ(told["type"], "histograms");
    ASSERT_EQ(told["starts_us"].size(), 80U);
    EXPECT_EQ(told["inputs"][0]["name"], "receiver");
    ASSERT_EQ(told["outputs"][0]["name"], "servos");
    for (const std::string what : {"lateness", "latency"}) {
        std::uint64_t count = 0;
        for (const json& bucket : told["outputs"][0][what]["last_minute"]["counts"]) {
            count += bucket.get<std::uint64_t>();
        }
        EXPECT_GT(count, 0U) << what;
        EXPECT_GT(told["outputs"][0][what]["since_start"]["max_us"], 0.0) << what;
    }
}

}  // namespace
}  // namespace tribus::test::web_recordings_test
