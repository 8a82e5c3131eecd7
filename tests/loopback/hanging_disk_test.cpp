#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/replace_file.h"
#include "app/client/ask_daemon.h"
#include "tests/loopback/recorded.h"

/// Reloads while the disk of recordings and epoch files does not answer: nobody waits for it, and
/// what it was to get is written later.
namespace tribus::test::hanging_disk_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// In this time a reload would be over that waits for nothing.
constexpr auto kAWhile = 2s;

class HangingDisk : public Recorded {
  protected:
    HangingDisk() { ::setenv("TRIBUS_HANGING_DISK", sign().c_str(), 1); }
    ~HangingDisk() override {
        answer();
        ::unsetenv("TRIBUS_HANGING_DISK");
    }
    fs::path sign() const { return folder() / "disk-hangs"; }
    void hang() const { std::ofstream{sign()}; }
    void answer() const { fs::remove(sign()); }

    Program& run_on_disk(const std::string& config) {
        Program& program = start(
            {std::string("LD_PRELOAD=") + TRIBUS_HEAP_TRAP + " " + TRIBUS_HANGING_DISK_PRELOAD,
             TRIBUS_PROGRAM, "run", config},
            {.executable = "/usr/bin/env", .runtime_directory = runtime_.path().string()});
        EXPECT_TRUE(program.says("started")) << program.errors();
        return program;
    }
    /// Begins a recording, which waits for the disk.
    Program& begin_recording() {
        hang();
        Program& asking = request();
        EXPECT_TRUE(eventually([&] { return !found().empty(); }));
        return asking;
    }
    bool is_recorded() const {
        return eventually(
            [&] { return found().size() == 1 && found()[0].extension() != ".unfinished"; });
    }
    /// Reloads, and returns whether the log says so for the `times`-th time. The disk does not
    /// answer before: a reload that waits for it does so for ever.
    static bool reloads(const Program& program, const std::string& text, std::size_t times = 1,
                        std::chrono::seconds patience = kPatience) {
        program.signal(SIGHUP);
        return eventually([&] { return count_of(text, program.errors()) >= times; }, patience);
    }
    std::string without_recorder(const std::string& more = "") {
        return write_config(main_job(kPatientInput) + more);
    }

    static void SetUpTestSuite() {
        if (kSanitized) {
            GTEST_SKIP() << "the library of a sanitizer must be the first one";
        }
    }
};

TEST_F(HangingDisk, AReloadWithAStopDoesNotWaitForARecording) {
    Program& program = run_on_disk(config_with(""));
    ASSERT_TRUE(drive({1234}));
    Program& asking = begin_recording();
    config_with("[runtime]\npriority = 70\n");
    EXPECT_TRUE(reloads(program, "started", 2)) << program.errors();
    EXPECT_TRUE(drive({1250}));
    answer();
    EXPECT_TRUE(is_recorded());
    EXPECT_EQ(asking.end(), 0) << asking.errors();
    expect_clean_end(program);
}

TEST_F(HangingDisk, AReloadThatEndsTheRecorderDoesNotWaitForARecording) {
    Program& program = run_on_disk(config_with(""));
    ASSERT_TRUE(drive({1234}));
    begin_recording();
    without_recorder();
    EXPECT_TRUE(reloads(program, "reloaded")) << program.errors();
    EXPECT_TRUE(reloads(program, "reloaded", 2)) << "the main thread does not hang";
    EXPECT_TRUE(drive({1250}));
    answer();
    EXPECT_TRUE(is_recorded());
    expect_clean_end(program);
}

TEST_F(HangingDisk, AReloadThatBringsTheRecorderBackFindsItAtWork) {
    Program& program = run_on_disk(config_with(""));
    ASSERT_TRUE(drive({1234}));
    begin_recording();
    without_recorder();
    EXPECT_TRUE(reloads(program, "reloaded")) << program.errors();
    config_with("");
    EXPECT_TRUE(reloads(program, "reloaded", 2)) << program.errors();
    EXPECT_TRUE(drive({1250}));
    answer();
    EXPECT_TRUE(is_recorded());
    Program& asking = request();
    EXPECT_EQ(asking.end(), 0) << asking.errors();
    expect_clean_end(program);
}

/// A second output, whose frames have numbers of a file.
/// A draft that takes the place of its file is kept, however long the disk needs.
TEST_F(HangingDisk, NobodyGoesBackFromADraftThatTakesThePlaceOfItsFile) {
    const auto said_by = [&](std::string_view request) {
        const auto answer = ask_daemon((runtime_.path() / "control").string(), request, kPatience);
        return answer ? *answer : nlohmann::json{{"error", answer.error()}};
    };
    const std::string file = without_recorder("# draft\n");
    const std::string draft = content(file);
    Program& program = run_on_disk(without_recorder());
    ASSERT_EQ(said_by("draft")["type"], "draft");
    std::ofstream(runtime_.path() / "draft/draft.toml") << draft;
    ASSERT_TRUE(said_by("reload draft 1s")["taken"]);
    ASSERT_TRUE(write_successor(file, draft, 0644));
    hang();
    auto kept = std::async(std::launch::async, [&] { return said_by("confirm"); });
    ASSERT_TRUE(eventually([&] { return !fs::exists(successor_of(file)); }));
    auto back = std::async(std::launch::async, [&] { return said_by("back"); });
    EXPECT_FALSE(eventually([&] { return count_of("going back", program.errors()) > 0; }, kAWhile));
    answer();
    EXPECT_EQ(kept.get()["taken"], true);
    EXPECT_EQ(back.get()["error"], "no configuration is on trial");
    EXPECT_EQ(content(file), draft);
    expect_clean_end(program);
}

class HangingEpoch : public HangingDisk {
  protected:
    HangingEpoch() { write_key("boat.key", '7'); }
    std::string with_epoch() {
        return without_recorder(
            "[output.radio]\nprotocol = \"network\"\naddress = \"127.0.0.1:5717\"\n"
            "key = \"@boat.key\"\nepoch = \"@boat.epoch\"\n[pipeline.radio]\n"
            "from = \"receiver\"\nto = \"radio\"\n");
    }
};

TEST_F(HangingEpoch, AReloadThatEndsItsLinkDoesNotWait) {
    Program& program = run_on_disk(with_epoch());
    ASSERT_TRUE(drive({1234}));
    const std::string reserved = content(folder() / "boat.epoch");
    hang();
    without_recorder();
    EXPECT_TRUE(reloads(program, "reloaded")) << program.errors();
    EXPECT_TRUE(reloads(program, "reloaded", 2)) << "the main thread does not hang";
    EXPECT_TRUE(drive({1250}));
    EXPECT_EQ(content(folder() / "boat.epoch"), reserved);
    answer();
    EXPECT_TRUE(eventually([&] { return content(folder() / "boat.epoch") != reserved; }));
    expect_clean_end(program);
}

TEST_F(HangingEpoch, AReloadThatAddsItsLinkWaitsWithoutTheMainThread) {
    Program& program = run_on_disk(without_recorder());
    ASSERT_TRUE(drive({1234}));
    hang();
    with_epoch();
    EXPECT_FALSE(reloads(program, "reloaded", 1, kAWhile)) << "its numbers must be stored first";
    EXPECT_TRUE(drive({1250}));
    Program& asking = start({"status", "--socket", (runtime_.path() / "control").string()});
    EXPECT_TRUE(asking.end().has_value()) << "the main thread hangs";
    answer();
    EXPECT_TRUE(program.says("reloaded")) << program.errors();
    expect_clean_end(program);
}

TEST_F(HangingEpoch, AReloadWithAStopGoesOnWithItsNumbers) {
    Program& program = run_on_disk(with_epoch());
    ASSERT_TRUE(drive({1234}));
    hang();
    std::ofstream(folder() / "tribus.toml", std::ios::app) << "[runtime]\npriority = 70\n";
    EXPECT_TRUE(reloads(program, "started", 2)) << program.errors();
    EXPECT_TRUE(drive({1250}));
    answer();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::hanging_disk_test
