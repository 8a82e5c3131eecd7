#include "tests/lab/two_programs.h"

#include <cstdlib>
#include <fstream>
#include <thread>

#include "tests/lab/recorded_receiver.h"

namespace tribus::test {
namespace {

using std::chrono::milliseconds;

milliseconds since(Clock::time_point start, Clock::time_point at) {
    return std::chrono::duration_cast<milliseconds>(at - start);
}

/// Adds a row to a file in the laboratory's folder of results. recovery.md is made from that file.
void add_to_table(const std::string& name, milliseconds frame_lost, milliseconds failsafe,
                  milliseconds control) {
    if (std::filesystem::is_directory("/lab")) {
        std::ofstream("/lab/recovery.md", std::ios::app)
            << "| " << name << " | " << frame_lost.count() << " | " << failsafe.count() << " | "
            << control.count() << " |\n";
    }
}

std::string interface_line(const std::string& interface) {
    return interface.empty() ? "" : "interface = \"" + interface + "\"\n";
}

/// The sticks of every tenth row, so that a slow machine needs only seconds. The sticks of the
/// capture move much more slowly.
std::vector<Sticks> some_recorded_sticks(Capture capture) {
    const auto all = recorded_sticks(capture);
    std::vector<Sticks> some;
    for (std::size_t i = 0; i < all.size(); i += 10) {
        if (some.empty() || some.back() != all[i]) {
            some.push_back(all[i]);
        }
    }
    return some;
}

}  // namespace

std::string TwoPrograms::sender_text(const BusJob& job) {
    return R"([input.receiver]
protocol = "ibus"
device   = "@receiver"
timeout  = "400ms"
[output.bus]
)" + interface_line(job.sender_interface) +
           job.format + "\n" + job.sender_lines + R"(
[pipeline.main]
from = "receiver"
to   = "bus"
[pipeline.main.failsafe]
hold    = "300ms"
recover = "300ms"
)" + job.sender_tables;
}

std::string TwoPrograms::reader_text(const BusJob& job) {
    return "[input.bus]\n" + interface_line(job.reader_interface) + job.format + "\n" +
           job.reader_lines + R"(
timeout = "400ms"
[output.servos]
protocol = "sbus"
device   = "@servos"
period   = "7ms"
[pipeline.main]
from = "bus"
to   = "servos"
[pipeline.main.failsafe]
hold    = "300ms"
preset  = { 1 = 1000, 3 = 988, other = 1500 }
recover = "300ms"
)" + job.reader_tables;
}

Program& TwoPrograms::start_sender(const BusJob& job) {
    return run(write_config(sender_text(job), "sender.toml"));
}

Program& TwoPrograms::start_reader(const BusJob& job) {
    return run(write_config(reader_text(job), "reader.toml"));
}

void TwoPrograms::expect_recorded_sticks(const Program& sender, const Program& reader) {
    for (const Capture capture : captures()) {
        const auto rows = some_recorded_sticks(capture);
        ASSERT_GT(rows.size(), 20U) << capture_name(capture);
        for (const Sticks& sticks : rows) {
            const SbusSight wanted = sbus_sight_of(sticks);
            repeater_.change(ibus_bytes(sticks));
            ASSERT_TRUE(carry_until([&](const SbusSight& sight) {
                return sight.good() && same_channels(sight, wanted);
            })) << sender.errors()
                << reader.errors();
        }
    }
    EXPECT_EQ(servos().strays(), 0U);
}

void TwoPrograms::send_if_due() {
    constexpr milliseconds kOnTheWay{50};
    const auto before = repeater_.latest();
    repeater_.send_if_due();
    if (before != Clock::time_point{} && repeater_.latest() - before >= kTimeout - kOnTheWay) {
        ++outages_;
    }
}

bool TwoPrograms::carry_until(const std::function<bool(const SbusSight&)>& done) {
    return eventually([&] {
        send_if_due();
        bool found = false;
        for (const SbusSight& sight : bank_.listen()) {
            found = found || done(sight);
        }
        return found;
    });
}

bool TwoPrograms::carry_until_control() {
    return carry_until([](const SbusSight& sight) { return sight.good(); });
}

bool TwoPrograms::carry_until_failsafe() {
    return carry_until([](const SbusSight& sight) { return sight.failsafe; });
}

std::vector<SbusSight> TwoPrograms::carry_for(milliseconds time) {
    std::vector<SbusSight> all;
    const auto end = Clock::now() + time;
    while (Clock::now() < end) {
        send_if_due();
        for (const SbusSight& sight : bank_.listen()) {
            all.push_back(sight);
        }
        // The programs need the processor, of which a guest may have one only.
        std::this_thread::sleep_for(milliseconds(1));
    }
    return all;
}

TwoPrograms::Outcome TwoPrograms::expect_failsafe_and_recovery(
    const std::string& name, const std::function<void()>& fault,
    const std::function<void()>& end_of_fault) {
    Outcome outcome;
    const SbusSight sticks = sbus_sight_of(sticks_with_first(1234));
    const auto expect_true_sticks = [&](const SbusSight& sight) {
        EXPECT_TRUE(!sight.good() || same_channels(sight, sticks)) << name;
    };
    EXPECT_TRUE(carry_until_control()) << name;
    const auto start = Clock::now();
    fault();
    EXPECT_TRUE(carry_until([&](const SbusSight& sight) {
        expect_true_sticks(sight);
        if (sight.frame_lost && outcome.to_frame_lost == milliseconds::zero()) {
            outcome.to_frame_lost = since(start, sight.seen);
        }
        outcome.to_failsafe = since(start, sight.seen);
        return sight.failsafe;
    })) << name;
    const auto end = Clock::now();
    end_of_fault();
    EXPECT_TRUE(carry_until([&](const SbusSight& sight) {
        expect_true_sticks(sight);
        outcome.to_control = since(end, sight.seen);
        return sight.good();
    })) << name;
    add_to_table(name, outcome.to_frame_lost, outcome.to_failsafe, outcome.to_control);
    return outcome;
}

void TwoPrograms::expect_times(const Outcome& outcome) {
    constexpr milliseconds kPeriods{2 * 10};
    EXPECT_GE(outcome.to_failsafe, kHold - kPeriods);
    EXPECT_GE(outcome.to_control, kRecover - kPeriods);
}

void TwoPrograms::expect_failsafe_time(Clock::duration since_last_frame, milliseconds periods) {
    constexpr milliseconds kStandstill{5000};
    EXPECT_GE(since_last_frame, kTimeout + kHold - periods);
    EXPECT_LE(since_last_frame, kTimeout + kHold + periods + kStandstill);
}

}  // namespace tribus::test
