#include "app/state_log.h"

#include <unistd.h>

#include <chrono>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "app/pty.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/support/sbus_frames.h"

/// What the log says from one configuration to the next: of an appliance at work at ptys, with a
/// log that looks when the test says so, at instants that the test says.
namespace tribus::test {
namespace {

using namespace std::chrono_literals;

const Bytes kGood = from_hex(kAll992);

/// With the bits for frame lost and failsafe (ibus-sbus.md 2.2).
Bytes radio_lost() {
    Bytes frame = kGood;
    frame[23] = 0x0C;
    return frame;
}

class StateLogOverAReload : public testing::Test {
  protected:
    StateLogOverAReload() : before_(spdlog::default_logger()) {
        auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(said_);
        sink->set_pattern("%v");
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
        auto started = Appliance::start(configuration());
        if (!started) {
            throw std::runtime_error(started.error().front());
        }
        appliance_ = std::move(*started);
        log_ = std::make_unique<StateLog>(*appliance_, Instant(0s));
    }
    ~StateLogOverAReload() override { spdlog::set_default_logger(before_); }

    Configuration configuration() const {
        const std::string text =
            "[input.receiver]\nprotocol = \"sbus\"\ntimeout = \"10s\"\ndevice = \"" +
            receiver_.path + "\"\n[output.servos]\nprotocol = \"ibus\"\ndevice = \"" +
            servos_.path +
            "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
            "[runtime]\nrealtime = \"off\"\n";
        return load_configuration(text, "test.toml").value();
    }
    /// The receiver says that until the program has seen it; then the log looks.
    void receive(const Bytes& frame, LinkCause cause, Instant now) {
        const Instant patience = monotonic_now() + 10s;
        while (appliance_->input_status(0).state.cause != cause) {
            ASSERT_LT(monotonic_now(), patience) << name_of(cause) << " was not seen";
            ASSERT_EQ(::write(receiver_.master.get(), frame.data(), frame.size()),
                      static_cast<ssize_t>(frame.size()));
            std::this_thread::sleep_for(7ms);
        }
        log_->look(*appliance_, now);
    }
    void reload() {
        const CarryOver carry_over = plan_carry_over(appliance_->configuration(), configuration());
        appliance_ = Appliance::succeed(appliance_, configuration(), carry_over).value();
        auto log = std::make_unique<StateLog>(*appliance_, Instant(0s));
        log->go_on_from(*log_, *appliance_, carry_over);
        log_ = std::move(log);
    }
    /// Of the receiver, since the last call.
    std::string said() {
        std::istringstream all(std::move(said_).str());
        said_.str("");
        std::string lines;
        for (std::string line; std::getline(all, line);) {
            lines += line.starts_with("input receiver: ") ? line + "\n" : "";
        }
        return lines;
    }
    std::string said_at(Instant now) {
        log_->look(*appliance_, now);
        return said();
    }

  private:
    Pty receiver_ = Pty::open().value();
    Pty servos_ = Pty::open().value();
    std::ostringstream said_;
    std::shared_ptr<spdlog::logger> before_;
    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<StateLog> log_;
};

TEST_F(StateLogOverAReload, SaysNothingAgain) {
    receive(kGood, LinkCause::good, Instant(1s));
    receive(radio_lost(), LinkCause::radio_lost, Instant(2s));
    EXPECT_NE(said(), "");
    reload();
    EXPECT_EQ(said_at(Instant(3s)), "");
}

TEST_F(StateLogOverAReload, SaysWhatHadNoLineLeftBefore) {
    // Six lines in 30 s.
    for (auto second = 1s; second < 7s; second += 2s) {
        receive(kGood, LinkCause::good, Instant(second));
        receive(radio_lost(), LinkCause::radio_lost, Instant(second + 1s));
    }
    EXPECT_NE(said(), "");
    receive(kGood, LinkCause::good, Instant(8s));
    EXPECT_EQ(said(), "");
    reload();
    EXPECT_EQ(said_at(Instant(29s)), "") << "a reload gives no new lines";
    EXPECT_EQ(said_at(Instant(60s)), "input receiver: good\n");
}

}  // namespace
}  // namespace tribus::test
