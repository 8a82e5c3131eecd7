#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/thread_notices.h"
#include "tests/loopback/machine/running_daemon.h"
#include "tests/loopback/wire.h"
#include "tests/reference/plain_uart.h"
#include "tests/support/sampled_line.h"
#include "tests/support/spi_port_stand_in.h"

/// A daemon with SBUS out of an SPI port, and into one, with a stand-in for spidev that takes the
/// time of the machine.
namespace tribus::test::spi_daemon_test {
namespace {

using namespace std::chrono_literals;

/// A port of nine clocks a byte.
class SpiPort : public SpiPortStandIn {
  public:
    explicit SpiPort(const std::string& path) : SpiPortStandIn(path) {
        std::ofstream{path};
        clocks_a_byte = 9;
    }

    Answer write(std::span<const std::uint8_t> bytes) override {
        std::this_thread::sleep_until(end_of(bytes.size()));
        if (std::ranges::any_of(bytes, [](std::uint8_t byte) { return byte != 0; })) {
            const std::scoped_lock lock(mutex_);
            drawn_.assign(bytes.begin(), bytes.end());
        }
        return static_cast<long>(bytes.size());
    }
    Answer read(std::span<std::uint8_t> room) override {
        const double begin_us = us_of(monotonic_now());
        std::this_thread::sleep_until(end_of(room.size()));
        std::ranges::copy(line.sample(begin_us, room.size(), clocks_a_byte), room.begin());
        return static_cast<long>(room.size());
    }
    /// What a servo reads of the latest frame, if each byte is undamaged.
    Bytes latest_frame() {
        const std::scoped_lock lock(mutex_);
        constexpr double kBitUs = 10;
        const auto level = [&](double at) {
            const auto place = static_cast<std::size_t>(at / kBitUs);
            return place < drawn_.size() && drawn_[place] != 0;
        };
        Bytes bytes;
        for (const UartByte& byte :
             PlainUart{}.read(level, 0, kBitUs * static_cast<double>(drawn_.size()))) {
            if (byte.parity_error || byte.framing_error) {
                return {};
            }
            bytes.push_back(byte.value);
        }
        return bytes;
    }
    static double us_of(Instant time) {
        return static_cast<double>(time.time_since_epoch().count()) / 1000;
    }

    SampledLine line;

  private:
    std::chrono::steady_clock::time_point end_of(std::size_t bytes) const {
        return std::chrono::steady_clock::now() + Duration(bytes_ns(bytes));
    }

    std::mutex mutex_;
    Bytes drawn_;
};

class DaemonWithSpi : public RunningDaemon {
  protected:
    /// The daemon ends before the port.
    ~DaemonWithSpi() override {
        daemon_.reset();
        std::filesystem::remove(path_);
    }
    std::string text(const std::string& input, const std::string& output) const {
        return "[input.receiver]\n" + input + "timeout = \"200ms\"\n[output.servos]\n" + output +
               "protocol = \"sbus\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
               "[pipeline.main.failsafe]\nhold = \"0s\"\n[runtime]\nrealtime = \"off\"\n";
    }
    std::string spi() const { return "spi = \"" + path_ + "\"\n"; }
    void look() { daemon_->look(monotonic_now()); }

    /// Paths of devices begin with /dev.
    std::string path_ = "/dev/shm/tribus-spi-" + std::to_string(::getpid());
    SpiPort port_{path_};
};

TEST_F(DaemonWithSpi, DrawsTheChannelsOfTheReceiverAndItsLossAsFailsafe) {
    start(text("protocol = \"ibus\"\ndevice = \"" + receiver_.path() + "\"\n", spi()));
    const Sticks sticks = sticks_with_first(1234);
    const Bytes wanted = sbus_bytes(sbus_sight_of(sticks));
    EXPECT_TRUE(seen_within([&] {
        look();
        receiver_.send(ibus_bytes(sticks));
        return port_.latest_frame() == wanted;
    })) << logged_.text();
    constexpr std::uint8_t kFailsafe = 0x08;
    EXPECT_TRUE(seen_within([&] {
        look();
        const Bytes frame = port_.latest_frame();
        return frame.size() == 25 && (frame[23] & kFailsafe) != 0;
    }));
}

TEST_F(DaemonWithSpi, HearsAReceiverAndItsSilence) {
    const Sticks sticks = sticks_with_first(1777);
    const double begin = SpiPort::us_of(monotonic_now());
    constexpr int kFrames = 1000;
    for (int i = 0; i < kFrames; ++i) {
        port_.line.send(begin + i * 9000.0, sbus_bytes(sbus_sight_of(sticks)));
    }
    start(text("protocol = \"sbus\"\n" + spi(), "device = \"" + servos_.path() + "\"\n"));
    ServoBank servos(servos_);
    bool good = false;
    bool lost = false;
    // A busy machine may need all of these frames.
    EXPECT_TRUE(seen_within([&] {
        look();
        for (const SbusSight& sight : servos.listen()) {
            EXPECT_TRUE(!sight.good() || same_channels(sight, sbus_sight_of(sticks)));
            good = good || sight.good();
            lost = good && sight.failsafe;
        }
        return lost;
    })) << logged_.text();
}

TEST_F(DaemonWithSpi, SaysWhatThreadsOfLinksHaveToSay) {
    start();
    add_thread_notice("/dev/spidev0.0: its clock has changed");
    look();
    EXPECT_TRUE(has_said("/dev/spidev0.0: its clock has changed")) << logged_.text();
    EXPECT_TRUE(take_thread_notices().empty());
}

}  // namespace
}  // namespace tribus::test::spi_daemon_test
