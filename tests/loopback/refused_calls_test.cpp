#include <sys/syscall.h>

#include <csignal>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

/// A filter of system calls, as in a service's SystemCallFilter= or in a container, refuses what
/// the data thread waits with. Numbers of calls that the filter's author did not know get EPERM.
namespace tribus::test::refused_calls_test {
namespace {

using namespace std::chrono_literals;

class RefusedCalls : public Loopback {
  protected:
    RefusedCalls() : receiver_(device("receiver")), servos_(device("servos")) {}
    Program& run_without(std::vector<long> calls) {
        ProgramSettings settings;
        settings.refused_calls = std::move(calls);
        return start({"run", write_config(main_job(kPatientInput))}, settings);
    }
    bool gets_control() {
        Repeater repeater(receiver_, ibus_bytes(sticks_));
        return eventually([&] {
            repeater.send_if_due();
            const auto sights = servos_.listen();
            return std::any_of(sights.begin(), sights.end(), [&](const SbusSight& sight) {
                return sight.good() && same_channels(sight, sbus_sight_of(sticks_));
            });
        });
    }

    const Sticks sticks_{1100, 1200, 1300, 1400, 1500, 1600, 1700,
                         1800, 1900, 1500, 1500, 1500, 1500, 1500};
    FarEnd& receiver_;
    ServoBank servos_;
};

TEST_F(RefusedCalls, WaitsInAnotherWayWithoutTheNewestCall) {
    Program& program = run_without({SYS_epoll_pwait2});
    EXPECT_TRUE(gets_control()) << program.errors();
    expect_clean_end(program);
}

TEST_F(RefusedCalls, EndsWithTheReasonIfNoWayToWaitIsLeft) {
    Program& program = run_without({SYS_epoll_pwait2, SYS_epoll_pwait});
    // The thread cannot learn any more that these bytes come.
    Repeater repeater(receiver_, ibus_bytes(sticks_));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        return !program.runs();
    }));
    EXPECT_EQ(program.end(), 1) << program.errors();
    EXPECT_TRUE(program.says("the data thread cannot wait for its ports: Operation not permitted"))
        << program.errors();
}

}  // namespace
}  // namespace tribus::test::refused_calls_test
