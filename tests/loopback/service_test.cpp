#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "transports/links/unique_fd.h"

namespace tribus::test::service_test {
namespace {

/// What a service manager passes to a service, and what the service reports.
class Service : public Loopback {
  protected:
    Service() : manager_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        const std::string path = folder() / "notify";
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        EXPECT_EQ(
            ::bind(manager_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
        ::setenv("WATCHDOG_USEC", "2000000", 1);
    }
    ~Service() override {
        ::unsetenv("NOTIFY_SOCKET");
        ::unsetenv("WATCHDOG_USEC");
        ::unsetenv("WATCHDOG_PID");
    }

    /// Everything that was reported so far, one datagram a line.
    const std::string& told() {
        std::array<char, 4096> buffer{};
        for (;;) {
            const ssize_t count =
                ::recv(manager_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
            if (count < 0) {
                return told_;
            }
            told_.append(buffer.data(), static_cast<std::size_t>(count)) += '\n';
        }
    }
    /// Waits for a report while the receiver sends.
    bool tells(const std::string& text, std::size_t times = 1) {
        return eventually([&] {
            repeater_.send_if_due();
            return count_of(text, told()) >= times;
        });
    }
    Program& run_main_job() { return run(write_config(main_job(kPatientInput))); }

    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1100))};

  private:
    UniqueFd manager_;
    std::string told_;
};

TEST_F(Service, IsReadyOnceItRunsAndTellsWhatGoesOn) {
    Program& program = run_main_job();
    EXPECT_TRUE(eventually([&] {
        return count_of("STATUS=servos: in failsafe; receiver: never seen\n", told()) == 1;
    })) << told();
    EXPECT_EQ(told().rfind("READY=1\n", 0), 0U) << told();
    EXPECT_TRUE(tells("STATUS=servos: under control of receiver; receiver: good\n")) << told();
    expect_clean_end(program);
}

TEST_F(Service, SaysThatItStops) {
    Program& program = run_main_job();
    expect_clean_end(program);
    EXPECT_EQ(count_of("STOPPING=1\n", told()), 1U) << told();
}

TEST_F(Service, IsNeverReadyWhereItCannotStart) {
    Program& program = start({"run", write_config("[input.receiver]\n")});
    EXPECT_EQ(program.end(), 2);
    EXPECT_EQ(told(), "");
}

TEST_F(Service, TellsWhenAReloadBeginsAndEnds) {
    Program& program = run_main_job();
    program.signal(SIGHUP);
    EXPECT_TRUE(tells("READY=1\n", 2)) << told();
    EXPECT_EQ(count_of("RELOADING=1\nMONOTONIC_USEC=", told()), 1U) << told();
    expect_clean_end(program);
}

TEST_F(Service, ARefusedReloadEndsToo) {
    Program& program = run_main_job();
    write_config("[input.receiver]\n");
    program.signal(SIGHUP);
    EXPECT_TRUE(tells("READY=1\n", 2)) << told();
    expect_clean_end(program);
}

TEST_F(Service, FeedsTheWatchdog) {
    Program& program = run_main_job();
    EXPECT_TRUE(tells("WATCHDOG=1\n", 3)) << told();
    expect_clean_end(program);
}

TEST_F(Service, TakesNoThreadForHungThatHasJustBegun) {
    Program& program = run(write_config(
        std::string("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n") +
        "timeout = \"5s\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
        "period = \"1s\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"));
    EXPECT_TRUE(eventually([&] { return count_of("WATCHDOG=1\n", told()) == 1; })) << told();
    EXPECT_EQ(program.errors().find("stands still"), std::string::npos) << program.errors();
    expect_clean_end(program);
}

TEST_F(Service, TakesAStopOfTheWholeProgramForNoFaultOfItsThreads) {
    Program& program = run_main_job();
    for (int stop = 1; stop <= 4; ++stop) {
        const std::size_t fed = count_of("WATCHDOG=1\n", told());
        program.signal(SIGSTOP);
        std::this_thread::sleep_for(std::chrono::milliseconds(1300));
        program.signal(SIGCONT);
        EXPECT_TRUE(tells("WATCHDOG=1\n", fed + 1)) << told();
    }
    EXPECT_EQ(program.errors().find("stands still"), std::string::npos) << program.errors();
    EXPECT_EQ(program.errors().find("half of its frames"), std::string::npos) << program.errors();
    expect_clean_end(program);
}

TEST_F(Service, FeedsNoWatchdogOfAnotherProcess) {
    ::setenv("WATCHDOG_PID", "1", 1);
    Program& program = run_main_job();
    EXPECT_TRUE(tells("STATUS=servos: under control of receiver; receiver: good\n")) << told();
    expect_clean_end(program);
    EXPECT_EQ(count_of("WATCHDOG=1", told()), 0U) << told();
}

TEST_F(Service, RunsOnWithoutAServiceManager) {
    ::setenv("NOTIFY_SOCKET", (folder() / "nobody").c_str(), 1);
    Program& program = run_main_job();
    EXPECT_TRUE(program.says("cannot notify the service manager at"));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::service_test
