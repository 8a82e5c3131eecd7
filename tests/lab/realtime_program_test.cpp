#include <sched.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"

/// The built program on the PREEMPT_RT kernel.
namespace tribus::test::realtime_program_test {
namespace {

/// Returns the threads of every process of the built program on this machine.
std::vector<pid_t> threads_of_program() {
    std::vector<pid_t> threads;
    std::error_code none;
    for (const auto& process : std::filesystem::directory_iterator("/proc", none)) {
        if (std::filesystem::read_symlink(process.path() / "exe", none) != TRIBUS_PROGRAM) {
            continue;
        }
        for (const auto& task :
             std::filesystem::directory_iterator(process.path() / "task", none)) {
            threads.push_back(std::atoi(task.path().filename().c_str()));
        }
    }
    return threads;
}

int priority_of(pid_t thread) {
    sched_param parameters{};
    ::sched_getparam(thread, &parameters);
    return parameters.sched_priority;
}

using LabRealtime = Loopback;

TEST_F(LabRealtime, KernelSaysThatItIsPreemptible) {
    EXPECT_EQ(read_file("/sys/kernel/realtime"), "1");
}

TEST_F(LabRealtime, DataThreadRunsFirstInFirstOutWithMemoryLocked) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config("[runtime]\nrealtime = \"require\"\npriority = 80\n" +
                                        main_job(kPatientInput)));
    std::vector<int> priorities;
    for (const pid_t thread : threads_of_program()) {
        if (::sched_getscheduler(thread) == SCHED_FIFO) {
            priorities.push_back(priority_of(thread));
        }
    }
    EXPECT_EQ(priorities, std::vector<int>{80});
    const std::string locked = shell("grep -h VmLck /proc/[0-9]*/status | grep -v ' 0 kB' | wc -l");
    EXPECT_EQ(locked, "1\n");
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1200)));
    EXPECT_TRUE(eventually([&] {
        repeater.send_if_due();
        for (const SbusSight& sight : servos.listen()) {
            if (sight.good() && sight.raw[0] == sbus_raw(1200)) {
                return true;
            }
        }
        return false;
    })) << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::realtime_program_test
