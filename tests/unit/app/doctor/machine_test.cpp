#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "app/doctor/facts/machine_facts.h"
#include "app/doctor/machine_judge.h"
#include "tests/support/kernel_tree.h"

namespace tribus::doctor::machine_test {
namespace {

class MachineOfADoctor : public testing::Test {
  protected:
    /// A machine without problems.
    MachineOfADoctor() {
        tree.write("sys/kernel/realtime", "1\n");
        tree.write("proc/sys/kernel/osrelease", "6.1.0-18-rt-arm64\n");
        tree.write("proc/sys/kernel/arch", "aarch64\n");
        tree.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
        tree.write("proc/self/status", "Name:\tcat\nCapEff:\t0000000000000000\n");
        tree.write("proc/self/limits",
                   "Limit                     Soft Limit           Hard Limit           Units\n"
                   "Max locked memory         unlimited            unlimited            bytes\n"
                   "Max realtime priority     99                   99\n");
    }
    std::vector<Finding> findings() const {
        return judge_machine(look_at_machine(KernelFiles(tree.root())));
    }
    std::vector<std::string> ids() const {
        std::vector<std::string> all;
        for (const Finding& finding : findings()) {
            all.emplace_back(finding.id);
        }
        return all;
    }
    using Ids = std::vector<std::string>;

    test::KernelTree tree;
};

TEST_F(MachineOfADoctor, ThatIsWellNeedsNothing) {
    EXPECT_EQ(ids(), Ids{});
}

TEST_F(MachineOfADoctor, WithoutRealtimeKernelGetsDebians) {
    tree.write("sys/kernel/realtime", "0\n");
    ASSERT_EQ(ids(), Ids{"machine.kernel_not_realtime"});
    EXPECT_EQ(findings()[0].commands, Ids{"sudo apt install linux-image-rt-arm64"});
    EXPECT_EQ(findings()[0].severity, Severity::advice);
}

TEST_F(MachineOfADoctor, KernelThatSaysItInItsVersionOnlyIsRealtime) {
    tree.write("sys/kernel/realtime", "");
    tree.write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.76-1\n");
    EXPECT_EQ(ids(), Ids{});
}

TEST_F(MachineOfADoctor, WithTooLowASupplyHasAProblem) {
    tree.write("sys/devices/platform/soc/soc:firmware/get_throttled", "50001\n");
    ASSERT_EQ(ids(), (Ids{"machine.undervoltage", "machine.was_throttled"}));
    EXPECT_EQ(findings()[0].severity, Severity::problem);
}

TEST_F(MachineOfADoctor, VoltageMonitorTellsOfTheSupplyToo) {
    tree.write("sys/class/hwmon/hwmon0/name", "rpi_volt\n");
    tree.write("sys/class/hwmon/hwmon0/in0_lcrit_alarm", "1\n");
    EXPECT_EQ(ids(), Ids{"machine.undervoltage"});
}

TEST_F(MachineOfADoctor, ThatIsThrottledNowHasAProblem) {
    tree.write("sys/devices/platform/soc/soc:firmware/get_throttled", "0x60006\n");
    ASSERT_EQ(ids(), Ids{"machine.throttled"});
    EXPECT_EQ(findings()[0].severity, Severity::problem);
}

TEST_F(MachineOfADoctor, ThatWasThrottledIsToldSo) {
    tree.write("sys/devices/platform/soc/soc:firmware/get_throttled", "40000\n");
    EXPECT_EQ(ids(), Ids{"machine.was_throttled"});
}

TEST_F(MachineOfADoctor, RaspberryPiWhoseKernelDoesNotTellIsUnknown) {
    tree.write("proc/device-tree/model", std::string("Raspberry Pi 4 Model B Rev 1.4\0", 31));
    ASSERT_EQ(ids(), Ids{"machine.throttling_unknown"});
    EXPECT_EQ(findings()[0].commands, Ids{"vcgencmd get_throttled"});
}

TEST_F(MachineOfADoctor, ThatIsHotWantsAir) {
    tree.write("sys/class/thermal/thermal_zone0/temp", "83500\n");
    EXPECT_EQ(ids(), Ids{"machine.hot"});
}

TEST_F(MachineOfADoctor, AtItsLowestFrequencyIsToldSo) {
    tree.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
    tree.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_driver", "cpufreq-dt\n");
    EXPECT_EQ(ids(), Ids{"machine.powersave"});
}

TEST_F(MachineOfADoctor, PowersaveOfIntelIsAnOrdinaryGovernor) {
    tree.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
    tree.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_driver", "intel_pstate\n");
    EXPECT_EQ(ids(), Ids{});
}

TEST_F(MachineOfADoctor, ThatGivesRealtimeNoTimeHasAProblem) {
    tree.write("proc/sys/kernel/sched_rt_runtime_us", "0\n");
    ASSERT_EQ(ids(), Ids{"machine.realtime_off"});
    EXPECT_EQ(findings()[0].severity, Severity::problem);
}

TEST_F(MachineOfADoctor, ControlGroupWithoutRealtimeShareIsTold) {
    tree.write("proc/self/cgroup", "5:memory:/\n4:cpu,cpuacct:/user.slice\n0::/\n");
    tree.write("sys/fs/cgroup/cpu/user.slice/cpu.rt_runtime_us", "0\n");
    EXPECT_EQ(ids(), Ids{"machine.realtime_group_off"});
}

TEST_F(MachineOfADoctor, UserWithoutRealtimeRightsGetsTheLines) {
    tree.write("proc/self/limits",
               "Max locked memory         8388608              8388608              bytes\n"
               "Max realtime priority     0                    0\n");
    EXPECT_EQ(ids(), (Ids{"machine.no_realtime_right", "machine.no_memory_right"}));
}

TEST_F(MachineOfADoctor, RootNeedsNoLimits) {
    tree.write("proc/self/status", "CapEff:\t000001ffffffffff\n");
    tree.write("proc/self/limits",
               "Max locked memory         8388608              8388608              bytes\n"
               "Max realtime priority     0                    0\n");
    EXPECT_EQ(ids(), Ids{});
}

TEST_F(MachineOfADoctor, ModemManagerIsTold) {
    tree.process(501, "ModemManager");
    EXPECT_EQ(ids(), Ids{"machine.modem_manager"});
}

}  // namespace
}  // namespace tribus::doctor::machine_test
