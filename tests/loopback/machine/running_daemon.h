#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/daemon/control_requests.h"
#include "app/daemon/daemon.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/loopback/machine/guest.h"
#include "tests/loopback/machine/service_manager.h"
#include "tests/support/far_end.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test {

/// A daemon in this process, i.Bus at a pty to SBUS at another one. The test is its main loop.
class RunningDaemon : public testing::Test {
  protected:
    RunningDaemon() {
        write(job("servos"));
        auto opened = DaemonSockets::open(file_, folder_ / "control");
        EXPECT_TRUE(opened) << opened.error();
        sockets_ = std::move(*opened);
        daemon_.emplace(file_, *sockets_, *service_);
        add_control_requests(*sockets_->control(), *daemon_);
        add_telling_requests(*sockets_->look_only(), *daemon_);
    }

    /// `more`: further tables.
    std::string job(const std::string& output, const std::string& more = "",
                    const std::string& input = "receiver") const {
        return "[input." + input + "]\nprotocol = \"ibus\"\ntimeout = \"10s\"\ndevice = \"" +
               receiver_.path() + "\"\n[output." + output + "]\nprotocol = \"sbus\"\ndevice = \"" +
               servos_.path() + "\"\n[pipeline.main]\nfrom = \"" + input + "\"\nto = \"" + output +
               "\"\n" +
               (more.find("[runtime]") == std::string::npos ? "[runtime]\nrealtime = \"off\"\n"
                                                            : "") +
               more;
    }
    void write(const std::string& text) { folder_.write("tribus.toml", text); }
    void write_draft(const std::string& text) {
        std::filesystem::create_directories(folder_.path() / "draft");
        folder_.write("draft/draft.toml", text);
    }
    void start() { daemon_->start(load_configuration_file(file_).value()); }
    void start(const std::string& text) {
        write(text);
        start();
    }

    /// Lets the change end.
    ReloadOutcome outcome_of(std::optional<std::uint64_t> change) {
        EXPECT_TRUE(change);
        EXPECT_TRUE(seen_within([&] {
            daemon_->go_on(monotonic_now());
            return daemon_->outcome_of(change.value_or(0)).has_value();
        }));
        return daemon_->outcome_of(change.value_or(0)).value_or(ReloadOutcome{});
    }
    ReloadOutcome reload(const std::string& text, std::optional<Duration> trial = std::nullopt) {
        write(text);
        return outcome_of(daemon_->begin_reload(trial));
    }
    ReloadOutcome reload_draft(const std::string& text, Duration trial) {
        write_draft(text);
        return outcome_of(daemon_->begin_reload_of_draft(trial));
    }
    /// Waits until what is under way is done, and takes it at `now`.
    void go_on_when_done(Instant now) {
        EXPECT_TRUE(seen_within([&] {
            daemon_->go_on(now);
            return daemon_->descriptor() == -1;
        }));
    }

    /// One answer of the control socket, also where nothing runs.
    std::string answer(const std::string& request) { return answer_at("control", request); }
    std::string answer_at(const std::string& socket, const std::string& request) {
        Guest guest(folder_ / socket);
        guest.say(request + "\n");
        return answer_to(guest);
    }
    std::string answer_to(Guest& guest) {
        std::string text;
        EXPECT_TRUE(seen_within([&] {
            daemon_->go_on(monotonic_now());
            serve();
            text += guest.read();
            return text.ends_with('\n');
        }));
        return text.substr(0, text.find('\n'));
    }
    void serve() {
        for (ControlServer* const server : {sockets_->control(), sockets_->look_only()}) {
            server->serve(monotonic_now());
        }
    }

    /// Sends frames until the log says that.
    bool says_under_frames(std::string_view text) {
        return seen_within([&] {
            receiver_.send(from_hex(kIa6bFrame));
            servos_.receive();
            daemon_->look(monotonic_now());
            return logged_.text().find(text) != std::string::npos;
        });
    }
    /// The lines of the log since the last call that begin with that.
    std::string said(std::string_view of) { return logged_.take_lines_of(of); }
    bool has_said(std::string_view text) const {
        return logged_.text().find(text) != std::string::npos;
    }
    std::string output_name() const { return daemon_->configuration().outputs.front().name; }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd servos_{folder_ / "servos"};
    const std::string file_ = folder_ / "tribus.toml";
    LogInMemory logged_{"%v"};
    ServiceManager manager_{folder_ / "notify"};
    const Variable notify_{"NOTIFY_SOCKET", folder_ / "notify"};
    const Variable no_watchdog_{"WATCHDOG_USEC", std::nullopt};
    std::unique_ptr<ServiceNotify> service_ = std::make_unique<ServiceNotify>();
    std::unique_ptr<DaemonSockets> sockets_;
    std::optional<Daemon> daemon_;
};

}  // namespace tribus::test
