#include "app/daemon/service_notify.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/loopback/machine/service_manager.h"
#include "tests/support/device_stand_in.h"
#include "tests/support/far_end.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// A service manager hears this, byte for byte.
namespace tribus::test::service_notify_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;

class NotifySocketOf : public testing::Test {
  protected:
    TemporaryFolder folder_;
    LogInMemory logged_{"%v"};
};

TEST_F(NotifySocketOf, NoServiceManagerSendsNothing) {
    const Variable none("NOTIFY_SOCKET", std::nullopt);
    const NotifySocket socket = NotifySocket::from_environment();
    EXPECT_FALSE(socket.connected());
    EXPECT_FALSE(socket.send("READY=1"));
    EXPECT_EQ(logged_.text(), "");
}

TEST_F(NotifySocketOf, APathIsThatFile) {
    ServiceManager manager(folder_ / "notify");
    const Variable path("NOTIFY_SOCKET", folder_ / "notify");
    const NotifySocket socket = NotifySocket::from_environment();
    EXPECT_TRUE(socket.connected());
    EXPECT_TRUE(socket.send("READY=1\nSTATUS=all is well"));
    EXPECT_EQ(manager.told(), Lines{"READY=1\nSTATUS=all is well"});
    EXPECT_EQ(logged_.text(), "");
}

TEST_F(NotifySocketOf, AnAbstractNameIsNoFile) {
    const std::string name = "@tribus-notify-" + std::to_string(::getpid());
    ServiceManager manager(name);
    const Variable abstract("NOTIFY_SOCKET", name);
    EXPECT_TRUE(NotifySocket::from_environment().send("READY=1"));
    EXPECT_EQ(manager.told(), Lines{"READY=1"});
}

TEST_F(NotifySocketOf, ALongPathIsTaken) {
    const std::string path = (folder_ / "") + std::string(107 - (folder_ / "").size(), 'n');
    ServiceManager manager(path);
    const Variable notify("NOTIFY_SOCKET", path);
    EXPECT_TRUE(NotifySocket::from_environment().send("READY=1"));
    EXPECT_EQ(manager.told(), Lines{"READY=1"});
}

TEST_F(NotifySocketOf, WhatIsNoAddressIsToldInTheLog) {
    for (const std::string& name : {std::string("notify"), std::string(),
                                    "/" + std::string(107, 'n'), "@" + std::string(107, 'n')}) {
        const Variable notify("NOTIFY_SOCKET", name);
        EXPECT_FALSE(NotifySocket::from_environment().connected());
        EXPECT_EQ(logged_.take_lines_of(""),
                  "cannot notify the service manager at " + name +
                      ": neither a path nor an abstract name of at most 107 bytes\n");
    }
}

TEST_F(NotifySocketOf, APathAtWhichNobodyListensIsToldInTheLog) {
    const Variable notify("NOTIFY_SOCKET", folder_ / "nobody");
    const NotifySocket socket = NotifySocket::from_environment();
    EXPECT_FALSE(socket.connected());
    EXPECT_FALSE(socket.send("READY=1"));
    EXPECT_EQ(logged_.text(), "cannot notify the service manager at " + (folder_ / "nobody") +
                                  ": No such file or directory\n");
}

TEST_F(NotifySocketOf, AServiceManagerThatReadsNothingIsNotWaitedForLong) {
    ServiceManager manager(folder_ / "notify");
    const Variable path("NOTIFY_SOCKET", folder_ / "notify");
    const NotifySocket socket = NotifySocket::from_environment();
    int sent = 0;
    while (sent < 10'000 && socket.send("READY=1")) {
        ++sent;
    }
    EXPECT_GT(sent, 0);
    EXPECT_LT(sent, 10'000);
    EXPECT_EQ(manager.told().size(), static_cast<std::size_t>(sent));
}

/// A device whose driver takes its time for each frame while it is slow.
class SlowDevice : public DeviceStandIn {
  public:
    explicit SlowDevice(const std::string& path) : DeviceStandIn(path) {}
    Answer control(unsigned long /*request*/, void* /*argument*/) override { return {}; }
    Answer write(std::span<const std::uint8_t> /*bytes*/) override {
        if (slow) {
            std::this_thread::sleep_for(50ms);
        }
        return {};
    }

    std::atomic<bool> slow = false;
};

/// An appliance of two outputs. After its `end` its figures stay as they are, and the test's times
/// are all that changes.
class ServiceNotifyOf : public testing::Test {
  protected:
    ServiceNotifyOf() {
        auto started = Appliance::start(
            load_configuration(
                "[input.receiver]\nprotocol = \"ibus\"\ntimeout = \"10s\"\ndevice = \"" +
                    receiver_.path() +
                    "\"\n[output.lamp]\nprotocol = \"ibus\"\nperiod = \"300ms\"\ndevice = \"" +
                    lamp_.path() +
                    "\"\n[output.servos]\nprotocol = \"sbus\"\nperiod = \"10ms\"\ndevice = \"" +
                    servos_.path() +
                    "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = [\"lamp\", \"servos\"]\n"
                    "[runtime]\nrealtime = \"off\"\n",
                "test.toml")
                .value());
        EXPECT_TRUE(started) << started.error().front();
        appliance_ = std::move(*started);
        EXPECT_TRUE(seen_within([&] { return appliance_->figures_at() != Instant{}; }));
    }
    /// Lets the data thread end. Returns an instant at which its output was not late, also where a
    /// busy machine let it be.
    Instant freeze() {
        appliance_->end();
        return std::min(appliance_->figures_at(), appliance_->output_status(0).due);
    }
    ServiceNotify& start(Instant now) {
        service_.emplace();
        service_->started(now);
        EXPECT_EQ(manager_.told(), Lines{"READY=1"});
        return *service_;
    }
    /// Looks, and returns what the service manager is told then, without the status.
    Lines feeds(Instant now) {
        service_->look(*appliance_, now);
        Lines told = manager_.told();
        std::erase_if(told, [](const std::string& line) { return line.starts_with("STATUS="); });
        return told;
    }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd lamp_{folder_ / "lamp"};
    FarEnd servos_{folder_ / "servos"};
    SlowDevice slow_servos_{servos_.path()};
    LogInMemory logged_{"%v"};
    ServiceManager manager_{folder_ / "notify"};
    const Variable notify_{"NOTIFY_SOCKET", folder_ / "notify"};
    const Variable no_watchdog_{"WATCHDOG_USEC", std::nullopt};
    const Variable no_pid_{"WATCHDOG_PID", std::nullopt};
    std::unique_ptr<Appliance> appliance_;
    std::optional<ServiceNotify> service_;
};

const Lines kFed{"WATCHDOG=1"};
const Lines kNotFed{};
constexpr std::string_view kStatus =
    "STATUS=lamp: in failsafe; waits for the end of the program; servos: in failsafe; waits for "
    "the "
    "end of the program; receiver: never seen";

TEST_F(ServiceNotifyOf, AReloadSaysWhenItBegan) {
    ServiceNotify& service = start(freeze());
    const auto usec = [] {
        return std::chrono::duration_cast<std::chrono::microseconds>(awake_time_now()).count();
    };
    const auto before = usec();
    service.reloading();
    const auto after = usec();
    const Lines told = manager_.told();
    ASSERT_EQ(told.size(), 1U);
    const std::string begin = "RELOADING=1\nMONOTONIC_USEC=";
    const std::string end = "\nSTATUS=reading the configuration again";
    ASSERT_TRUE(told[0].starts_with(begin)) << told[0];
    ASSERT_TRUE(told[0].ends_with(end)) << told[0];
    const auto at =
        std::stoll(told[0].substr(begin.size(), told[0].size() - begin.size() - end.size()));
    EXPECT_GE(at, before);
    EXPECT_LE(at, after);
}

TEST_F(ServiceNotifyOf, TheEndSaysWhatOutputsDo) {
    start(freeze()).stopping();
    EXPECT_EQ(manager_.told(),
              Lines{"STOPPING=1\nSTATUS=outputs send their last frames as their failsafe demands"});
}

/// A failsafe that lasts is told in steps of time, of which the first is 1 s. A busy machine may
/// take five seconds until the appliance is frozen.
TEST_F(ServiceNotifyOf, TheStatusIsToldAtOnceAndThenIfItChangesEachSecond) {
    const Instant now = freeze();
    ServiceNotify& service = start(now);
    service.look(*appliance_, now);
    EXPECT_EQ(manager_.told_without_times(), Lines{std::string(kStatus)});
    service.look(*appliance_, now + 3500ms);
    EXPECT_EQ(manager_.told().size(), 1U) << "the data thread stands";
    service.look(*appliance_, now + 4600ms);
    EXPECT_EQ(manager_.told(), Lines{}) << "more than 3 s, still";
    service.look(*appliance_, now + 11s);
    EXPECT_EQ(manager_.told().size(), 1U) << "more than 10 s";
}

TEST_F(ServiceNotifyOf, TheStatusIsNotToldAgainWithinASecond) {
    const Instant now = freeze();
    ServiceNotify& service = start(now);
    service.look(*appliance_, now + 900ms);
    EXPECT_EQ(manager_.told().size(), 1U);
    service.look(*appliance_, now + 1899ms);
    EXPECT_EQ(manager_.told(), Lines{}) << "it would have changed: the data thread stands";
    service.look(*appliance_, now + 1900ms);
    EXPECT_EQ(manager_.told().size(), 1U);
}

TEST_F(ServiceNotifyOf, TheStatusIsToldAgainAfterAReload) {
    const Instant now = freeze();
    ServiceNotify& service = start(now);
    service.look(*appliance_, now);
    service.started(now);
    service.look(*appliance_, now);
    EXPECT_EQ(manager_.told_without_times(),
              (Lines{std::string(kStatus), "READY=1", std::string(kStatus)}));
}

TEST_F(ServiceNotifyOf, TheStatusOfAllGoodNamesInputAndOutputs) {
    ServiceNotify& service = start(monotonic_now());
    EXPECT_TRUE(seen_within([&] {
        receiver_.send(from_hex(kIa6bFrame));
        lamp_.receive();
        servos_.receive();
        service.look(*appliance_, monotonic_now());
        const Lines told = manager_.told();
        return !told.empty() && told.back() ==
                                    "STATUS=lamp: under control of receiver; servos: under "
                                    "control of receiver; receiver: good";
    }));
}

TEST_F(ServiceNotifyOf, WithoutAServiceManagerNothingIsLookedAt) {
    const Variable none("NOTIFY_SOCKET", std::nullopt);
    const Variable usec("WATCHDOG_USEC", "400000");
    ServiceNotify service;
    service.look(*appliance_, freeze());
    service.reloading();
    service.stopping();
    EXPECT_EQ(manager_.told(), Lines{});
}

TEST_F(ServiceNotifyOf, AWatchdogIsFedEachHalfOfItsTime) {
    const Variable usec("WATCHDOG_USEC", "400000");
    const Instant now = freeze();
    start(now);
    EXPECT_EQ(feeds(now), kFed);
    EXPECT_EQ(feeds(now + 199ms), kNotFed);
    EXPECT_EQ(feeds(now + 200ms), kFed);
}

TEST_F(ServiceNotifyOf, AWatchdogForThisProcessIsFed) {
    const Variable usec("WATCHDOG_USEC", "400000");
    const Variable pid("WATCHDOG_PID", std::to_string(::getpid()));
    const Instant now = freeze();
    start(now);
    EXPECT_EQ(feeds(now), kFed);
}

TEST_F(ServiceNotifyOf, AWatchdogForAnotherProcessIsNotFed) {
    const Variable usec("WATCHDOG_USEC", "400000");
    const Instant now = freeze();
    for (const std::string& other :
         {std::to_string(::getpid() + 1), std::string("1"), std::string("me"), std::string()}) {
        const Variable pid("WATCHDOG_PID", other);
        start(now);
        EXPECT_EQ(feeds(now), kNotFed) << other;
    }
}

TEST_F(ServiceNotifyOf, AWatchdogMayHaveFromAMicrosecondToADay) {
    const Instant now = freeze();
    for (const char* time : {"1", "86400000000"}) {
        const Variable usec("WATCHDOG_USEC", time);
        start(now);
        EXPECT_EQ(feeds(now), kFed) << time;
    }
    for (const char* time : {"0", "86400000001", "18446744073709551615", "18446744073709551616",
                             "-1", "soon", "", "400000us", " 400000"}) {
        const Variable usec("WATCHDOG_USEC", time);
        start(now);
        EXPECT_EQ(feeds(now), kNotFed) << time;
    }
}

TEST_F(ServiceNotifyOf, WithoutAWatchdogNothingIsFed) {
    const Instant now = freeze();
    start(now);
    EXPECT_EQ(feeds(now), kNotFed);
}

TEST_F(ServiceNotifyOf, ADataThreadThatStandsIsToldOnceAndNotFed) {
    const Variable usec("WATCHDOG_USEC", "400000");
    Instant now = freeze();
    start(now);
    EXPECT_EQ(feeds(now), kFed);
    for (int i = 0; i < 5; ++i) {
        now += 200ms;
        feeds(now);
    }
    EXPECT_EQ(logged_.text(), "") << "not yet";
    for (int i = 0; i < 10; ++i) {
        now += 200ms;
        EXPECT_EQ(feeds(now), kNotFed);
    }
    EXPECT_EQ(logged_.text(),
              "the data thread stands still; if it does not go on soon, the service manager "
              "restarts the program\n");
}

TEST_F(ServiceNotifyOf, ADataThreadThatStandsIsForgottenAfterAReload) {
    const Variable usec("WATCHDOG_USEC", "400000");
    Instant now = freeze();
    start(now);
    for (int i = 0; i <= 6; ++i) {
        feeds(now += 200ms);
    }
    EXPECT_NE(logged_.take_lines_of("the data thread stands"), "");
    service_->started(now);
    for (int i = 0; i <= 5; ++i) {
        feeds(now += 200ms);
    }
    EXPECT_EQ(logged_.take_lines_of(""), "") << "it may have begun just now";
    feeds(now += 200ms);
    EXPECT_EQ(logged_.take_lines_of("the data thread stands"),
              "the data thread stands still; if it does not go on soon, the service manager "
              "restarts the program\n");
}

TEST_F(ServiceNotifyOf, AnOutputThatIsLateIsNamedOnceAndNotFed) {
    const Variable usec("WATCHDOG_USEC", "400000");
    start(monotonic_now());
    slow_servos_.slow = true;
    Lines told;
    // The servos read what comes; a wire that is full takes nothing, which is another fault.
    const auto look = [&] {
        receiver_.send(from_hex(kIa6bFrame));
        lamp_.receive();
        servos_.receive();
        told = feeds(monotonic_now());
        return logged_.text().find("output ") != std::string::npos;
    };
    EXPECT_TRUE(seen_within(look));
    EXPECT_EQ(told, kNotFed);
    EXPECT_EQ(logged_.text(),
              "output servos: half of its frames are late or missed; the machine is too slow or "
              "too busy. If this goes on, the service manager restarts the program\n");
    slow_servos_.slow = false;
    EXPECT_TRUE(seen_within([&] {
        look();
        return told == kFed;
    }));
}

}  // namespace
}  // namespace tribus::test::service_notify_test
