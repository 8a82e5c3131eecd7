#include <sys/socket.h>

#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
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

/// What is told of frames in which a decoder finds the fault itself, and of a bus and a value that
/// change for a moment.
namespace tribus::test::state_log_fault_test {
namespace {

using namespace std::chrono_literals;

/// Two frames that tell the interface of the test how its bus is.
const CanFrame kBusOff = standard_frame(0x7FE, {0});
const CanFrame kBusWorks = standard_frame(0x7FE, {1});

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
        if (received.frame == kBusOff || received.frame == kBusWorks) {
            state_ = received.frame == kBusOff ? CanBusState::bus_off : CanBusState::ready;
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
    CanBusState state() const override { return state_; }
    CanLinkStatus status() const override { return {state_, {}}; }

  private:
    int socket_;
    CanBusState state_ = CanBusState::ready;
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
        const std::string text = fmt::format(
            R"([input.bus]
protocol = "dbc"
interface = "can0"
timeout = "{}"
dbc = "bus.dbc"
signals.M.Steer = 1
[output.servos]
protocol = "sbus"
device = "{}"
[pipeline.main]
from = "bus"
to = "servos"
[values.steering]
interface = "can0"
dbc = "bus.dbc"
message = "M"
timeout = "100ms"
[sensor_bus.telemetry]
device = "{}"
role = "sensor"
sensor = [{{ type = "temperature", value = "steering.Steer", scale = 1 }}]
[runtime]
realtime = "off"
)",
            timeout, servos_.path(), sensors_.path());
        configuration_ = load_configuration(text, folder_ / "test.toml").value();
        configuration_.inputs[0].port.medium = &kSocketBuses;
        configuration_.inputs[0].port.device = std::to_string(interface_.get());
        std::get<ValueMessageConfig>(configuration_.values[0].source).port =
            configuration_.inputs[0].port;
        appliance_ = Appliance::start(configuration_).value();
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
    /// Sends the frame and returns once the data thread has written a change; the log looks later.
    void send_unlooked(const CanFrame& frame) {
        const std::uint64_t before = appliance_->changes().newest();
        ::send(node_.get(), &frame, sizeof frame, 0);
        ASSERT_TRUE(seen_within([&] { return appliance_->changes().newest() > before; }));
    }
    /// Another appliance of the same configuration goes on, without the numbers of values.
    void go_on_anew() {
        appliance_.reset();
        appliance_ = Appliance::start(configuration_).value();
        teller_->go_on_with(*appliance_, plan_carry_over(configuration_, configuration_),
                            monotonic_now());
    }
    void look() { teller_->look(*appliance_, monotonic_now()); }
    ValueStatus steering() const {
        for (std::size_t place = 0; place < appliance_->value_count(); ++place) {
            if (appliance_->value(place).name == "steering.Steer") {
                return appliance_->value_status(place);
            }
        }
        ADD_FAILURE() << "no such value";
        return {};
    }
    /// Changes of the parts of that kind since the start.
    std::vector<ToldChange> told(std::string_view part) const {
        std::vector<ToldChange> found = teller_->changes().since(0);
        std::erase_if(found, [&](const ToldChange& change) { return change.part != part; });
        return found;
    }
    /// Returns the messages since the last call that begin with `of`.
    std::string said(std::string_view of) { return logged_.take_lines_of(of); }

    UniqueFd node_;

  private:
    TemporaryFolder folder_;
    FarEnd servos_{folder_ / "servos"};
    FarEnd sensors_{folder_ / "sensors"};
    UniqueFd interface_;
    LogInMemory logged_{"%v"};
    Configuration configuration_;
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

TEST_F(StateLogOfMessages, TellsABusOffThatIsOverBeforeTheLogLooks) {
    const Instant begin = monotonic_now();
    send_unlooked(kBusOff);
    const Instant between = monotonic_now();
    send_unlooked(kBusWorks);
    look();
    const std::vector<ToldChange> changes = told("bus");
    ASSERT_EQ(changes.size(), 2U);
    EXPECT_EQ(changes[0].now, "bus_off");
    EXPECT_TRUE(begin <= changes[0].at && changes[0].at <= between);
    EXPECT_EQ(changes[1].now, "ready");
    EXPECT_TRUE(between <= changes[1].at && changes[1].at <= monotonic_now());
}

/// The value lasts 100 ms. A busy machine only makes it stale for longer.
TEST_F(StateLogOfMessages, TellsAStaleValueThatIsFreshAgainBeforeTheLogLooks) {
    const CanFrame frame = standard_frame(256, {0xDC, 0x05});
    receive(frame, LinkCause::good, monotonic_now());
    const std::size_t known = told("value").size();
    ASSERT_TRUE(seen_within([&] {
        std::this_thread::sleep_for(150ms);
        ::send(node_.get(), &frame, sizeof frame, 0);
        return steering().gaps.count > 0;
    }));
    look();
    const std::vector<ToldChange> changes = told("value");
    ASSERT_GE(changes.size(), known + 2);
    EXPECT_EQ(changes[known].now, "stale");
    EXPECT_EQ(changes[known].at, steering().gaps.stale_at);
    EXPECT_EQ(changes[known + 1].now, "fresh");
    EXPECT_EQ(changes[known + 1].at, steering().gaps.fresh_since);
}

/// A reload that changes the source of a value makes another value of the same name.
TEST_F(StateLogOfMessages, TellsThatAValueIsStaleIfItsNewSourceHasSaidNothingYet) {
    receive(standard_frame(256, {0xDC, 0x05}), LinkCause::good, monotonic_now());
    ASSERT_TRUE(seen_within([&] {
        const CanFrame frame = standard_frame(256, {0xDC, 0x05});
        ::send(node_.get(), &frame, sizeof frame, 0);
        look();
        return !told("value").empty() ? told("value").back().now == "fresh" : steering().ever;
    }));
    const std::size_t known = told("value").size();
    go_on_anew();
    look();
    const std::vector<ToldChange> changes = told("value");
    ASSERT_EQ(changes.size(), known + 1);
    EXPECT_EQ(changes.back().now, "stale");
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
