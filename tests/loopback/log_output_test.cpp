#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/support/shell.h"
#include "transports/links/unique_fd.h"

/// A log that cannot be written, in every way: outputs go on, and go into failsafe.
namespace tribus::test::log_output_test {
namespace {

constexpr std::size_t kFewBytes = 64;
/// The log says what has changed each 200 ms, and a frame goes out each 7 ms.
constexpr int kFramesOfTwoLooks = 60;

class LogOutput : public Loopback {
  protected:
    /// A pipe, with this test as its reader.
    std::string make_pipe() {
        const std::string path = folder() / "log";
        EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
        reader_ = UniqueFd(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
        return path;
    }
    void close_reader() { reader_ = UniqueFd(); }
    /// Fills the pipe, so that the log has no room from its first line on.
    void fill(const std::string& pipe) {
        const UniqueFd writer(::open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
        const std::vector<char> bytes(4096, 'x');
        while (::write(writer.get(), bytes.data(), bytes.size()) > 0) {
        }
    }
    bool servos_see(bool control, int enough) {
        int count = 0;
        return eventually([&] {
            if (control) {
                repeater_.send_if_due();
            }
            for (const SbusSight& sight : servos_.listen()) {
                count += sight.good() == control ? 1 : 0;
            }
            return count >= enough;
        });
    }
    /// Control, a loss, control again: the log has lines about each.
    void fly(Program& program) {
        for (int round = 0; round < 2; ++round) {
            ASSERT_TRUE(servos_see(true, 20));
            if (close_reader_) {
                close_reader();
            }
            ASSERT_TRUE(servos_see(false, kFramesOfTwoLooks));
            ASSERT_TRUE(program.runs()) << "ended with " << program.end().value_or(-1);
        }
        // The heap trap waits for room.
        std::array<char, 4096> bytes{};
        while (reader_.valid() && ::read(reader_.get(), bytes.data(), bytes.size()) > 0) {
        }
        program.signal(SIGTERM);
        EXPECT_EQ(program.end(), 0);
    }
    std::string config() { return write_config(main_job("timeout = \"200ms\"")); }

    UniqueFd reader_;
    bool close_reader_ = false;
    FarEnd& receiver_ = device("receiver");
    FarEnd& servo_wire_ = device("servos");
    ServoBank servos_{servo_wire_};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1250))};
};

TEST_F(LogOutput, WhoseReaderHasGoneStopsNoFailsafe) {
    close_reader_ = true;
    fly(start({"run", config()}, {.errors = make_pipe()}));
}

TEST_F(LogOutput, WhoseReaderDoesNotReadStopsNothing) {
    const std::string pipe = make_pipe();
    fill(pipe);
    fly(start({"run", config()}, {.errors = pipe}));
}

TEST_F(LogOutput, ThatIsFullStopsNothing) {
    fly(start({"run", config()}, {.errors = "/dev/full"}));
}

TEST_F(LogOutput, ThatIsClosedStopsNothing) {
    fly(start({"run", config()}, {.errors = "closed"}));
}

/// The kernel sends SIGXFSZ, which ends a process that does not expect it.
TEST_F(LogOutput, ThatReachesTheLimitOfFileSizesStopsNothing) {
    fly(start({"run", config()}, {.most_file_bytes = kFewBytes}));
}

/// Signals that a process ignores, from /proc/PID/status.
bool ignores(const Program& program, int signal) {
    std::ifstream status("/proc/" + std::to_string(program.pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
        if (line.starts_with("SigIgn:")) {
            return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1U) != 0;
        }
    }
    return false;
}

TEST_F(LogOutput, EndsNoneOfTheProgramsThatServe) {
    const std::string socket = folder() / "page";
    const std::vector<Program*> programs{
        &start({"run", config()}),
        &start({"serve", "--listen", socket, "--state", (folder() / "state").string()},
               {.executable = TRIBUS_WEB}),
        &start({"run", "--broker", "127.0.0.1:1"}, {.executable = TRIBUS_MQTT})};
    for (const Program* program : programs) {
        EXPECT_TRUE(eventually([&] {
            return ignores(*program, SIGPIPE) && ignores(*program, SIGXFSZ);
        })) << program->errors();
    }
}

/// A command that prints results ends when nobody reads them: `head` leaves after a line. The
/// input, i.Bus frames of 14 channels at 1500 us, never ends. `timeout` would end it with status
/// 124.
TEST(ResultsForNobody, EndACommandThatWouldPrintForEver) {
    const Ended result = run_in_shell(
        "channels=$(printf '\\334\\005%.0s' 1 2 3 4 5 6 7 8 9 10 11 12 13 14); "
        "yes \"$(printf ' @%sQ\\363' \"$channels\")\" | "
        "{ timeout 10 \"$TRIBUS\" decode --protocol ibus --input-format raw --format csv; "
        "echo \"status $?\" >&2; } | head -1");
    EXPECT_NE(result.output.find("t_us,ch1"), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("status "), std::string::npos) << result.output;
    EXPECT_EQ(result.output.find("status 124"), std::string::npos) << result.output;
}

/// Libraries throw when standard error cannot be written.
TEST(ErrorsForNobody, LeaveTheExitStatusAsItIs) {
    for (const char* errors : {" 2>/dev/full", " 2>&-"}) {
        const Ended result =
            run_in_shell(std::string("\"$TRIBUS\" check /nowhere.toml") + errors + "; exit $?");
        EXPECT_EQ(result.status, 2) << errors << result.output;
    }
}

}  // namespace
}  // namespace tribus::test::log_output_test
