#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "app/client/status_fields.h"
#include "tests/loopback/loopback.h"

namespace tribus::test::devices_test {
namespace {

/// Sends until the servos see `wanted`. Returns everything that they saw until then.
std::vector<SbusSight> feed_until(Repeater& sender, ServoBank& servos, const SbusSight& wanted) {
    std::vector<SbusSight> seen;
    EXPECT_TRUE(eventually([&] {
        sender.send_if_due();
        for (const SbusSight& sight : servos.listen()) {
            seen.push_back(sight);
        }
        return !seen.empty() && seen.back().good() && same_channels(seen.back(), wanted);
    }));
    return seen;
}

constexpr std::string_view kShortLoss =
    "[pipeline.main.failsafe]\nhold = \"50ms\"\nrecover = \"50ms\"";

TEST_F(Loopback, InputDeviceThatIsPulledAndPluggedInWorksAgain) {
    FarEnd& receiver = device("receiver");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(main_job("timeout = \"300ms\"", "", kShortLoss)));
    const SbusSight before = sbus_sight_of(sticks_with_first(1200));
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1200)));
    feed_until(repeater, servos, before);

    receiver.pull();
    EXPECT_TRUE(program.says("device " + receiver.path() + ": is gone"));
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos.listen();
        return !seen.empty() && seen.back().failsafe;
    }));
    EXPECT_TRUE(program.runs());

    receiver.plug_in();
    EXPECT_TRUE(program.says("device " + receiver.path() + ": is back"));
    const SbusSight after = sbus_sight_of(sticks_with_first(1800));
    repeater.change(ibus_bytes(sticks_with_first(1800)));
    const std::vector<SbusSight> seen = feed_until(repeater, servos, after);
    EXPECT_TRUE(std::none_of(seen.begin(), seen.end(), [&](const SbusSight& sight) {
        return same_channels(sight, before);
    })) << "values from before the loss came out";
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Loopback, OutputDeviceThatIsPulledAndPluggedInWorksAgain) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    Program& program = run(write_config(main_job(kPatientInput)));
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1200)));
    {
        ServoBank servos(servo_wire);
        feed_until(repeater, servos, sbus_sight_of(sticks_with_first(1200)));
    }
    for (int round = 1; round <= 2; ++round) {
        servo_wire.pull();
        EXPECT_TRUE(program.says(servo_wire.path() + ": is gone", static_cast<std::size_t>(round)));
        servo_wire.plug_in();
        EXPECT_TRUE(program.says(servo_wire.path() + ": is back", static_cast<std::size_t>(round)));
        ServoBank servos(servo_wire);
        const Sticks sticks = sticks_with_first(1300 + 100 * round);
        repeater.change(ibus_bytes(sticks));
        feed_until(repeater, servos, sbus_sight_of(sticks));
        EXPECT_EQ(servos.strays(), 0U);
    }
    expect_clean_end(program);
}

TEST_F(Loopback, OutputWhoseDeviceIsGoneSaysThatItCannotSendAndNothingOfControl) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    Program& program = run(write_config(main_job(kPatientInput)));
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1200)));
    std::optional<ServoBank> servos(servo_wire);
    feed_until(repeater, *servos, sbus_sight_of(sticks_with_first(1200)));
    const auto state = [&] {
        repeater.send_if_due();
        const auto status = ask_daemon(folder() / "control", "status", kPatience);
        return status ? status_fields::text(status_fields::list(*status, "outputs")[0], "state")
                      : "";
    };
    EXPECT_TRUE(eventually([&] { return state() == "control"; }));

    servo_wire.pull();
    EXPECT_TRUE(eventually([&] { return state() == "cannot_send"; }));
    EXPECT_TRUE(program.says("output servos: cannot send: its device is gone"));

    servo_wire.plug_in();
    servos.emplace(servo_wire);
    feed_until(repeater, *servos, sbus_sight_of(sticks_with_first(1200)));
    EXPECT_TRUE(eventually([&] { return state() == "control"; }));
    expect_clean_end(program);
}

TEST_F(Loopback, ProgramEndsInOrderWhileEveryDeviceIsGone) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    Program& program = run(write_config(main_job()));
    receiver.pull();
    servo_wire.pull();
    EXPECT_TRUE(program.says("is gone", 2));
    expect_clean_end(program);
}

/// The kernel reports a hang-up until it is handled. A program that only notes it would loop at
/// real-time priority.
TEST_F(Loopback, DevicesThatAreGoneCostNoProcessorTime) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    Program& program = run(write_config(main_job()));
    receiver.pull();
    servo_wire.pull();
    EXPECT_TRUE(program.says("is gone", 2));
    const auto used_before = program.used_time();
    const auto before = Clock::now();
    eventually([&] { return Clock::now() - before >= std::chrono::seconds(1); });
    EXPECT_LT(program.used_time() - used_before, (Clock::now() - before) / 3);
    expect_clean_end(program);
}

TEST_F(Loopback, DevicesThatGoAndComeLeaveNoDescriptorOpen) {
    FarEnd& receiver = device("receiver");
    FarEnd& servo_wire = device("servos");
    Program& program = run(write_config(main_job()));
    const std::ptrdiff_t open_before = program.open_descriptors();
    for (FarEnd* wire : {&receiver, &servo_wire}) {
        wire->pull();
        EXPECT_TRUE(program.says(wire->path() + ": is gone"));
        wire->plug_in();
        EXPECT_TRUE(eventually([&] { return program.open_descriptors() == open_before; }))
            << open_before << " descriptors before, " << program.open_descriptors() << " now";
    }
    expect_clean_end(program);
}

TEST_F(Loopback, DeviceForBothWaysThatIsPulledAndPluggedInWorksAgain) {
    FarEnd& port = device("port");
    Program& program = run(write_config(R"(
[input.receiver]
protocol = "sbus"
device   = "@port"
timeout  = "5s"

[output.servos]
protocol = "sbus"
device   = "@port"
period   = "7ms"

[pipeline.main]
from = "receiver"
to   = "servos"
)" + std::string(kShortLoss)));
    port.pull();
    EXPECT_TRUE(program.says("is gone"));
    port.plug_in();
    EXPECT_TRUE(program.says("is back"));
    ServoBank servos(port);
    const SbusSight wanted = sbus_sight_of(sticks_with_first(1700));
    Repeater repeater(port, sbus_bytes(wanted));
    feed_until(repeater, servos, wanted);
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

constexpr const char* kTwoReceivers = R"(
[input.main]
protocol = "ibus"
device   = "@main"
timeout  = "500ms"

[input.backup]
protocol = "sbus"
device   = "@backup"
timeout  = "5s"

[output.servos]
protocol = "sbus"
device   = "@servos"
period   = "7ms"

[pipeline.main]
from = ["main", "backup"]
to   = "servos"

[pipeline.main.failsafe]
recover = "100ms"
)";

TEST_F(Loopback, BackupTakesOverFromAPulledMainAndGivesControlBack) {
    FarEnd& main_wire = device("main");
    FarEnd& backup_wire = device("backup");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(kTwoReceivers));
    const SbusSight from_main = sbus_sight_of(sticks_with_first(1800, 14));
    const SbusSight from_backup = sbus_sight_of(sticks_with_first(1200));
    Repeater main_receiver(main_wire, ibus_bytes(sticks_with_first(1800, 14)));
    Repeater backup(backup_wire, sbus_bytes(from_backup));
    std::vector<SbusSight> seen;
    const auto until_good = [&](const SbusSight& wanted, bool main_sends) {
        EXPECT_TRUE(eventually([&] {
            if (main_sends) {
                main_receiver.send_if_due();
            }
            backup.send_if_due();
            for (const SbusSight& sight : servos.listen()) {
                seen.push_back(sight);
            }
            return !seen.empty() && seen.back().good() && same_channels(seen.back(), wanted);
        }));
    };
    until_good(from_main, true);
    main_wire.pull();
    seen.clear();
    until_good(from_backup, false);
    EXPECT_TRUE(std::none_of(seen.begin(), seen.end(), [](const SbusSight& sight) {
        return sight.failsafe;
    })) << "the healthy backup should have taken over at once";
    EXPECT_TRUE(program.says("input main: wire silent"));

    main_wire.plug_in();
    EXPECT_TRUE(program.says("is back"));
    until_good(from_main, true);
    expect_clean_end(program);
}

TEST_F(Loopback, ReceiverThatIsMissingAtTheStartIsWaitedForWhileTheOtherControls) {
    FarEnd& backup_wire = device("backup");
    ServoBank servos(device("servos"));
    Program& program = run(write_config(kTwoReceivers));
    EXPECT_TRUE(program.says("/main: there is no such device"));
    const SbusSight from_backup = sbus_sight_of(sticks_with_first(1200));
    Repeater backup(backup_wire, sbus_bytes(from_backup));
    feed_until(backup, servos, from_backup);

    FarEnd& main_wire = device("main");
    EXPECT_TRUE(program.says("device " + main_wire.path() + ": is there"));
    Repeater main_receiver(main_wire, ibus_bytes(sticks_with_first(1800, 14)));
    const SbusSight from_main = sbus_sight_of(sticks_with_first(1800, 14));
    EXPECT_TRUE(eventually([&] {
        backup.send_if_due();
        main_receiver.send_if_due();
        const auto seen = servos.listen();
        return !seen.empty() && seen.back().good() && same_channels(seen.back(), from_main);
    }));
    EXPECT_EQ(count_of("waiting for it", program.errors()), 1U) << program.errors();
    expect_clean_end(program);
}

TEST_F(Loopback, OutputDeviceThatIsMissingAtTheStartIsWaitedFor) {
    FarEnd& receiver = device("receiver");
    Program& program = run(write_config(main_job(kPatientInput)));
    EXPECT_TRUE(program.says("output servos: cannot send: its device is gone"));
    FarEnd& servo_wire = device("servos");
    EXPECT_TRUE(program.says("device " + servo_wire.path() + ": is there"));
    ServoBank servos(servo_wire);
    Repeater repeater(receiver, ibus_bytes(sticks_with_first(1200)));
    feed_until(repeater, servos, sbus_sight_of(sticks_with_first(1200)));
    EXPECT_EQ(servos.strays(), 0U);
    expect_clean_end(program);
}

/// A link under /dev/serial/by-id whose adapter is just being removed, or one with no target.
TEST_F(Loopback, LinkToADeviceThatIsNotThereIsWaitedFor) {
    device("servos");
    std::filesystem::create_symlink(folder() / "nothing", folder() / "receiver");
    Program& program = run(write_config(main_job()));
    EXPECT_TRUE(program.says("/receiver: there is no such device"));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::devices_test
