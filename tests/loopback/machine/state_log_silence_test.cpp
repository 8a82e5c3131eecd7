#include <unistd.h>

#include <chrono>
#include <memory>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "app/log/state_log.h"
#include "config/load.h"
#include "tests/loopback/machine/teller.h"
#include "tests/support/far_end.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

/// What the log says of an input at which nothing comes, or nothing of use.
namespace tribus::test::state_log_silence_test {
namespace {

using namespace std::chrono_literals;

class StateLogOfASilentInput : public testing::Test {
  protected:
    /// `place`: the key and value that say where the SBUS input is.
    void start(const std::string& place) {
        const std::string text = "[input.receiver]\nprotocol = \"sbus\"\n" + place +
                                 "\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                                 servos_.path() +
                                 "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
                                 "[runtime]\nrealtime = \"off\"\n";
        auto started = Appliance::start(load_configuration(text, "test.toml").value(),
                                        Appliance::MissingDevices::wait_for_absent);
        ASSERT_TRUE(started) << started.error().front();
        appliance_ = std::move(*started);
        teller_ = std::make_unique<Teller>(*appliance_, Instant(0s));
    }
    /// Returns what the log says of the input when it looks.
    std::string said_at(Instant now) {
        teller_->look(*appliance_, now);
        return logged_.take_lines_of("input receiver: ");
    }
    bool all_present() const { return appliance_->port_present(0) && appliance_->port_present(1); }
    std::uint64_t bytes() const { return appliance_->input_status(0).counts.bytes; }

    TemporaryFolder folder_;
    FarEnd servos_{folder_ / "servos"};
    FarEnd receiver_{folder_ / "receiver"};
    std::string device_ = "device = \"" + receiver_.path() + "\"";
    std::unique_ptr<Appliance> appliance_;

  private:
    LogInMemory logged_{"%v"};
    std::unique_ptr<Teller> teller_;
};

TEST_F(StateLogOfASilentInput, NamesWireAndDoctorForASerialLine) {
    start(device_);
    EXPECT_EQ(said_at(Instant(2s)), "");
    EXPECT_EQ(said_at(Instant(3s)),
              "input receiver: no byte yet; check wire, ground and power of the receiver; `tribus "
              "doctor " +
                  receiver_.path() + "` listens there once this program is stopped\n");
    EXPECT_EQ(said_at(Instant(9s)), "") << "it has been said";
}

TEST_F(StateLogOfASilentInput, NamesRateAndInverterWhereBytesOfASerialLineAreNoFrames) {
    start(device_);
    receiver_.send(Bytes(7, 0x55));
    ASSERT_TRUE(seen_within([&] { return bytes() == 7; }));
    // On a slow machine the seven bytes are long ago, and the log says that too.
    const std::string said = said_at(Instant(3s));
    EXPECT_TRUE(said.ends_with(
        "input receiver: 7 bytes but no frame yet; check protocol and rate, and the inverter: SBUS "
        "needs one, i.Bus must not have one; `tribus doctor " +
        receiver_.path() + "` listens there once this program is stopped\n"))
        << said;
}

TEST_F(StateLogOfASilentInput, NamesTheSenderAndNoWireForUdp) {
    // Tests that run at the same time have other processes; from 32768 on the kernel gives ports.
    start("address = \"127.0.0.1:" + std::to_string(20000 + ::getpid() % 12000) + "\"");
    EXPECT_EQ(said_at(Instant(3s)),
              "input receiver: no datagram yet; check that its sender runs, that it sends to this "
              "address and port, and what `sender` and a firewall let pass\n");
}

TEST_F(StateLogOfASilentInput, SaysNothingOfWiresWhileItsDeviceIsNotThere) {
    receiver_.pull();
    start(device_);
    EXPECT_EQ(said_at(Instant(3s)), "");
    EXPECT_EQ(said_at(Instant(10s)), "");
    receiver_.plug_in();
    ASSERT_TRUE(seen_within([&] { return said_at(Instant(10s)).empty() && all_present(); }));
    EXPECT_EQ(said_at(Instant(12s)), "");
    EXPECT_NE(said_at(Instant(13s)).find("no byte yet"), std::string::npos)
        << "3 s after it was plugged in";
}

}  // namespace
}  // namespace tribus::test::state_log_silence_test
