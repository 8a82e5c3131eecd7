#pragma once

#include <cstddef>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/program.h"
#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"
#include "tests/support/sanitized.h"

namespace tribus::test {

/// The built program over ptys, in a folder of its own. No test checks a time that a busy machine
/// can exceed. Tests wait for events and compare orders and minimum times.
class Loopback : public testing::Test {
  protected:
    Loopback() {
        std::string name = (std::filesystem::temp_directory_path() / "tribus-XXXXXX").string();
        folder_ = ::mkdtemp(name.data());
    }
    ~Loopback() override { std::filesystem::remove_all(folder_); }

    const std::filesystem::path& folder() const { return folder_; }
    FarEnd& device(const std::string& name) { return devices_.emplace_back(folder_ / name); }

    /// Writes `text` with the path of the device in place of each `@name`.
    std::string write_config(const std::string& text, const std::string& name = "tribus.toml") {
        std::string filled = text;
        for (std::size_t at = filled.find('@'); at != std::string::npos; at = filled.find('@')) {
            filled.replace(at, 1, folder_.string() + "/");
        }
        std::ofstream(folder_ / name) << filled;
        return folder_ / name;
    }

    /// Writes a key file in which each digit is `digit`.
    void write_key(const std::string& name, char digit) {
        std::filesystem::permissions(
            write_config(std::string(64, digit), name),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
    }

    /// Starts `tribus run` and waits until it runs.
    Program& run(const std::string& config) {
        Program& program = programs_.emplace_back(folder_, std::vector<std::string>{"run", config});
        EXPECT_TRUE(program.says("started")) << program.errors();
        return program;
    }
    Program& start(const std::vector<std::string>& arguments,
                   const ProgramSettings& settings = {}) {
        return programs_.emplace_back(folder_, arguments, settings);
    }

    /// For a program of another account. That may have no access to the build folder, so it gets a
    /// copy of the program; it may write to folder().
    ProgramSettings of_ordinary_user(
        std::size_t most_locked_bytes = ProgramSettings{}.most_locked_bytes) {
        namespace fs = std::filesystem;
        fs::permissions(folder_, fs::perms::all);
        const fs::path copy = folder_ / "tribus";
        fs::copy_file(TRIBUS_PROGRAM, copy, fs::copy_options::skip_existing);
        return {.executable = copy.string(),
                .ordinary_user = true,
                .most_locked_bytes = most_locked_bytes};
    }

    /// Every test of `run` ends with this: the program exits when told to, and its data thread has
    /// not allocated.
    static void expect_clean_end(Program& program) {
        EXPECT_TRUE(program.runs());
        program.signal(SIGTERM);
        EXPECT_EQ(program.end(), 0) << program.errors();
        EXPECT_NE(program.errors().find("stopped"), std::string::npos) << program.errors();
        expect_no_allocation(program);
    }
    static void expect_no_allocation(const Program& program) {
        if (!kSanitized) {
            EXPECT_EQ(count_of("heap trap: watched the data thread", program.errors()), 1U);
        }
        EXPECT_EQ(count_of("allocated", program.errors()), 0U) << program.errors();
    }

  private:
    std::filesystem::path folder_;
    std::deque<FarEnd> devices_;
    std::deque<Program> programs_;
};

/// A receiver that repeats one frame at about a receiver's rate whenever it is called.
class Repeater {
  public:
    Repeater(FarEnd& wire, Bytes frame) : wire_(wire), frame_(std::move(frame)) {}
    void send_if_due() {
        constexpr auto kPeriod = std::chrono::milliseconds(7);
        const auto now = Clock::now();
        if (now - latest_ >= kPeriod) {
            latest_ = now;
            wire_.send(frame_);
        }
    }
    /// Time just before the latest frame was sent.
    Clock::time_point latest() const { return latest_; }
    void change(Bytes frame) { frame_ = std::move(frame); }

  private:
    FarEnd& wire_;
    Bytes frame_;
    Clock::time_point latest_{};
};

/// The nine lines, i.Bus at @receiver to SBUS at @servos, with further lines for its tables.
inline std::string main_job(std::string_view input = "", std::string_view output = "",
                            std::string_view pipeline = "") {
    std::string text = "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n";
    text += std::string(input) + "\n";
    text += "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\nperiod = \"7ms\"\n";
    text += std::string(output) + "\n";
    text += "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n";
    return text + std::string(pipeline) + "\n";
}

/// A timeout so long that no stream looks lost on a busy machine.
inline constexpr std::string_view kPatientInput = "timeout = \"5s\"";

}  // namespace tribus::test
