#pragma once

#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/browser.h"
#include "tests/loopback/first_channel.h"

namespace tribus::test {

inline constexpr const char* kReversed =
    "[pipeline.main.channels]\n1 = { from = 1, reverse = true }";

/// `tribus-web` in front of a real daemon on ptys.
class Web : public FirstChannel {
  protected:
    Web() {
        std::filesystem::create_directory(folder() / "state");
        std::filesystem::create_directory(folder() / "page");
        std::ofstream(folder() / "page" / "index.html") << "the page";
    }
    /// The daemon has the name of the test's folder, which is its runtime directory.
    std::string name() const { return folder().filename().string(); }
    std::string file() const { return folder() / (name() + ".toml"); }
    std::string api(const std::string& what) const { return "/api/" + name() + "/" + what; }
    /// Its state in the list; other daemons of the machine may be there, too.
    std::string listed_state(const Browser& browser) const {
        const auto list = browser.get("/api/daemons").json();
        for (const auto& daemon : list["daemons"]) {
            if (daemon["name"] == name()) {
                return daemon["state"];
            }
        }
        return "not listed";
    }
    std::string content() const {
        std::ifstream in(file());
        return {std::istreambuf_iterator<char>(in), {}};
    }
    Program& run_daemon() {
        Program& program = run(write_config(main_job(kPatientInput), name() + ".toml"));
        expect_first_channel(1100);
        // The status follows a little later.
        EXPECT_TRUE(program.says("under control of receiver"));
        return program;
    }
    Program& serve(const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments{
            "serve",   "--listen",         "127.0.0.1:0", "--configurations", folder(),
            "--state", folder() / "state", "--page",      folder() / "page"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        Program& server = start(arguments, {.executable = TRIBUS_WEB});
        const std::string said = "the page is at http://127.0.0.1:";
        EXPECT_TRUE(server.says(said)) << server.errors();
        const std::string errors = server.errors();
        port_ = std::stoi(errors.substr(errors.find(said) + said.size()));
        return server;
    }
    std::string code(std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"pair", "--state", folder() / "state"});
        Program& pair = start(more);
        EXPECT_EQ(pair.end(), 0) << pair.errors();
        std::string line = pair.output().substr(0, 9);
        line.erase(4, 1);
        return line;
    }
    Browser paired(std::vector<std::string> more = {}) {
        Browser browser(port_);
        EXPECT_EQ(browser.pair(code(std::move(more))).status, 200);
        return browser;
    }
    /// The present text with channel 1 reversed.
    std::string reversed() const { return content() + "\n" + kReversed + "\n"; }
    /// Puts the reversed text on trial and returns the answer.
    BrowserAnswer try_reversed(const Browser& browser) {
        const std::string tag = browser.get(api("configuration")).header("ETag");
        return post(browser, "draft", {{"toml", reversed()}, {"seconds", 1000}},
                    {{"If-Match", tag}});
    }
    /// The receiver goes on meanwhile.
    BrowserAnswer post(const Browser& browser, const std::string& what, const nlohmann::json& body,
                       const std::map<std::string, std::string>& more = {}) {
        return post_to(browser, api(what), body, more);
    }
    BrowserAnswer post_to(const Browser& browser, const std::string& path,
                          const nlohmann::json& body,
                          const std::map<std::string, std::string>& more = {}) {
        BrowserAnswer answer;
        std::thread asks([&] { answer = browser.post(path, body, more); });
        std::atomic<bool> done{false};
        std::thread waits([&] {
            asks.join();
            done = true;
        });
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            servos_.listen();
            return done.load();
        }));
        waits.join();
        return answer;
    }

    int port_ = 0;
};

}  // namespace tribus::test
