#include "app/daemon/run.h"

#include <malloc.h>
#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "app/daemon/preparation.h"
#include "tests/loopback/machine/hanging_file.h"
#include "tests/loopback/machine/service_manager.h"
#include "tests/support/far_end.h"
#include "tests/support/sanitized.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// `tribus run` in a child of this process, with its exit status and what it says.
namespace tribus::test::run_command_test {
namespace {

using namespace std::chrono_literals;

/// The child ends with this instead of `run`'s own status if `run` returned.
constexpr int kReturned = 100;

class RunCommand : public testing::Test {
  protected:
    /// Runs in this process, which then ends. `meanwhile` runs on a thread of its own.
    [[noreturn]] void run(const std::function<void()>& meanwhile = {}) const {
        sigset_t ending;
        ::sigemptyset(&ending);
        for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
            ::sigaddset(&ending, signal);
        }
        ::pthread_sigmask(SIG_BLOCK, &ending, nullptr);
        std::thread beside(meanwhile ? meanwhile : [] {});
        Command command = run_command();
        *std::get<std::string*>(command.options[0].value) = file_;
        *std::get<std::optional<std::string>*>(command.options[1].value) = folder_ / "control";
        const int status = command.run();
        beside.join();
        std::fflush(nullptr);
        ::_exit(kReturned + status);
    }
    static void end_by(int signal) { ::kill(::getpid(), signal); }
    nlohmann::json asked(const std::string& socket, const std::string& request) const {
        EXPECT_TRUE(seen_within([&] { return std::filesystem::exists(folder_ / socket); }));
        const auto answer = ask_daemon(folder_ / socket, request, 30s);
        return answer ? *answer : nlohmann::json{{"error", answer.error()}};
    }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd servos_{folder_ / "servos"};
    const Variable no_manager_{"NOTIFY_SOCKET", std::nullopt};
    const std::string text_ =
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"" + receiver_.path() +
        "\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" + servos_.path() +
        "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
        "[runtime]\nrealtime = \"off\"\n";
    const std::string file_ = folder_.write("tribus.toml", text_);
};

TEST_F(RunCommand, EndsWellBySigterm) {
    EXPECT_EXIT(run([] { end_by(SIGTERM); }), testing::ExitedWithCode(kReturned + 0),
                "started .*1 input, 1 output, 1 pipeline.*stopped");
}

TEST_F(RunCommand, EndsWellByCtrlC) {
    EXPECT_EXIT(run([] { end_by(SIGINT); }), testing::ExitedWithCode(kReturned + 0), "stopped");
}

TEST_F(RunCommand, TakesAFileWithMistakesForWrongUse) {
    folder_.write("tribus.toml", "[output");
    EXPECT_EXIT(run(), testing::ExitedWithCode(kReturned + 2), "tribus.toml:1:");
}

TEST_F(RunCommand, FailsWhereItsFileIsNotThere) {
    std::filesystem::remove(file_);
    EXPECT_EXIT(run(), testing::ExitedWithCode(kReturned + 1), "cannot be read: No such file");
}

TEST_F(RunCommand, TakesAProcessorThatThisMachineLacksForWrongUse) {
    folder_.write("tribus.toml", text_ + "cpu = 127\n");
    EXPECT_EXIT(run(), testing::ExitedWithCode(kReturned + 2), "tribus.toml:12:7: \"cpu\" is 127");
}

TEST_F(RunCommand, FailsWhereItsSocketIsTaken) {
    std::ofstream(folder_ / "control") << "mine";
    EXPECT_EXIT(run(), testing::ExitedWithCode(kReturned + 1), "exists and is not a socket");
}

TEST_F(RunCommand, FailsWhereNothingCanBeStarted) {
    servos_.pull();
    std::filesystem::create_symlink(receiver_.path(), servos_.path());
    EXPECT_EXIT(run(), testing::ExitedWithCode(kReturned + 1), "another program uses it");
}

TEST_F(RunCommand, AnswersAtBothSockets) {
    EXPECT_EXIT(run([&] {
                    const bool right =
                        asked("control", "configuration")["file"] == file_ &&
                        asked("look", "configuration")["file"] == file_ &&
                        asked("control", "back")["error"] == "no configuration is on trial" &&
                        asked("look", "back").dump().find("is refused") != std::string::npos;
                    end_by(right ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "stopped");
}

TEST_F(RunCommand, ReloadsWhereAsked) {
    EXPECT_EXIT(run([&] {
                    const bool taken = asked("control", "reload")["taken"] == true;
                    end_by(taken ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "reloaded .*stopped");
}

TEST_F(RunCommand, ReadsTheFileAgainBySighup) {
    EXPECT_EXIT(run([&] {
                    asked("control", "status");
                    std::string other = text_;
                    other.replace(other.find("output.servos"), 13, "output.motors");
                    other.replace(other.find("\"servos\""), 8, "\"motors\"");
                    folder_.write("tribus.toml", other);
                    end_by(SIGHUP);
                    const bool reloaded = seen_within([&] {
                        return asked("control", "status")["outputs"][0]["name"] == "motors";
                    });
                    end_by(reloaded ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "reloaded .*stopped");
}

TEST_F(RunCommand, LooksAtItsOutputsNowAndThen) {
    EXPECT_EXIT(run([&] {
                    const bool counts = seen_within(
                        [&] { return asked("control", "status")["outputs"][0]["rate_hz"] > 0; });
                    end_by(counts ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "stopped");
}

TEST_F(RunCommand, SleepsWhileNothingHappens) {
    EXPECT_EXIT(run([&] {
                    asked("control", "status");
                    const std::clock_t before = std::clock();
                    std::this_thread::sleep_for(500ms);
                    const bool sleeps = std::clock() - before < CLOCKS_PER_SEC / 4;
                    end_by(sleeps ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "stopped");
}

/// All of a stack counts as locked memory.
TEST_F(RunCommand, GivesItsThreadsSmallStacks) {
    EXPECT_EXIT(run([&] {
                    asked("control", "status");
                    std::size_t bytes = 0;
                    std::thread([&] {
                        pthread_attr_t attributes;
                        ::pthread_getattr_np(::pthread_self(), &attributes);
                        ::pthread_attr_getstacksize(&attributes, &bytes);
                        ::pthread_attr_destroy(&attributes);
                    }).join();
                    end_by(bytes < 1024 * 1024 ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "stopped");
}

/// In the heap it would leave gaps between lasting objects.
TEST_F(RunCommand, GivesALongTextAMappingOfItsOwn) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer has its own heap";
    }
    EXPECT_EXIT(run([&] {
                    asked("control", "status");
                    const auto before = ::mallinfo2().hblks;
                    // The heap has room for a few.
                    const std::vector<std::string> texts(100, std::string(80'000, 'x'));
                    const bool apart = ::mallinfo2().hblks > before + texts.size() / 2;
                    end_by(apart ? SIGTERM : SIGKILL);
                }),
                testing::ExitedWithCode(kReturned + 0), "stopped");
}

/// A thread may still use global objects; what was printed is printed all the same.
TEST_F(RunCommand, EndsWithoutWaitingForAFileThatIsNotRead) {
    const std::string printed = folder_ / "printed";
    EXPECT_EXIT(
        {
            std::freopen(printed.c_str(), "w", stdout);
            std::fputs("printed", stdout);
            auto* const hanging = new HangingFile(folder_ / "draft/draft.toml");
            run([&] {
                asked("control", "draft");
                std::thread([&] {
                    ask_daemon(folder_ / "control", "reload draft 10s", 1h);
                }).detach();
                EXPECT_TRUE(seen_within([&] { return !hanging->thread().empty(); }));
                end_by(SIGTERM);
            });
        },
        testing::ExitedWithCode(0), "stopped");
    EXPECT_EQ(folder_.read("printed"), "printed");
}

}  // namespace
}  // namespace tribus::test::run_command_test
