#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "app/client/ask_daemon.h"
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
    /// Control, a loss, control again: the log has lines about each. None gets onto a wire.
    void fly(Program& program) {
        // Before the program has set its port, the kernel echoes what a receiver sends.
        ASSERT_TRUE(servos_see(false, 1));
        for (int round = 0; round < 2; ++round) {
            ASSERT_TRUE(servos_see(true, 20));
            if (close_reader_) {
                close_reader();
            }
            ASSERT_TRUE(servos_see(false, kFramesOfTwoLooks));
            ASSERT_TRUE(program.runs()) << "ended with " << program.end().value_or(-1);
        }
        EXPECT_EQ(servos_.strays(), 0U);
        EXPECT_EQ(receiver_.receive(), Bytes{});
        // The heap trap's report at the end is written to the log and waits for room.
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

/// How a log can fail: no room, and no reader.
class LogOfAServer : public LogOutput, public testing::WithParamInterface<const char*> {
  protected:
    ProgramSettings settings(const std::string& executable) {
        const bool pipe = std::string_view(GetParam()) == "a pipe";
        return {.executable = executable, .errors = pipe ? make_pipe() : "/dev/full"};
    }
    /// The pipe's reader goes as soon as the log has its first line.
    void lose_reader() {
        char byte = 0;
        EXPECT_TRUE(!reader_.valid() ||
                    eventually([&] { return ::read(reader_.get(), &byte, 1) == 1; }));
        close_reader();
    }
};

INSTANTIATE_TEST_SUITE_P(Each, LogOfAServer, testing::Values("/dev/full", "a pipe"),
                         [](const auto& log) {
                             return std::string(log.index == 0 ? "HasNoRoom" : "HasNoReader");
                         });

/// A loss is told to the log. The control socket answers afterwards.
TEST_P(LogOfAServer, LetsTheDaemonAnswer) {
    Program& program = start({"run", config()}, settings(TRIBUS_PROGRAM));
    ASSERT_TRUE(servos_see(false, 1));
    lose_reader();
    ASSERT_TRUE(servos_see(true, 20));
    ASSERT_TRUE(servos_see(false, kFramesOfTwoLooks));
    EXPECT_TRUE(ask_daemon(folder() / "control", "status", kPatience));
    EXPECT_TRUE(program.runs());
}

/// Each connection that the broker ends is told to the log; the next one shows that it goes on.
TEST_P(LogOfAServer, LetsTheMqttProgramConnectAgain) {
    const UniqueFd broker(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ASSERT_EQ(::bind(broker.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    ASSERT_EQ(::listen(broker.get(), 1), 0);
    ::getsockname(broker.get(), reinterpret_cast<sockaddr*>(&address), &size);
    Program& program =
        start({"run", "--broker", "127.0.0.1:" + std::to_string(ntohs(address.sin_port))},
              settings(TRIBUS_MQTT));
    int connections = 0;
    EXPECT_TRUE(eventually([&] {
        const UniqueFd connection(::accept(broker.get(), nullptr, nullptr));
        connections += connection.valid() ? 1 : 0;
        if (connections == 1 && connection.valid()) {
            lose_reader();
        }
        return connections == 3;
    })) << connections;
    EXPECT_TRUE(program.runs());
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
