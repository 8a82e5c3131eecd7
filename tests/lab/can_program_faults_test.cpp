#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "core/time.h"
#include "tests/lab/two_programs.h"
#include "transports/codecs/native_can/channels.h"

/// The built program with faults of its own controller, of other senders and of the configuration.
namespace tribus::test::can_program_faults_test {
namespace {

using std::chrono::milliseconds;

/// Returns the frame in a line of an SLCAN adapter such as `t3008001122...`.
std::optional<CanFrame> frame_of(const std::string& line) {
    if (!line.starts_with('t') || line.size() < 5) {
        return std::nullopt;
    }
    std::vector<std::uint8_t> data;
    for (std::size_t at = 5; at + 1 < line.size(); at += 2) {
        data.push_back(static_cast<std::uint8_t>(std::stoul(line.substr(at, 2), nullptr, 16)));
    }
    return make_frame(static_cast<std::uint32_t>(std::stoul(line.substr(1, 3), nullptr, 16)), data);
}

/// Returns the first channel of a classic frame of the native format in microseconds.
int first_channel_us(const CanFrame& frame) {
    const bool tail = frame.id == can_channels::kDefaultBaseId + can_channels::kTailIndex;
    const int raw =
        tail ? parse_can_tail(frame.bytes()).raw[0] : parse_can_quad(frame.bytes()).raw[0];
    return 476 + raw / 2;
}

/// The sending program has an SLCAN adapter.
class SlcanSender : public TwoPrograms {
  protected:
    static constexpr int kOldUs = 1234;
    static constexpr int kNewUs = 1777;

    Program& start_on_adapter() { return start_sender({.sender_interface = adapter_.name()}); }

    /// The receiver sends the same position on all sticks, so that each CAN frame shows it.
    void stream_for(int us, milliseconds time) {
        repeater_.change(ibus_bytes(Sticks(18, us)));
        const auto end = Clock::now() + time;
        while (Clock::now() < end) {
            repeater_.send_if_due();
            std::this_thread::sleep_for(milliseconds(1));
        }
    }
    bool stream_until_heard(int us, std::size_t known = 0) {
        return eventually([&] {
            stream_for(us, milliseconds(20));
            return count_heard(us, known) > 50;
        });
    }
    std::vector<CanFrame> frames_heard(std::size_t known) const {
        std::vector<CanFrame> frames;
        for (const std::string& line : adapter_.heard(known)) {
            if (const auto frame = frame_of(line)) {
                frames.push_back(*frame);
            }
        }
        return frames;
    }
    std::ptrdiff_t count_heard(int us, std::size_t known) const {
        return std::ranges::count(frames_heard(known), us, first_channel_us);
    }
    /// Returns the number of snapshots with this position that a reader would accept.
    std::size_t good_snapshots(int us, std::size_t known) const {
        CanChannelsDecoder decoder;
        Instant received{};
        std::size_t count = 0;
        for (const CanFrame& frame : frames_heard(known)) {
            received += std::chrono::milliseconds(2);
            const auto snapshot = decoder.next(frame, received);
            if (snapshot && snapshot->channel(0) == Pulse::from_microseconds(us)) {
                ++count;
            }
        }
        return count;
    }

    SlcanAdapter adapter_;

  private:
    Repeater repeater_{receiver(), ibus_bytes(Sticks(18, kOldUs))};
};

TEST_F(SlcanSender, SendsNothingInBusOffAndNothingOldAfterIt) {
    Program& sender = start_on_adapter();
    ASSERT_TRUE(stream_until_heard(kOldUs)) << sender.errors();
    adapter_.bus_off();
    EXPECT_TRUE(sender.says("interface " + adapter_.name() + ": bus-off"));
    // A frame may have been on its way.
    stream_for(kOldUs, milliseconds(100));
    const std::size_t known = adapter_.heard().size();
    stream_for(kOldUs, milliseconds(1500));
    stream_for(kNewUs, milliseconds(500));
    EXPECT_EQ(adapter_.heard().size(), known);
    set_link_down(adapter_.name());
    set_link_up(adapter_.name());
    ASSERT_TRUE(stream_until_heard(kNewUs, known)) << sender.errors();
    EXPECT_EQ(count_heard(kOldUs, known), 0);
    EXPECT_TRUE(sender.says("interface " + adapter_.name() + ": works"));
    expect_clean_end(sender);
}

/// Nobody can take back what the driver and its queue hold.
TEST_F(SlcanSender, SendsOneOldSnapshotAtMostAfterThreeSecondsWithoutAcknowledge) {
    Program& sender = start_on_adapter();
    ASSERT_TRUE(stream_until_heard(kOldUs)) << sender.errors();
    adapter_.block();
    stream_for(kOldUs, milliseconds(2000));
    stream_for(kNewUs, milliseconds(1000));
    EXPECT_TRUE(sender.says("frames are not sent"));
    const std::size_t known = adapter_.heard().size();
    adapter_.unblock();
    ASSERT_TRUE(stream_until_heard(kNewUs, known)) << sender.errors();
    EXPECT_LE(count_heard(kOldUs, known), 5);
    EXPECT_EQ(good_snapshots(kOldUs, known), 0U);
    EXPECT_GT(good_snapshots(kNewUs, known), 0U);
    expect_clean_end(sender);
}

/// The frames that the adapter gets are passed on to the reader, as on a bus.
class SlcanFault : public TwoPrograms {
  protected:
    Program& start_on_adapter() { return start_sender({.sender_interface = adapter_.name()}); }

    const VirtualBus bus_;
    SlcanAdapter adapter_;

  private:
    void carry(const std::stop_token& stop) const {
        RawCan wire(bus_.name());
        std::size_t known = 0;
        while (!stop.stop_requested()) {
            for (const std::string& line : adapter_.heard(known)) {
                ++known;
                if (const auto frame = frame_of(line)) {
                    wire.send(*frame);
                }
            }
            std::this_thread::sleep_for(milliseconds(1));
        }
    }
    std::jthread carrier_{[this](const std::stop_token& stop) { carry(stop); }};
};

TEST_F(SlcanFault, BusOffEndsInFailsafeAndARestartBringsControlBack) {
    Program& sender = start_on_adapter();
    Program& reader = start_reader({});
    expect_times(expect_failsafe_and_recovery(
        "sender's controller in bus-off, its interface down and up", [&] { adapter_.bus_off(); },
        [&] {
            set_link_down(adapter_.name());
            set_link_up(adapter_.name());
        }));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(SlcanFault, AdapterThatTakesNothingEndsInFailsafeAndComesBack) {
    Program& sender = start_on_adapter();
    Program& reader = start_reader({});
    expect_times(expect_failsafe_and_recovery(
        "nobody acknowledges the sender's frames, somebody does", [&] { adapter_.block(); },
        [&] { adapter_.unblock(); }));
    EXPECT_TRUE(sender.says("frames are not sent"));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(SlcanFault, AdapterPulledOutAndPutBackEndsInFailsafeAndComesBack) {
    Program& sender = start_on_adapter();
    Program& reader = start_reader({});
    const std::string name = adapter_.name();
    expect_times(expect_failsafe_and_recovery(
        "sender's adapter pulled out, put back", [&] { adapter_.unplug(); },
        [&] { adapter_.plug(); }));
    EXPECT_EQ(adapter_.name(), name) << "the interface got another name";
    EXPECT_TRUE(sender.says("interface " + name + ": is gone"));
    EXPECT_TRUE(sender.says("interface " + name + ": is back"));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

/// Log messages about an interface at the start, and their advice.
class CanStartLog : public TwoPrograms {};

TEST_F(CanStartLog, AdvisesAgainstALongQueue) {
    const PacedBus bus(500'000);
    shell("ip link set dev " + bus.near() + " txqueuelen 1000");
    const Program& sender = start_sender({.sender_interface = bus.near()});
    EXPECT_TRUE(sender.says(bus.near() + ": its queue holds 1000 frames"));
    EXPECT_TRUE(sender.says("`ip link set " + bus.near() + " txqueuelen 16`"));
}

TEST_F(CanStartLog, RefusesFdOnAClassicInterfaceWithTheCommandThatChangesIt) {
    const VirtualBus bus;
    shell("ip link set dev vcan0 down && ip link set dev vcan0 mtu 16 up");
    const std::string config = write_config(R"([input.receiver]
protocol = "ibus"
device = "@receiver"
[output.bus]
protocol = "can"
interface = "vcan0"
fd = true
[pipeline.main]
from = "receiver"
to = "bus"
)");
    Program& refused = start({"run", config});
    EXPECT_EQ(refused.end(), 1);
    EXPECT_NE(refused.errors().find("vcan0"), std::string::npos) << refused.errors();
    EXPECT_NE(refused.errors().find("`ip link set vcan0 mtu 72`"), std::string::npos)
        << refused.errors();
}

/// One program has two outputs and an input on one interface, and so has the other program. What
/// the first output sends comes back to the input through the other program.
TEST_F(TwoPrograms, SeveralOutputsAndAnInputShareAnInterface) {
    const VirtualBus bus;
    FarEnd& other_wire = device("other_servos");
    ServoBank other_servos(other_wire);
    Program& near = run(write_config(R"([input.receiver]
protocol = "ibus"
device = "@receiver"
timeout = "400ms"
[input.back]
protocol = "can"
interface = "vcan0"
id = 0x500
timeout = "400ms"
[output.first]
protocol = "can"
interface = "vcan0"
id = 0x300
[output.second]
protocol = "can"
interface = "vcan0"
id = 0x400
crc = "p01"
[output.servos]
protocol = "sbus"
device = "@servos"
[pipeline.out]
from = "receiver"
to = ["first", "second"]
[pipeline.back]
from = "back"
to = "servos"
)",
                                     "near.toml"));
    Program& far = run(write_config(R"([input.first]
protocol = "can"
interface = "vcan0"
id = 0x300
timeout = "400ms"
[input.second]
protocol = "can"
interface = "vcan0"
id = 0x400
crc = "p01"
timeout = "400ms"
[output.back]
protocol = "can"
interface = "vcan0"
id = 0x500
[output.servos]
protocol = "sbus"
device = "@other_servos"
[pipeline.back]
from = "first"
to = "back"
[pipeline.main]
from = "second"
to = "servos"
)",
                                    "far.toml"));
    const SbusSight wanted = sbus_sight_of(sticks_with_first(1234));
    bool came_back = false;
    bool came_over = false;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : carry_for(milliseconds(10))) {
            came_back = came_back || (sight.good() && same_channels(sight, wanted));
        }
        for (const SbusSight& sight : other_servos.listen()) {
            came_over = came_over || (sight.good() && same_channels(sight, wanted));
        }
        return came_back && came_over;
    })) << came_back
        << came_over << near.errors() << far.errors();
    EXPECT_EQ(count_of("another node", near.errors() + far.errors()), 0U);
    expect_clean_end(near);
    expect_clean_end(far);
}

}  // namespace
}  // namespace tribus::test::can_program_faults_test
