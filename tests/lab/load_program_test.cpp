#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/two_programs.h"

/// Two built programs on a bus that has all that it can carry, and more than a program can read.
namespace tribus::test::load_program_test {
namespace {

using std::chrono::milliseconds;

/// A bus of 125 kbit/s with other traffic, and a stick that moves with every frame.
class SlowBus : public TwoPrograms {
  protected:
    PacedBus bus_{125'000};
    BusJob job_{.sender_interface = bus_.near(), .reader_interface = bus_.far()};
    std::vector<Clock::time_point> sent_ = std::vector<Clock::time_point>(1000);

    /// Moves the first stick up from 1001 us by a microsecond a frame and notes the time. Steps are
    /// 12 ms apart, so a value does not occur again before all its frames have passed.
    void move_stick() {
        const auto now = Clock::now();
        if (now - moved_ < milliseconds(12)) {
            return;
        }
        moved_ = now;
        step_ = step_ % 900 + 1;
        sent_[static_cast<std::size_t>(step_)] = now;
        receiver().send(ibus_bytes(sticks_with_first(1000 + step_)));
    }
    /// Returns how old the stick of a frame was when the servos saw it.
    milliseconds age_of(const SbusSight& sight) const {
        for (int step = 1; step <= 900; ++step) {
            if (sbus_raw(1000 + step) == sight.raw[0]) {
                return std::chrono::duration_cast<milliseconds>(
                    sight.seen - sent_[static_cast<std::size_t>(step)]);
            }
        }
        return milliseconds::max();
    }

  private:
    Clock::time_point moved_{};
    int step_ = 0;
};

TEST_F(SlowBus, OldValuesNeverPassAsGoodAmongCompetingTrafficAndAfterAnOutage) {
    Program& sender = start_sender(job_);
    Program& reader = start_reader(job_);
    RawCan competitor(bus_.near());
    const CanFrame other = make_frame(0x100, {1, 2, 3, 4, 5, 6, 7, 8});
    auto next_other = Clock::now();
    milliseconds oldest{};
    std::size_t good = 0;
    const auto carry = [&](milliseconds time) {
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            move_stick();
            // Uses two fifths of the frames that the bus can carry.
            if (Clock::now() >= next_other) {
                next_other = Clock::now() + std::chrono::microseconds(2500);
                competitor.send(other);
            }
            for (const SbusSight& sight : servos().listen()) {
                if (sight.good()) {
                    ++good;
                    oldest = std::max(oldest, age_of(sight));
                }
            }
            std::this_thread::sleep_for(milliseconds(1));
        }
    };
    ASSERT_TRUE(eventually([&] {
        carry(milliseconds(50));
        return good > 100;
    })) << sender.errors()
        << reader.errors();
    // The timeouts allow 900 ms, which tests under virtual time check exactly (CanChainTest). An
    // emulated machine that waits for its host adds up to a second. Values from the outage would be
    // older.
    constexpr milliseconds kOutage{5000};
    const milliseconds bound = kOutage / 2;
    EXPECT_LT(oldest, bound);

    bus_.stall();
    carry(kOutage);
    EXPECT_TRUE(sender.says("frames are not sent")) << sender.errors();
    good = 0;
    bus_.flow();
    ASSERT_TRUE(eventually([&] {
        carry(milliseconds(50));
        return good > 100;
    }));
    EXPECT_LT(oldest, bound);
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// A node that sends without a pause, thousands of frames a second.
class Flood {
  public:
    explicit Flood(const CanFrame& frame)
        : frame_(frame), thread_([this](const std::stop_token& stop) { run(stop); }) {}
    /// Waits until the node has sent `count` frames.
    bool sent(std::uint64_t count) const {
        return eventually([&] { return sent_ >= count; });
    }

  private:
    void run(const std::stop_token& stop) {
        RawCan node("vcan0");
        while (!stop.stop_requested()) {
            sent_ += node.send(frame_) == 0 ? 1 : 0;
        }
    }
    CanFrame frame_;
    std::atomic<std::uint64_t> sent_ = 0;
    std::jthread thread_;
};

class Flooded : public TwoPrograms {
  protected:
    static constexpr milliseconds kTime{3000};

    /// Checks that every good frame during the flood has the receiver's sticks. Returns their
    /// number.
    std::size_t count_good() {
        std::size_t good = 0;
        for (const SbusSight& sight : carry_for(kTime)) {
            if (sight.good()) {
                ++good;
                EXPECT_TRUE(same_channels(sight, sbus_sight_of(sticks_with_first(1234))));
            }
        }
        return good;
    }
    const VirtualBus bus_;
};

TEST_F(Flooded, ByForeignIdsControlGoesOnAndTheKernelKeepsThemAway) {
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    ASSERT_TRUE(carry_until_control());
    const Flood flood(make_frame(0x100, {1, 2, 3, 4, 5, 6, 7, 8}));
    const auto sender_before = sender.used_time();
    const auto reader_before = reader.used_time();
    EXPECT_GT(count_good(), 100U) << reader.errors();
    EXPECT_TRUE(flood.sent(10'000));
    EXPECT_LT(sender.used_time() - sender_before, kTime / 2);
    EXPECT_LT(reader.used_time() - reader_before, kTime / 2);
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(Flooded, ByItsOwnIdsTheProgramNeverShowsWrongSticksAndComesBack) {
    Program& sender = start_sender({});
    Program& reader = start_reader({});
    ASSERT_TRUE(carry_until_control());
    {
        const Flood flood(make_frame(0x302, {1, 2, 3, 4, 5, 6, 7, 8}));
        count_good();
        EXPECT_TRUE(flood.sent(10'000));
    }
    EXPECT_TRUE(carry_until_control()) << reader.errors();
    EXPECT_TRUE(sender.says("another node sends frames with its ids"));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

}  // namespace
}  // namespace tribus::test::load_program_test
