#include "app/daemon/daemon_sockets.h"

#include <unistd.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/status/fingerprint.h"
#include "config/load.h"
#include "config/show/effective.h"
#include "pipelines/realtime/clock.h"
#include "tests/loopback/machine/guest.h"
#include "tests/loopback/machine/service_manager.h"
#include "tests/support/far_end.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// The two sockets of a daemon, and what clients see there.
namespace tribus::test::daemon_sockets_test {
namespace {

using namespace std::chrono_literals;

const std::string kNothing = R"({"type":"error","error":"nothing runs any more"})";

class SocketsOfADaemon : public testing::Test {
  protected:
    void open() {
        auto opened = DaemonSockets::open("/etc/tribus/car.toml", folder_ / "control");
        ASSERT_TRUE(opened) << opened.error();
        sockets_ = std::move(*opened);
    }
    std::unique_ptr<Appliance> appliance(const std::string& output, const std::string& more = "") {
        auto started = Appliance::start(
            load_configuration("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"" +
                                   receiver_.path() + "\"\n[output." + output +
                                   "]\nprotocol = \"sbus\"\ndevice = \"" + servos_.path() +
                                   "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"" + output +
                                   "\"\n[runtime]\nrealtime = \"off\"\n" + more,
                               "car.toml")
                .value());
        EXPECT_TRUE(started) << started.error().front();
        return std::move(*started);
    }
    std::string answer(const std::string& socket, const std::string& request) {
        Guest guest(folder_ / socket);
        guest.say(request + "\n");
        sockets_->serve(monotonic_now());
        std::string text = guest.read();
        EXPECT_TRUE(text.ends_with('\n')) << text;
        return text.substr(0, text.find('\n'));
    }
    nlohmann::json status() { return nlohmann::json::parse(answer("control", "status")); }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd servos_{folder_ / "servos"};
    LogInMemory logged_{"%v"};
    std::unique_ptr<Appliance> appliance_;
    ChangeJournal changes_;
    std::unique_ptr<DaemonSockets> sockets_;
};

TEST_F(SocketsOfADaemon, AreTwoWithADraftBesideThem) {
    open();
    ASSERT_NE(sockets_->control(), nullptr);
    ASSERT_NE(sockets_->look_only(), nullptr);
    EXPECT_EQ(sockets_->control()->path(), folder_ / "control");
    EXPECT_EQ(sockets_->look_only()->path(), folder_ / "look");
    EXPECT_EQ(sockets_->draft(), folder_ / "draft/draft.toml");
    EXPECT_EQ(sockets_->descriptors(), (std::vector{sockets_->control()->descriptor(),
                                                    sockets_->look_only()->descriptor()}));
    EXPECT_EQ(sockets_->due(), kNever);
    EXPECT_EQ(logged_.text(), "");
}

TEST_F(SocketsOfADaemon, AreRefusedAtAGivenPlaceThatIsTaken) {
    std::ofstream(folder_ / "control") << "mine";
    const auto opened = DaemonSockets::open("car.toml", folder_ / "control");
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error(),
              (folder_ / "control") + " exists and is not a socket; choose another --socket");
}

TEST_F(SocketsOfADaemon, AreInTheRuntimeDirectoryWithoutAGivenPlace) {
    const Variable directory("RUNTIME_DIRECTORY", folder_.path().string());
    const auto opened = DaemonSockets::open("car.toml", std::nullopt);
    ASSERT_TRUE(opened);
    ASSERT_NE((*opened)->control(), nullptr);
    EXPECT_EQ((*opened)->control()->path(), folder_ / "control");
}

TEST_F(SocketsOfADaemon, AreNoneWhereTheDefaultPlaceIsTaken) {
    std::ofstream(folder_ / "control") << "mine";
    const Variable directory("RUNTIME_DIRECTORY", folder_.path().string());
    const auto opened = DaemonSockets::open("car.toml", std::nullopt);
    ASSERT_TRUE(opened);
    EXPECT_EQ((*opened)->control(), nullptr);
    EXPECT_EQ(logged_.text(), "no control socket: " + (folder_ / "control") +
                                  " exists and is not a socket; choose another --socket\n");
}

/// A daemon translates whatever becomes of its sockets.
TEST_F(SocketsOfADaemon, AreNoneWhereThereIsNoPlace) {
    const Variable no_directory("RUNTIME_DIRECTORY", std::nullopt);
    const Variable no_user_directory("XDG_RUNTIME_DIR", std::nullopt);
    appliance_ = appliance("servos");
    const bool root = ::geteuid() == 0;
    constexpr uid_t kNobody = 65534;
    ASSERT_EQ(root ? ::seteuid(kNobody) : 0, 0);
    auto opened = DaemonSockets::open("car.toml", std::nullopt);
    ASSERT_EQ(root ? ::seteuid(0) : 0, 0);
    ASSERT_TRUE(opened);
    sockets_ = std::move(*opened);
    EXPECT_EQ(logged_.text(),
              "no control socket: neither RUNTIME_DIRECTORY nor XDG_RUNTIME_DIR is set; set its "
              "path with --socket\n");
    EXPECT_EQ(sockets_->control(), nullptr);
    EXPECT_EQ(sockets_->look_only(), nullptr);
    EXPECT_EQ(sockets_->draft(), "");
    EXPECT_EQ(sockets_->descriptors(), std::vector<int>{});
    EXPECT_EQ(sockets_->due(), kNever);
    EXPECT_FALSE(sockets_->watched());
    sockets_->show(*appliance_, changes_);
    sockets_->look();
    sockets_->serve(monotonic_now());
}

TEST_F(SocketsOfADaemon, AreOneWhereThePlaceOfTheOtherIsTaken) {
    std::ofstream(folder_ / "look") << "mine";
    open();
    EXPECT_EQ(sockets_->look_only(), nullptr);
    EXPECT_EQ(logged_.text(), "no socket that only tells: " + (folder_ / "look") +
                                  " exists and is not a socket; choose another --socket\n");
    EXPECT_EQ(sockets_->descriptors(), std::vector{sockets_->control()->descriptor()});
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    EXPECT_EQ(status()["type"], "status");
    EXPECT_EQ(sockets_->due(), sockets_->control()->due());
}

TEST_F(SocketsOfADaemon, AreDueAndWatchedIfOneOfThemIs) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    for (const char* socket : {"control", "look"}) {
        EXPECT_FALSE(sockets_->watched());
        Guest guest(folder_ / socket);
        const Instant now = monotonic_now();
        sockets_->serve(now);
        EXPECT_TRUE(sockets_->watched()) << socket;
        EXPECT_EQ(sockets_->due(), now + 60s) << socket;
        guest.leave();
        sockets_->serve(now);
        EXPECT_EQ(sockets_->due(), kNever);
    }
}

TEST_F(SocketsOfADaemon, TellTheSame) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    for (const char* socket : {"control", "look"}) {
        for (const char* request : {"status", "metrics", "recordings", "histograms"}) {
            EXPECT_EQ(nlohmann::json::parse(answer(socket, request))["type"], request) << socket;
        }
        EXPECT_EQ(answer(socket, "recordings"), R"({"type":"recordings","directory":null})");
        EXPECT_EQ(answer(socket, "record 1"),
                  R"({"type":"error","error":"the configuration has no [recorder]; add that )"
                  R"(table and reload"})");
    }
    EXPECT_EQ(answer("control", "record"), answer("control", "record 1"));
    EXPECT_EQ(answer("look", "record"),
              R"({"type":"error","error":"\"record\" begins a recording, and this socket only )"
              R"(tells; allowed here: \"record N\""})");
}

TEST_F(SocketsOfADaemon, TellOfTheRecorder) {
    open();
    appliance_ = appliance(
        "servos", "[recorder]\nmemory = 65536\ndirectory = \"" + (folder_ / "recordings") + "\"\n");
    sockets_->show(*appliance_, changes_);
    EXPECT_EQ(nlohmann::json::parse(answer("look", "recordings"))["directory"],
              folder_ / "recordings");
    const auto recorded = nlohmann::json::parse(answer("control", "record"));
    EXPECT_NE(recorded["type"], "error") << recorded;
}

TEST_F(SocketsOfADaemon, ShowWhatRunsNow) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    EXPECT_EQ(status()["outputs"][0]["name"], "servos");
    EXPECT_EQ(status()["fingerprint"], fingerprint(effective_toml(appliance_->configuration())));
    appliance_.reset();
    appliance_ = appliance("motors");
    sockets_->show(*appliance_, changes_);
    EXPECT_EQ(status()["outputs"][0]["name"], "motors");
    EXPECT_EQ(status()["fingerprint"], fingerprint(effective_toml(appliance_->configuration())));
}

TEST_F(SocketsOfADaemon, ShowTheTrial) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    EXPECT_TRUE(status()["trial"].is_null());
    EXPECT_TRUE(status()["trial_left_us"].is_null());
    sockets_->show_trial(ShownTrial{7, monotonic_now() + 100s});
    EXPECT_EQ(status()["trial"], 7);
    EXPECT_LE(status()["trial_left_us"], 100'000'000);
    EXPECT_GT(status()["trial_left_us"], 0);
    sockets_->show_trial(ShownTrial{7, monotonic_now() - 1s});
    EXPECT_EQ(status()["trial_left_us"], 0);
    sockets_->show_trial(std::nullopt);
    EXPECT_TRUE(status()["trial"].is_null());
}

TEST_F(SocketsOfADaemon, CountFramesASecondWhileTheyLook) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    EXPECT_TRUE(seen_within([&] {
        sockets_->look();
        return status()["outputs"][0]["rate_hz"] > 0;
    }));
}

TEST_F(SocketsOfADaemon, ServeNobodyWhereNothingRunsAnyMore) {
    open();
    appliance_ = appliance("servos");
    sockets_->show(*appliance_, changes_);
    Guest control(folder_ / "control");
    Guest look(folder_ / "look");
    sockets_->serve(monotonic_now());
    sockets_->hide();
    for (Guest* const guest : {&control, &look}) {
        guest->say("status\nmetrics\nrecord 1\nrecordings\nhistograms\n");
    }
    sockets_->serve(monotonic_now());
    EXPECT_EQ(control.read(), "");
    EXPECT_EQ(look.read(), "");
    std::string five;
    for (int i = 0; i < 5; ++i) {
        five += kNothing + "\n";
    }
    sockets_->control()->serve(monotonic_now());
    sockets_->look_only()->serve(monotonic_now());
    EXPECT_EQ(control.read(), five);
    EXPECT_EQ(look.read(), five);
}

TEST_F(SocketsOfADaemon, TellNothingBeforeAnythingRuns) {
    open();
    Guest guest(folder_ / "control");
    guest.say("status\n");
    sockets_->serve(monotonic_now());
    EXPECT_EQ(guest.read(), "");
    EXPECT_FALSE(sockets_->watched());
}

}  // namespace
}  // namespace tribus::test::daemon_sockets_test
