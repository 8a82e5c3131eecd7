#include <chrono>
#include <csignal>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/udp_socket.h"

/// What a wire carries once the program cannot go on. The table of docs/failsafe.md, "What stays on
/// an output", names these tests.
namespace tribus::test::remains_test {
namespace {

using namespace std::chrono_literals;

/// SIGUSR2 lets the data thread hang (tests/support/hang_preload.cpp).
struct End {
    int signal = 0;
    const char* name = "";
};

/// A program that is under control until it cannot go on.
class Ended : public Loopback, public testing::WithParamInterface<End> {
  protected:
    static void SetUpTestSuite() {
        if (kSanitized) {
            GTEST_SKIP() << "the library of a sanitizer must be the first one";
        }
    }
    Program& run_to_hang(const std::string& config) {
        Program& program =
            start({std::string("LD_PRELOAD=") + TRIBUS_HANG_PRELOAD, TRIBUS_PROGRAM, "run", config},
                  {.executable = "/usr/bin/env"});
        EXPECT_TRUE(program.says("started")) << program.errors();
        return program;
    }
    /// Frames that still were on their way have arrived afterwards.
    void end(const Program& program) const {
        program.signal(GetParam().signal);
        std::this_thread::sleep_for(100ms);
    }
    /// Sends control for as long as many frames take.
    void go_on_sending() {
        const auto until = Clock::now() + 500ms;
        while (Clock::now() < until) {
            repeater_.send_if_due();
            std::this_thread::sleep_for(2ms);
        }
    }

    FarEnd& receiver_ = device("receiver");
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1250))};
};

class EndedSerial : public Ended {};

TEST_P(EndedSerial, CarriesNothingMoreAndItsLastFrameMayBeControl) {
    ServoBank servos(device("servos"));
    Program& program = run_to_hang(
        write_config(main_job(kPatientInput, "", "[pipeline.main.failsafe]\nrecover = \"0s\"\n")));
    ASSERT_TRUE(eventually([&] {
        repeater_.send_if_due();
        const auto sights = servos.listen();
        return !sights.empty() && sights.back().good();
    })) << program.errors();
    end(program);
    const auto last = servos.listen();
    EXPECT_TRUE(last.empty() || last.back().good()) << "nobody could mark it";
    go_on_sending();
    EXPECT_TRUE(servos.listen().empty());
    EXPECT_EQ(servos.strays(), 0U) << "the last frame is whole";
}

class EndedUdp : public Ended {};

TEST_P(EndedUdp, CarriesNothingMore) {
    UdpSocket servos;
    Program& program = run_to_hang(
        write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n" +
                     std::string(kPatientInput) +
                     "\n[output.servos]\nprotocol = \"network\"\naddress = \"127.0.0.1:" +
                     std::to_string(servos.port()) +
                     "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"));
    ASSERT_TRUE(eventually([&] {
        repeater_.send_if_due();
        return servos.receive().has_value();
    })) << program.errors();
    end(program);
    while (servos.receive()) {
    }
    go_on_sending();
    EXPECT_FALSE(servos.receive());
}

constexpr End kHang{SIGUSR2, "DataThreadHangs"};
constexpr End kStop{SIGSTOP, "Stopped"};
constexpr End kKill{SIGKILL, "Killed"};

const auto name_of = [](const auto& end) { return std::string(end.param.name); };
INSTANTIATE_TEST_SUITE_P(Ends, EndedSerial, testing::Values(kHang, kStop, kKill), name_of);
INSTANTIATE_TEST_SUITE_P(Ends, EndedUdp, testing::Values(kHang, kStop, kKill), name_of);

}  // namespace
}  // namespace tribus::test::remains_test
