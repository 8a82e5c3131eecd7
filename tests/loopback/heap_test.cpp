#include <csignal>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/support/sanitized.h"

namespace tribus::test::heap_test {
namespace {

class HeapTrap : public Loopback {
  protected:
    void SetUp() override {
        if (kSanitized) {
            GTEST_SKIP() << "a sanitizer has the heap";
        }
    }
    Program start_allocating(const std::string& how) {
        return Program(folder(), {how}, {.executable = TRIBUS_ALLOCATING_DATA_THREAD});
    }
};

class HeapTrapOf : public HeapTrap, public testing::WithParamInterface<const char*> {};

TEST_P(HeapTrapOf, EndsAProgramWhoseDataThreadAllocates) {
    Program program = start_allocating(GetParam());
    EXPECT_EQ(program.end(), 128 + SIGABRT);
    EXPECT_EQ(program.errors(), "heap trap: the data thread allocated\n");
}

INSTANTIATE_TEST_SUITE_P(Ways, HeapTrapOf,
                         testing::Values("malloc", "calloc", "realloc", "new", "aligned-new"),
                         [](const auto& how) {
                             std::string name = how.param;
                             std::erase(name, '-');
                             return name;
                         });

TEST_F(HeapTrap, LetsAProgramPassWhoseDataThreadDoesNotAllocate) {
    Program program = start_allocating("nothing");
    EXPECT_EQ(program.end(), 0);
    EXPECT_EQ(program.errors(), "heap trap: watched the data thread\n");
}

class NoAllocation : public Loopback {
  protected:
    /// Configuration with both directions of both protocols at once.
    std::string both_ways() {
        return write_config(main_job("timeout = \"100ms\"", "", R"([pipeline.main.failsafe]
hold = "20ms"
recover = "20ms"

[pipeline.main.channels]
1 = { from = 1, expo = 0.3, deadband = 4, slew = "20000us/s" }
5 = { mix = { 2 = 0.5, 3 = -0.5 } }
16 = { from = 9, above = 1700 }

[input.second]
protocol = "sbus"
device = "@second"

[output.controller]
protocol = "ibus"
device = "@controller"
schedule = "grid"
phase = "locked"

[pipeline.back]
from = ["second", "receiver"]
to = "controller"
)"));
    }
    void exchange_until_good() {
        Repeater first(receiver_, ibus_bytes(sticks_with_first(1400)));
        Repeater second(second_, sbus_bytes(sbus_sight_of(sticks_with_first(1600))));
        ServoBank servos(servos_);
        IbusReader reader(controller_);
        bool servos_good = false;
        bool reader_good = false;
        EXPECT_TRUE(eventually([&] {
            first.send_if_due();
            second.send_if_due();
            for (const SbusSight& sight : servos.listen()) {
                servos_good = servos_good || sight.good();
            }
            for (const Sticks& sticks : reader.listen()) {
                reader_good = reader_good || sticks[0] == 1600;
            }
            return servos_good && reader_good;
        })) << "servos "
            << servos_good << ", controller " << reader_good;
    }
    /// Sends noise, marks of parity errors and a flood, as a wrong bit rate or a loose plug
    /// produces them.
    void send_garbage() {
        std::mt19937 random(20);
        for (int round = 0; round < 40; ++round) {
            Bytes bytes(700);
            std::generate(bytes.begin(), bytes.end(),
                          [&] { return static_cast<std::uint8_t>(random() & 0xFFU); });
            std::fill_n(bytes.begin(), round * 8, std::uint8_t{0xFF});
            receiver_.send(bytes);
            second_.send(bytes);
            eventually([this, count = 0]() mutable {
                servos_.receive();
                controller_.receive();
                return ++count == 5;
            });
        }
    }

    FarEnd& receiver_ = device("receiver");
    FarEnd& servos_ = device("servos");
    FarEnd& second_ = device("second");
    FarEnd& controller_ = device("controller");
};

TEST_F(NoAllocation, OverDropoutsGarbageAndDevicesThatGoAndCome) {
    Program& program = run(both_ways());
    exchange_until_good();
    send_garbage();
    exchange_until_good();
    EXPECT_TRUE(program.says("output servos: in failsafe"));
    exchange_until_good();
    for (FarEnd* device : {&receiver_, &servos_, &second_, &controller_}) {
        device->pull();
        EXPECT_TRUE(program.says(device->path() + ": is gone"));
    }
    for (FarEnd* device : {&receiver_, &servos_, &second_, &controller_}) {
        device->plug_in();
    }
    exchange_until_good();
    expect_clean_end(program);
}

/// Nobody reads the servos' wire until the kernel accepts no more.
TEST_F(NoAllocation, WhileAnOutputIsStuck) {
    FarEnd& fast = device("fast");
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "ibus"
device   = "@receiver"

[output.fast]
protocol = "sbus"
device   = "@fast"
period   = "3200us"
force    = true

[pipeline.main]
from = "receiver"
to   = "fast"
)"));
    EXPECT_TRUE(program.says(" dropped because the port still had the frame before"));
    ServoBank bank(fast);
    EXPECT_TRUE(eventually([&] { return bank.listen().empty(); }));
    EXPECT_TRUE(eventually([&] { return !bank.listen().empty(); })) << "the output stays stuck";
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::heap_test
