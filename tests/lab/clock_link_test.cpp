#include <poll.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/distribution.h"
#include "tests/bench/tester.h"
#include "tests/lab/guest.h"
#include "tests/loopback/loopback.h"
#include "tests/loopback/udp_socket.h"

/// Two pairs of boxes, one pair's link with a key, in a guest whose time is the number of executed
/// instructions: an idle machine with one slow processor, whatever the host does.
namespace tribus::test::clock_link_test {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kPeriod{10};
constexpr int kFrames = 1000;
constexpr int kWarmUpFrames = 100;
constexpr int kFloodedFrames = 400;

long in_microseconds(const Distribution& times, double percent) {
    return times.percentile(percent) / std::chrono::microseconds(1);
}

/// i.Bus into one program, CAN FD to another, SBUS out of that.
struct Pair {
    FarEnd& receiver;
    FarEnd& servo_wire;
    ServoBank servos{servo_wire};
    std::vector<Duration> times{};

    /// Sends a frame and notes the time until the servos have it.
    void carry(int first_us) {
        servos.listen();
        const Bytes frame = ibus_bytes(sticks_with_first(first_us));
        const auto sent = Clock::now();
        receiver.send(frame);
        const auto end = sent + kPeriod / 2;
        for (auto now = sent; now < end; now = Clock::now()) {
            pollfd wait{.fd = servo_wire.descriptor(), .events = POLLIN, .revents = 0};
            const timespec left{.tv_sec = 0, .tv_nsec = (end - now).count()};
            ::ppoll(&wait, 1, &left, nullptr);
            for (const SbusSight& sight : servos.listen()) {
                if (sight.good() && sight.raw[0] == sbus_raw(first_us)) {
                    times.push_back(sight.seen - sent);
                    return;
                }
            }
        }
    }
};

class LabLink : public Loopback {
  protected:
    LabLink() { write_key("boat.key", '7'); }

    /// Starts both programs of a pair. `name` begins the names of its devices.
    Pair start(const std::string& name, const std::string& interface, const std::string& key) {
        Pair pair{device(name + "-receiver"), device(name + "-servos")};
        const std::string link =
            "protocol = \"can\"\nfd = true\ninterface = \"" + interface + "\"\n" + key;
        // A little less than that of the frames, so that each is sent at once.
        const std::string follow = "period = \"9ms\"\n";
        run(write_config("[input.bus]\n" + link + "[output.servos]\nprotocol = \"sbus\"\n" +
                             follow + "device = \"@" + name +
                             "-servos\"\n[pipeline.main]\nfrom = \"bus\"\nto = \"servos\"\n",
                         name + "-reader.toml"));
        run(write_config("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@" + name +
                             "-receiver\"\n[output.bus]\n" + link + follow +
                             "[pipeline.main]\nfrom = \"receiver\"\nto = \"bus\"\n",
                         name + "-sender.toml"));
        return pair;
    }
};

TEST_F(LabLink, WithAKeyTakesAtMostATenthLongerThanWithout) {
    const VirtualBus plain_bus("vcan0");
    const VirtualBus keyed_bus("vcan1");
    Pair plain = start("plain", "vcan0", "");
    Pair keyed = start("keyed", "vcan1", "key = \"@boat.key\"\n");
    const bench::TesterPriority priority;
    auto next = Clock::now();
    for (int frame = 0; frame < kFrames; ++frame) {
        if (frame == kWarmUpFrames) {
            plain.times.clear();
            keyed.times.clear();
        }
        for (Pair* pair : {&plain, &keyed}) {
            std::this_thread::sleep_until(next);
            next += kPeriod / 2;
            pair->carry(1200 + frame % 2 * 600);
        }
    }
    const Distribution without(std::move(plain.times));
    const Distribution with(std::move(keyed.times));
    EXPECT_GT(without.size(), 800U);
    EXPECT_GT(with.size(), 800U);
    EXPECT_LE(ratio_of(with.percentile(50), without.percentile(50)), 1.1)
        << in_microseconds(with, 50) << " us with a key, " << in_microseconds(without, 50)
        << " us without";
}

/// A network that lets waiting datagrams through 50 times a second, all at once.
class SlottedNetwork {
  public:
    SlottedNetwork() {
        shell(
            "modprobe sch_netem; ip link set lo up; "
            "tc qdisc add dev lo root netem slot 19300us 19300us packets 1000 limit 10000");
    }
    SlottedNetwork(const SlottedNetwork&) = delete;
    SlottedNetwork& operator=(const SlottedNetwork&) = delete;
    ~SlottedNetwork() { run_shell("tc qdisc del dev lo root"); }
};

/// The program has a pipeline from UDP with a key, and another one from a receiver to servos. What
/// the kernel itself needs for a burst delays everything: as much as where nobody reads it.
TEST_F(LabLink, FloodOfForgedDatagramsDelaysAnotherPipelineLittleMoreThanAFloodToNobody) {
    const SlottedNetwork network;
    Pair other{device("receiver"), device("servos")};
    device("boat");
    Program& program = run(write_config(
        "[input.shore]\nprotocol = \"network\"\naddress = \"127.0.0.1:5700\"\n"
        "key = \"@boat.key\"\n[output.boat]\nprotocol = \"sbus\"\ndevice = \"@boat\"\n"
        "[pipeline.boat]\nfrom = \"shore\"\nto = \"boat\"\n"
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n"
        "[output.servos]\nprotocol = \"sbus\"\nperiod = \"9ms\"\ndevice = \"@servos\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"));
    const UdpSocket flooder;
    const UdpSocket nobody;
    // The head of a datagram (docs/protocols/network.md), then a hello with a wrong MAC.
    Bytes forged{0x54, 0x52, 0x01, 24};
    forged.resize(4 + 24);
    const bench::TesterPriority priority;
    auto next = Clock::now();
    const auto flood = [&](std::uint16_t port, int frames) {
        for (int frame = 0; frame < frames; ++frame) {
            for (int i = 0; i < 125; ++i) {
                flooder.send_to(port, forged);
            }
            std::this_thread::sleep_until(next += kPeriod);
            other.carry(1200 + frame % 2 * 600);
        }
        return Distribution(std::exchange(other.times, {}));
    };
    flood(nobody.port(), kWarmUpFrames);
    const auto elsewhere = flood(nobody.port(), kFloodedFrames);
    const auto flooded = flood(5700, kFloodedFrames);
    EXPECT_TRUE(program.says("input shore: forged")) << program.errors();
    EXPECT_EQ(elsewhere.size(), kFloodedFrames);
    EXPECT_EQ(flooded.size(), kFloodedFrames);
    EXPECT_LT(ratio_of(flooded.percentile(100), elsewhere.percentile(100)), 2)
        << in_microseconds(flooded, 100) << " us, to nobody " << in_microseconds(elsewhere, 100);
}

}  // namespace
}  // namespace tribus::test::clock_link_test
