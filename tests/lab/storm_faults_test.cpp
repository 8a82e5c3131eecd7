#include <sched.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <ctime>
#include <deque>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/can_bus.h"
#include "tests/lab/slcan.h"
#include "tests/loopback/loopback.h"
#include "tests/soak/line.h"

/// Troubles of a machine in the field, one at a time and then all at once. Meanwhile four lines are
/// translated, and the first one also goes out on a CAN bus.
namespace tribus::test::storm_faults_test {
namespace {

using namespace std::chrono_literals;

/// A process that causes one trouble. It is killed with its object.
class Nuisance {
  public:
    explicit Nuisance(const std::function<void()>& body) : pid_(::fork()) {
        if (pid_ == 0) {
            // Without the priority of the test, and the first one for the kernel to kill.
            const sched_param usual{};
            ::sched_setscheduler(0, SCHED_OTHER, &usual);
            std::ofstream("/proc/self/oom_score_adj") << 1000;
            for (;;) {
                body();
            }
        }
    }
    Nuisance(const Nuisance&) = delete;
    Nuisance& operator=(const Nuisance&) = delete;
    ~Nuisance() {
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }

  private:
    pid_t pid_;
};

/// Available memory in KiB, from /proc/meminfo.
long available_memory() {
    std::ifstream file("/proc/meminfo");
    std::string name;
    long kib = 0;
    std::string unit;
    while (file >> name >> kib >> unit && name != "MemAvailable:") {
    }
    return kib;
}

/// Uses nearly all memory, again and again, so that the kernel must drop pages of programs and
/// files.
void use_up_memory() {
    constexpr long kLeftKib = 8 * 1024;
    constexpr std::size_t kStep = 4U << 20U;
    static std::vector<std::vector<char>> taken;
    if (available_memory() > kLeftKib) {
        taken.emplace_back(kStep, '\1');
        return;
    }
    for (std::vector<char>& part : taken) {
        for (std::size_t i = 0; i < part.size(); i += 4096) {
            ++part[i];
        }
    }
}

void step_wall_clock(std::chrono::seconds by) {
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    now.tv_sec += by.count();
    ASSERT_EQ(::clock_settime(CLOCK_REALTIME, &now), 0);
}

class Storm : public Loopback {
  protected:
    static constexpr std::size_t kLines = 4;

    Storm() {
        std::string text;
        for (std::size_t i = 0; i < kLines; ++i) {
            text += lines_.emplace_back(folder(), i).configuration();
        }
        text += "[output.bus]\nprotocol = \"can\"\ninterface = \"" + adapter_.name() +
                "\"\n[pipeline.bus]\nfrom = \"receiver0\"\nto = \"bus\"\n";
        // Far ends are no part of the troubles: they are on time whatever the machine does.
        const sched_param below_the_daemon{.sched_priority = 10};
        ::sched_setscheduler(0, SCHED_FIFO, &below_the_daemon);
        ::mlockall(MCL_CURRENT | MCL_FUTURE);
        daemon_ = &run(write_config(text));
        translate(3s);
        expect_control();
    }
    ~Storm() override {
        ::munlockall();
        const sched_param usual{};
        ::sched_setscheduler(0, SCHED_OTHER, &usual);
    }

    void translate(std::chrono::milliseconds time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            for (SoakLine& line : lines_) {
                line.send(Clock::now());
                line.listen();
            }
            std::this_thread::sleep_for(1ms);
        }
    }
    std::uint64_t marked() const {
        std::uint64_t sum = 0;
        for (const SoakLine& line : lines_) {
            sum += line.testimony().marked;
        }
        return sum;
    }
    /// Checks that every line and the bus are in control in the next second, and that no frame so
    /// far was wrong.
    void expect_control() {
        std::vector<std::uint64_t> before;
        for (const SoakLine& line : lines_) {
            before.push_back(line.testimony().unmarked);
        }
        const std::size_t heard = adapter_.heard().size();
        translate(1s);
        for (std::size_t i = 0; i < kLines; ++i) {
            const Testimony& testimony = lines_[i].testimony();
            EXPECT_GT(testimony.unmarked, before[i]) << "line " << i << "\n" << daemon_->errors();
            EXPECT_EQ(testimony.never_sent, 0U) << "line " << i;
            EXPECT_EQ(testimony.too_old, 0U) << "line " << i;
            EXPECT_EQ(testimony.strays, 0U) << "line " << i;
        }
        EXPECT_GT(adapter_.heard().size(), heard) << daemon_->errors();
    }
    /// Waits until timeout, hold and recover are over.
    void calm_down() { translate(3s); }

    void take_the_bus_away() { adapter_.bus_off(); }
    void give_the_bus_back() {
        set_link_down(adapter_.name());
        set_link_up(adapter_.name());
    }
    void step_the_clock_about() {
        for (const auto by : {3600s, -7200s, 3600s, 1s, -1s}) {
            step_wall_clock(by);
            translate(500ms);
        }
    }

    SlcanAdapter adapter_;
    std::deque<SoakLine> lines_;
    Program* daemon_ = nullptr;
};

TEST_F(Storm, OnTheWholeProcessorCostsNoLineItsControl) {
    const std::uint64_t before = marked();
    {
        const std::array<Nuisance, 4> busy{Nuisance([] {}), Nuisance([] {}), Nuisance([] {}),
                                           Nuisance([] {})};
        translate(3s);
    }
    EXPECT_EQ(marked(), before);
    expect_control();
    expect_clean_end(*daemon_);
}

TEST_F(Storm, ThatLeavesNoMemoryCostsNoLineItsControl) {
    const std::uint64_t before = marked();
    {
        const Nuisance hog(use_up_memory);
        // Waits while the memory still shrinks, which takes a while on a busy machine.
        long least = available_memory();
        auto end = Clock::now() + kPatience;
        while (available_memory() > 32 * 1024 && Clock::now() < end) {
            if (const long available = available_memory(); available < least) {
                least = available;
                end = Clock::now() + kPatience;
            }
            translate(100ms);
        }
        EXPECT_LE(available_memory(), 32 * 1024) << "there is still free memory";
        translate(3s);
    }
    EXPECT_EQ(marked(), before);
    expect_control();
    expect_clean_end(*daemon_);
}

TEST_F(Storm, WithStepsOfTheWallClockCostsNoLineItsControl) {
    const std::uint64_t before = marked();
    step_the_clock_about();
    EXPECT_EQ(marked(), before);
    expect_control();
    expect_clean_end(*daemon_);
}

TEST_F(Storm, WithNoiseAtLineRateCostsOnlyTheLineThatHasIt) {
    const std::uint64_t before = lines_[3].testimony().marked;
    lines_[2].babble(Clock::now() + 3s);
    translate(3s);
    EXPECT_EQ(lines_[3].testimony().marked, before);
    EXPECT_GT(lines_[2].testimony().marked, 0U) << "noise was taken for control";
    calm_down();
    expect_control();
    expect_clean_end(*daemon_);
}

TEST_F(Storm, WithAllTroublesAtOnceEndsWithEveryLineInControl) {
    {
        const std::array<Nuisance, 4> busy{Nuisance([] {}), Nuisance([] {}), Nuisance([] {}),
                                           Nuisance([] {})};
        const Nuisance hog(use_up_memory);
        for (int round = 0; round < 2; ++round) {
            lines_[0].pull_servos();
            lines_[1].pull_receiver();
            lines_[2].babble(Clock::now() + 3s);
            lines_[3].silence(Clock::now() + 3s);
            take_the_bus_away();
            step_the_clock_about();
            lines_[0].plug_in();
            lines_[1].plug_in();
            give_the_bus_back();
            translate(2s);
        }
    }
    calm_down();
    expect_control();
    EXPECT_TRUE(daemon_->says("interface " + adapter_.name() + ": bus-off"));
    expect_clean_end(*daemon_);
}

}  // namespace
}  // namespace tribus::test::storm_faults_test
