#include <sys/socket.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "app/log/state_log.h"
#include "config/load.h"
#include "tests/loopback/machine/teller.h"
#include "tests/support/dbc_maps.h"
#include "tests/support/far_end.h"
#include "tests/support/log_in_memory.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/can/can_link.h"
#include "transports/links/medium.h"
#include "transports/links/unique_fd.h"

/// What the log says of frames in which a decoder finds the fault itself.
namespace tribus::test::state_log_fault_test {
namespace {

using namespace std::chrono_literals;

/// A CAN interface that receives what the test sends through a pair of sockets.
class SocketBus final : public CanLink {
  public:
    explicit SocketBus(int socket) : socket_(socket) {}
    int descriptor() const override { return socket_; }
    ReadStatus read(CanReception& reception, Instant now, Duration /*wall_time*/) override {
        reception.count = 0;
        reception.full = false;
        ReceivedCanFrame& received = reception.frames[0];
        if (::recv(socket_, &received.frame, sizeof received.frame, 0) != sizeof received.frame) {
            return ReadStatus::nothing;
        }
        received.at = now;
        reception.count = 1;
        return ReadStatus::received;
    }
    WriteStatus write(std::size_t /*lane*/, std::span<const CanFrame> /*snapshot*/,
                      Instant /*now*/) override {
        return WriteStatus::unavailable;
    }
    Instant poll(Instant /*now*/) override { return kNever; }
    CanLinkStatus status() const override { return {}; }

  private:
    int socket_;
};

/// Its places are numbers of sockets.
const Medium kSocketBuses{
    .name = "CAN",
    .shape = WireShape::can_frames,
    .place = {.key = "interface"},
    .place_absent = "",
    .users = Users::many,
    .is_missing = [](const std::string& /*place*/) { return false; },
    .open = [](const std::string& place,
               const LinkUse& /*use*/) -> tl::expected<std::unique_ptr<Link>, std::string> {
        return std::make_unique<SocketBus>(std::stoi(place));
    }};

class StateLogOfMessages : public testing::Test {
  protected:
    explicit StateLogOfMessages(const std::string& timeout = "10s") {
        std::array<int, 2> ends{};
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, ends.data()), 0);
        node_ = UniqueFd(ends[0]);
        interface_ = UniqueFd(ends[1]);
        folder_.write("bus.dbc",
                      "BO_ 256 M: 2 A\n SG_ Steer : 0|16@1+ (1,0) [800|2200] \"us\" B\n");
        Configuration configuration =
            load_configuration(
                "[input.bus]\nprotocol = \"dbc\"\ninterface = \"can0\"\ntimeout = \"" + timeout +
                    "\"\n"
                    "dbc = \"bus.dbc\"\nsignals.M.Steer = 1\n"
                    "[output.servos]\nprotocol = \"sbus\"\ndevice = \"" +
                    servos_.path() +
                    "\"\n[pipeline.main]\nfrom = \"bus\"\nto = \"servos\"\n"
                    "[runtime]\nrealtime = \"off\"\n",
                folder_ / "test.toml")
                .value();
        configuration.inputs[0].port.medium = &kSocketBuses;
        configuration.inputs[0].port.device = std::to_string(interface_.get());
        appliance_ = Appliance::start(std::move(configuration)).value();
        teller_ = std::make_unique<Teller>(*appliance_, Instant(0s));
    }
    /// Sends the frame until the program reports this cause; then the log looks.
    void receive(const CanFrame& frame, LinkCause cause, Instant now) {
        ASSERT_TRUE(seen_within([&] {
            ::send(node_.get(), &frame, sizeof frame, 0);
            return appliance_->input_status(0).state.cause == cause;
        }));
        teller_->look(*appliance_, now);
    }
    /// Returns the messages since the last call that begin with `of`.
    std::string said(std::string_view of) { return logged_.take_lines_of(of); }

  private:
    TemporaryFolder folder_;
    FarEnd servos_{folder_ / "servos"};
    UniqueFd node_;
    UniqueFd interface_;
    LogInMemory logged_{"%v"};
    std::unique_ptr<Appliance> appliance_;
    std::unique_ptr<Teller> teller_;
};

TEST_F(StateLogOfMessages, NamesTheSignalWithoutAValueInsteadOfTheReceiver) {
    // 1500 is 0x05DC, 3000 is 0x0BB8.
    receive(standard_frame(256, {0xDC, 0x05}), LinkCause::good, Instant(1s));
    EXPECT_EQ(said("input bus: "), "input bus: good\n");
    receive(standard_frame(256, {0xB8, 0x0B}), LinkCause::radio_lost, Instant(2s));
    EXPECT_EQ(said("input bus: "),
              "input bus: radio lost (message M, signal Steer: 3000 is outside of [800|2200])\n");
}

class StateLogOfFramesThatNeverCount : public StateLogOfMessages {
  protected:
    StateLogOfFramesThatNeverCount() : StateLogOfMessages("1s") {}
};

/// Not that sender and receiver must agree on format, id and bit rate: that they do.
TEST_F(StateLogOfFramesThatNeverCount, NamesWhatTheDecoderKnowsInsteadOfTheUsualReasons) {
    receive(standard_frame(256, {0xDC}), LinkCause::garbled, Instant(3s));
    const std::string text = said("input bus: ");
    EXPECT_NE(text.find("but no frame that counts: garbled (message M: a frame has 1 bytes"),
              std::string::npos)
        << text;
    EXPECT_EQ(text.find("must agree"), std::string::npos) << text;
}

}  // namespace
}  // namespace tribus::test::state_log_fault_test
