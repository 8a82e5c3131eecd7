#include <csignal>
#include <ctime>

#include <array>
#include <chrono>
#include <cstddef>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/bus_speaker.h"
#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"
#include "tests/loopback/witness.h"

/// The built program between a bus and SBUS servos. A witness checks each frame at the servos: was
/// it ever sent, how old is it, is it marked?
namespace tribus::test::witness_bus_test {
namespace {

using namespace std::chrono_literals;

/// Shifts the wall clock during the object's lifetime. The steady clock stays as it is.
class ClockStep {
  public:
    explicit ClockStep(std::chrono::seconds step) : step_(step) {
        require_guest();
        move(step_);
    }
    ClockStep(const ClockStep&) = delete;
    ClockStep& operator=(const ClockStep&) = delete;
    ~ClockStep() { move(-step_); }

  private:
    static void move(std::chrono::seconds step) {
        timespec now{};
        ::clock_gettime(CLOCK_REALTIME, &now);
        now.tv_sec += step.count();
        EXPECT_EQ(::clock_settime(CLOCK_REALTIME, &now), 0);
    }
    std::chrono::seconds step_;
};

class WitnessedBus : public Loopback, public testing::WithParamInterface<BusLanguage> {
  protected:
    static constexpr auto kTimeout = 200ms;
    static constexpr auto kPeriod = 7ms;
    static constexpr auto kSnapshots = 20ms;
    static constexpr std::size_t kRing = 3;

    ~WitnessedBus() override { std::cout << "witness: " << to_text(witness_.testimony()) << "\n"; }

    /// Starts the program without `recover` and `power_on`, so that only the check of received
    /// frames keeps old values away.
    Program& begin() {
        write_counted_dbc(folder());
        Program& program =
            run(write_config("[input.bus]\ninterface = \"vcan0\"\n" + GetParam().input +
                             "\ntimeout = \"200ms\"\n" + GetParam().tables + R"([output.servos]
protocol = "sbus"
device = "@servos"
period = "7ms"
[pipeline.main]
from = "bus"
to = "servos"
[pipeline.main.failsafe]
hold = "100ms"
recover = "0ms"
power_on = "0ms"
)"));
        EXPECT_TRUE(control_comes()) << program.errors();
        return program;
    }

    void turn() {
        if (Clock::now() >= due_) {
            due_ += kSnapshots;
            send();
        }
        witness_.listen(servos_);
        constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 500'000};
        ::nanosleep(&kPause, nullptr);
    }
    void go_on_for(Clock::duration time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            turn();
        }
    }
    bool control_comes() {
        return eventually([this] {
            turn();
            return witness_.in_control();
        });
    }
    bool control_ends() {
        return eventually([this] {
            turn();
            return !witness_.in_control();
        });
    }

    /// Repeats the three latest snapshots.
    void repeat_old_ones() {
        sender_ = Sender::ring;
        ring_at_ = 0;
    }
    void fall_silent() { sender_ = Sender::silent; }
    void speak_again() { sender_ = Sender::alive; }

    void expect_nothing_stale() const {
        const Testimony& testimony = witness_.testimony();
        EXPECT_EQ(testimony.too_old, 0U) << to_text(testimony);
        EXPECT_EQ(testimony.never_sent, 0U) << to_text(testimony);
        EXPECT_EQ(testimony.strays, 0U) << to_text(testimony);
        EXPECT_GT(testimony.unmarked, 0U) << to_text(testimony);
    }

    VirtualBus bus_;
    /// Opened again after the interface was created again.
    std::optional<RawCan> wire_{"vcan0"};

  private:
    enum class Sender { alive, silent, ring };

    bool send_all(const std::vector<CanFrame>& frames) {
        bool all = wire_.has_value();
        for (const CanFrame& frame : frames) {
            all = wire_ && wire_->send(frame) == 0 && all;
        }
        return all;
    }
    void send() {
        if (sender_ == Sender::ring) {
            send_all(latest_[ring_at_++ % kRing]);
        } else if (sender_ == Sender::alive) {
            std::vector<CanFrame> frames = speaker_->frames(witness_.next());
            send_all(frames) ? witness_.sent() : witness_.spoiled();
            latest_.erase(latest_.begin());
            latest_.push_back(std::move(frames));
        }
    }

    FarEnd& servos_ = device("servos");
    /// A frame may be as old as the input's timeout, and counts for one period.
    Witness witness_{0, kTimeout + kPeriod};
    std::unique_ptr<BusSpeaker> speaker_ = GetParam().speaker();
    std::vector<std::vector<CanFrame>> latest_ = std::vector<std::vector<CanFrame>>(kRing);
    std::size_t ring_at_ = 0;
    Sender sender_ = Sender::alive;
    Clock::time_point due_ = Clock::now();
};

INSTANTIATE_TEST_SUITE_P(Languages, WitnessedBus, testing::ValuesIn(bus_languages()),
                         [](const auto& language) { return language.param.name; });

/// After the longest of the stops the socket is full: it has the oldest frames, the newest were
/// lost.
TEST_P(WitnessedBus, StoppedProgramSendsNothingOldWhenItGoesOn) {
    Program& program = begin();
    for (const auto stall : std::array{200ms, 450ms, 1000ms, 2500ms, 300ms}) {
        program.signal(SIGSTOP);
        go_on_for(stall);
        program.signal(SIGCONT);
        go_on_for(200ms);
        EXPECT_TRUE(control_comes()) << program.errors();
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

/// The kernel's time stamps of waiting frames then give a wrong age.
TEST_P(WitnessedBus, StoppedProgramSendsNothingOldThoughTheClockIsStepped) {
    Program& program = begin();
    for (const auto step : std::array{-17s, 17s, -1s, 1s}) {
        program.signal(SIGSTOP);
        go_on_for(600ms);
        const ClockStep stepped(step);
        go_on_for(200ms);
        fall_silent();
        program.signal(SIGCONT);
        go_on_for(500ms);
        speak_again();
        EXPECT_TRUE(control_comes()) << program.errors();
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_P(WitnessedBus, InterfaceThatGoesDownLeavesNothingOldBehind) {
    Program& program = begin();
    for (int time = 0; time < 2; ++time) {
        bus_.down();
        EXPECT_TRUE(control_ends());
        go_on_for(500ms);
        bus_.up();
        EXPECT_TRUE(control_comes()) << program.errors();
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_P(WitnessedBus, InterfaceThatIsMadeAnewLeavesNothingOldBehind) {
    Program& program = begin();
    for (int time = 0; time < 2; ++time) {
        wire_.reset();
        bus_.remove();
        EXPECT_TRUE(control_ends());
        go_on_for(500ms);
        bus_.create();
        wire_.emplace("vcan0");
        EXPECT_TRUE(control_comes()) << program.errors();
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_P(WitnessedBus, SenderThatFallsSilentIsNotObeyedBeyondTheTimeout) {
    Program& program = begin();
    for (int time = 0; time < 5; ++time) {
        fall_silent();
        EXPECT_TRUE(control_ends());
        go_on_for(300ms);
        speak_again();
        EXPECT_TRUE(control_comes()) << program.errors();
    }
    expect_nothing_stale();
    expect_clean_end(program);
}

TEST_P(WitnessedBus, RingOfThreeOldSnapshotsIsNotObeyed) {
    Program& program = begin();
    go_on_for(500ms);
    repeat_old_ones();
    EXPECT_TRUE(control_ends());
    go_on_for(3s);
    speak_again();
    EXPECT_TRUE(control_comes()) << program.errors();
    expect_nothing_stale();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::witness_bus_test
