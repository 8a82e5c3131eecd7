#include "app/log/state_log.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "config/load.h"
#include "tests/loopback/machine/teller.h"
#include "tests/support/far_end.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/sbus_frames.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// Messages of the log, also across a reload, for an appliance that runs at ptys. The test decides
/// when the log looks and gives it the time.
namespace tribus::test::state_log_test {
namespace {

using namespace std::chrono_literals;

const Bytes kGood = from_hex(kAll992);
/// Request of docs/protocols/ibus.md, "Sensor bus: frames": is there a sensor at address 1?
const Bytes kDiscover1{0x04, 0x81, 0x7A, 0xFF};

/// A frame with the bits for frame lost and failsafe (docs/protocols/sbus.md, "Frame").
Bytes radio_lost() {
    Bytes frame = kGood;
    frame[23] = 0x0C;
    return frame;
}

class StateLogAtPtys : public testing::Test {
  protected:
    StateLogAtPtys() {
        auto started = Appliance::start(configuration("receiver", "ibus"));
        if (!started) {
            throw std::runtime_error(started.error().front());
        }
        appliance_ = std::move(*started);
        teller_ = std::make_unique<Teller>(*appliance_, Instant(0s));
    }

    /// Sends the frame until the program reports this cause; then the log looks.
    void receive(const Bytes& frame, LinkCause cause, Instant now) {
        ASSERT_TRUE(seen_within([&] {
            send(frame);
            return appliance_->input_status(0).state.cause == cause;
        }));
        teller_->look(*appliance_, now);
    }
    void receive_until_control(Instant now) {
        ASSERT_TRUE(seen_within([&] {
            send(kGood);
            return appliance_->output_status(0).state.stage == OutputStage::control;
        }));
        teller_->look(*appliance_, now);
    }
    /// Sends the frame among good ones until the program reports that it is not plausible; then the
    /// log looks.
    void receive_implausible(const Bytes& frame, Instant now) {
        ASSERT_TRUE(seen_within([&] {
            send(kGood);
            send(frame);
            const InputStatus status = appliance_->input_status(0);
            return status.implausible.frames > 0 && status.ever_good;
        }));
        teller_->look(*appliance_, now);
    }
    void see_the_output_wait() {
        ASSERT_TRUE(seen_within(
            [&] { return appliance_->output_status(0).wait.awaited == Awaited::link; }));
    }
    /// Lets the servos read so slowly that frames are dropped, with control in between. The log
    /// looks when both have happened.
    void drop_frames_under_control(Instant now) {
        const std::uint64_t before = appliance_->output_status(0).counts.busy_drops;
        ASSERT_TRUE(seen_within([&] {
            receiver_.send(kGood);
            const OutputStatus status = appliance_->output_status(0);
            if (status.state.stage == OutputStage::cannot_send) {
                std::array<char, 1024> some{};
                EXPECT_GT(::read(servos_.descriptor(), some.data(), some.size()), 0);
            }
            return status.state.stage == OutputStage::control && status.counts.busy_drops > before;
        }));
        teller_->look(*appliance_, now);
    }
    void receive_until_failsafe(Instant now) {
        ASSERT_TRUE(seen_within([&] {
            send(radio_lost());
            return appliance_->output_status(0).state.stage == OutputStage::failsafe;
        }));
        teller_->look(*appliance_, now);
    }
    void ask_sensors(Instant now) {
        ASSERT_TRUE(seen_within([&] {
            sensors_.send(kDiscover1);
            return appliance_->bus_state(0).sensor.requests > 0;
        }));
        teller_->look(*appliance_, now);
    }
    void reload(Instant now, const std::string& input = "receiver",
                const std::string& output_protocol = "ibus") {
        Configuration fresh = configuration(input, output_protocol);
        const CarryOver carry_over = plan_carry_over(appliance_->configuration(), fresh);
        std::unique_ptr<FlightRecorder> none;
        appliance_ =
            Appliance::succeed(appliance_, Appliance::build(std::move(fresh)), carry_over, none)
                .value();
        teller_->go_on_with(*appliance_, carry_over, now);
    }
    /// Returns the messages since the last call that begin with `of`. A worker of the kernel hands
    /// on what a pty has; while it is late, frames are dropped, which is another message.
    std::string said(std::string_view of) {
        return logged_.take_lines([of](const std::string& line) {
            return line.starts_with(of) && line.find(kDropped) == std::string::npos;
        });
    }
    std::string said_of_drops() {
        return logged_.take_lines(
            [](const std::string& line) { return line.find(kDropped) != std::string::npos; });
    }
    std::string said_at(Instant now, std::string_view of) {
        teller_->look(*appliance_, now);
        return said(of);
    }
    /// Lets the log look at 1 s repeatedly until it has messages, and returns them.
    std::string said_soon(std::string_view of) {
        std::string lines;
        EXPECT_TRUE(seen_within([&] {
            lines = said_at(Instant(1s), of);
            return !lines.empty();
        }));
        return lines;
    }
    std::string device(const FarEnd& far_end) { return "device " + far_end.path() + ": "; }

    TemporaryFolder folder_;
    FarEnd receiver_{folder_ / "receiver"};
    FarEnd servos_{folder_ / "servos"};
    FarEnd sensors_{folder_ / "sensors"};

  private:
    /// The servos read what has come until then.
    void send(const Bytes& frame) {
        receiver_.send(frame);
        servos_.receive();
    }

    static constexpr std::string_view kDropped =
        " dropped because the port still had the frame before";

    Configuration configuration(const std::string& input,
                                const std::string& output_protocol) const {
        const std::string text =
            "[input." + input + "]\nprotocol = \"sbus\"\ntimeout = \"10s\"\ndevice = \"" +
            receiver_.path() + "\"\n[output.servos]\nprotocol = \"" + output_protocol +
            "\"\ndevice = \"" + servos_.path() + "\"\n[pipeline.main]\nfrom = \"" + input +
            "\"\nto = \"servos\"\n"
            "[sensor_bus.telemetry]\nrole = \"sensor\"\nwires = \"two\"\n"
            "device = \"" +
            sensors_.path() +
            "\"\n[[sensor_bus.telemetry.sensor]]\n"
            "type = \"external_voltage\"\nvalue = \"cells\"\n"
            "[values.cells]\nconstant = 1\nunit = \"V\"\n"
            "[runtime]\nrealtime = \"off\"\n";
        return load_configuration(text, "test.toml").value();
    }

    LogInMemory logged_{"%v"};
    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<Teller> teller_;
};

class StateLogOverAReload : public StateLogAtPtys {};
class StateLogOfASensorBus : public StateLogAtPtys {};

constexpr std::string_view kReceiver = "input receiver: ";
constexpr std::string_view kServos = "output servos: ";
constexpr std::string_view kTelemetry = "sensor bus telemetry: ";

TEST_F(StateLogAtPtys, SaysWhatAnOutputWaitsForAfterAWhile) {
    see_the_output_wait();
    EXPECT_EQ(said_at(Instant(0s), kServos), "");
    EXPECT_EQ(said_at(Instant(699ms), kServos), "");
    EXPECT_EQ(said_at(Instant(700ms), kServos), "output servos: waits for receiver: never seen\n");
    EXPECT_EQ(said_at(Instant(10s), kServos), "") << "nothing has changed";
}

TEST_F(StateLogAtPtys, SaysWithALossWhatAnOutputWaitsFor) {
    receive_until_control(Instant(1s));
    said(kServos);
    receive_until_failsafe(Instant(2s));
    EXPECT_EQ(said(kServos),
              "output servos: holding the last values, unmarked: its protocol has no frame-lost "
              "mark\n"
              "output servos: in failsafe; waits for receiver: radio lost (the receiver says "
              "failsafe)\n");
}

TEST_F(StateLogAtPtys, NamesTheValueOfAFrameThatIsNotPlausible) {
    Bytes zero = kGood;
    // Channel 1 is raw 0, which means "no value" in the first second (`zero_guard`).
    zero[1] = 0;
    zero[2] &= 0xF8;
    receive_implausible(zero, Instant(1s));
    const std::string lines = said(kReceiver);
    EXPECT_NE(lines.find("not plausible and ignored: channel 1 has the raw value 0"),
              std::string::npos)
        << lines;
}

TEST_F(StateLogOverAReload, SaysNothingAgainOfAnInput) {
    receive(kGood, LinkCause::good, Instant(1s));
    receive(radio_lost(), LinkCause::radio_lost, Instant(2s));
    EXPECT_NE(said(kReceiver), "");
    reload(Instant(3s));
    EXPECT_EQ(said_at(Instant(3s), kReceiver), "");
}

/// The part may have another name behind it.
TEST_F(StateLogOverAReload, SaysBeforeItWhatHadNoLineLeft) {
    // Six messages in 30 s.
    for (auto second = 1s; second < 7s; second += 2s) {
        receive(kGood, LinkCause::good, Instant(second));
        receive(radio_lost(), LinkCause::radio_lost, Instant(second + 1s));
    }
    EXPECT_NE(said(kReceiver), "");
    receive(kGood, LinkCause::good, Instant(8s));
    EXPECT_EQ(said(kReceiver), "");
    reload(Instant(9s));
    EXPECT_EQ(said(kReceiver), "input receiver: good\n");
    EXPECT_EQ(said_at(Instant(60s), kReceiver), "");
}

TEST_F(StateLogOverAReload, CountsTheSilenceOfAnInputFromItsStart) {
    EXPECT_EQ(said_at(Instant(1s), kReceiver), "");
    reload(Instant(2s));
    EXPECT_NE(said_at(Instant(3s), kReceiver).find("no byte yet"), std::string::npos);
    reload(Instant(4s));
    EXPECT_EQ(said_at(Instant(8s), kReceiver), "") << "it has been said";
}

TEST_F(StateLogOverAReload, SaysNothingAgainOfAnOutput) {
    receive_until_control(Instant(1s));
    EXPECT_EQ(said(kServos), "output servos: under control of receiver\n");
    reload(Instant(2s));
    EXPECT_EQ(said_at(Instant(2s), kServos), "");
}

TEST_F(StateLogOverAReload, SaysWhoIsInControlWhenTheInputsAreOthers) {
    receive_until_control(Instant(1s));
    EXPECT_EQ(said(kServos), "output servos: under control of receiver\n");
    reload(Instant(2s), "radio");
    EXPECT_EQ(said_at(Instant(2s), kServos), "output servos: under control of radio\n");
}

/// Dropped frames are reported repeatedly, the state of the output once.
TEST_F(StateLogAtPtys, SaysAStateAfterManyLinesOfDroppedFrames) {
    receive_until_control(Instant(1s));
    EXPECT_NE(said(kServos), "");
    auto second = 2s;
    for (int lines = 0; lines < 7; ++lines, second += 1s) {
        drop_frames_under_control(Instant(second));
    }
    EXPECT_TRUE(said_of_drops().starts_with(kServos));
    receive_until_failsafe(Instant(second));
    EXPECT_NE(said(kServos).find("in failsafe"), std::string::npos);
}

TEST_F(StateLogOverAReload, SaysNothingAgainOfADeviceThatIsGone) {
    receive_until_control(Instant(1s));
    servos_.pull();
    EXPECT_EQ(said_soon(device(servos_)), device(servos_) + "is gone; waiting for it\n");
    reload(Instant(2s));
    EXPECT_EQ(said_at(Instant(2s), device(servos_)), "");
    servos_.plug_in();
    EXPECT_EQ(said_at(Instant(3s), device(servos_)), device(servos_) + "is back\n");
}

TEST_F(StateLogOverAReload, SaysNothingOfADeviceThatIsOpenedWithOtherSettings) {
    reload(Instant(1s), "receiver", "sbus");
    EXPECT_EQ(said_at(Instant(1s), device(servos_)), "");
}

TEST_F(StateLogOverAReload, SaysThatADeviceWithOtherSettingsIsNotThere) {
    servos_.pull();
    reload(Instant(1s), "receiver", "sbus");
    EXPECT_EQ(said_at(Instant(1s), device(servos_)), device(servos_) + "is gone; waiting for it\n");
}

TEST_F(StateLogOverAReload, SaysNothingAgainOfASensorBus) {
    ask_sensors(Instant(1s));
    // A busy machine is late with replies, and says so besides.
    EXPECT_TRUE(
        said(kTelemetry)
            .starts_with(
                "sensor bus telemetry: a receiver sends requests; a sensor at address 1\n"));
    reload(Instant(2s));
    EXPECT_EQ(said_at(Instant(2s), kTelemetry), "");
}

TEST_F(StateLogOfASensorBus, SaysThatNobodyAsksWhereItsDeviceIsGone) {
    ask_sensors(Instant(1s));
    EXPECT_NE(said(kTelemetry), "");
    sensors_.pull();
    EXPECT_EQ(said_soon(kTelemetry), "sensor bus telemetry: the receiver sends no more requests\n");
}

TEST_F(StateLogOverAReload, CountsTheSilenceOfASensorBusFromItsStart) {
    reload(Instant(2s));
    EXPECT_NE(said_at(Instant(3s), kTelemetry), "");
    reload(Instant(4s));
    EXPECT_EQ(said_at(Instant(8s), kTelemetry), "") << "it has been said";
}

/// As at the start, where such a configuration is refused with the same words.
TEST(StateLogOfADevice, SaysOnceThatItCameUnderASecondName) {
    const LogInMemory logged("%v");
    const TemporaryFolder folder;
    const FarEnd receiver(folder / "receiver");
    const std::string servos = folder / "servos";
    auto appliance = Appliance::start(
        load_configuration("[input.receiver]\nprotocol = \"sbus\"\ndevice = \"" + receiver.path() +
                               "\"\n[output.servos]\nprotocol = \"ibus\"\ndevice = \"" + servos +
                               "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
                               "[runtime]\nrealtime = \"off\"\n",
                           "test.toml")
            .value(),
        Appliance::MissingDevices::wait_for_absent);
    ASSERT_TRUE(appliance) << appliance.error().front();
    Teller teller(**appliance, Instant(0s));
    teller.look(**appliance, Instant(1s));
    EXPECT_EQ(logged.text().find("under another name"), std::string::npos);
    std::filesystem::create_symlink(receiver.path(), servos);
    for (const auto second : {2s, 3s, 4s, 5s}) {
        teller.look(**appliance, Instant(second));
    }
    const std::string expected = "test.toml:6:10: " + servos +
                                 ": another program uses it, or this one opened it under another "
                                 "name; ";
    const std::size_t first = logged.text().find(expected);
    ASSERT_NE(first, std::string::npos) << logged.text();
    EXPECT_EQ(logged.text().find(expected, first + 1), std::string::npos) << logged.text();
}

}  // namespace
}  // namespace tribus::test::state_log_test
