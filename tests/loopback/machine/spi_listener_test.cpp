#include "transports/links/spi/spi_listener.h"

#include <poll.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/edges.h"
#include "tests/support/sampled_line.h"
#include "tests/support/seen_within.h"
#include "tests/support/spi_port_stand_in.h"
#include "transports/links/spi/spi_serial_medium.h"

/// The link that hears a serial line with an SPI port, with a stand-in for spidev. Blocks of
/// samples take no time of the machine, but that of the link's clock.
namespace tribus::test::spi_listener_test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kDevice = "/dev/spidev9.8";
constexpr LineSettings kSbusLine{
    .baud = 100'000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

/// A read returns when as many bytes were sampled as it asked for. Each read waits until the test
/// allows it.
class SpiPort : public SpiPortStandIn {
  public:
    SpiPort() : SpiPortStandIn(kDevice) {}

    Answer write(std::span<const std::uint8_t> bytes) override {
        clock_ns += kCallNs + bytes_ns(bytes.size());
        return static_cast<long>(bytes.size());
    }
    Answer read(std::span<std::uint8_t> room) override {
        std::unique_lock lock(mutex_);
        waits_ = true;
        changed_.notify_all();
        changed_.wait(lock, [this] { return allowed_ > 0; });
        waits_ = false;
        --allowed_;
        if (failure != 0) {
            return -failure;
        }
        const double begin_us = static_cast<double>(clock_ns) / 1000;
        const auto samples = line.sample(begin_us, room.size(), clocks_a_byte,
                                         static_cast<double>(bytes_ns(1000)) / 1e6);
        std::ranges::copy(samples, room.begin());
        if (!needs_no_time) {
            clock_ns += kCallNs + bytes_ns(room.size()) + held_up.count();
        }
        return static_cast<long>(room.size());
    }

    void send(Instant begin, const Bytes& bytes) {
        const std::scoped_lock lock(mutex_);
        line.send(static_cast<double>(begin.time_since_epoch().count()) / 1000, bytes);
    }
    /// Lets so many reads return.
    void allow(int count) {
        const std::scoped_lock lock(mutex_);
        allowed_ += count;
        changed_.notify_all();
    }
    /// So that the link can end.
    void allow_all() { allow(1'000'000); }
    /// The same as `allow`, and waits until the link waits in the next one.
    void take_blocks(int count) {
        allow(count);
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return allowed_ == 0 && waits_; });
    }
    /// The same until its clock has that time.
    void take_until(Instant time) {
        while (now() < time) {
            take_blocks(1);
        }
    }

    /// The link's thread is in a read, or about to begin one.
    bool waits() {
        const std::scoped_lock lock(mutex_);
        return waits_;
    }

    static Instant now() {
        const std::scoped_lock lock(clock_held);
        return Instant(Duration(clock_ns));
    }
    /// Who holds it stops whoever asks for the time.
    static inline std::mutex clock_held;
    static inline std::atomic<std::int64_t> clock_ns = 0;

    SampledLine line;
    std::atomic<int> failure = 0;
    Duration held_up{};  ///< behind each block
    bool needs_no_time = false;

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    int allowed_ = 0;
    bool waits_ = false;
};

Bytes frame(std::uint8_t first) {
    Bytes bytes(25);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(first + i);
    }
    return bytes;
}

class SpiListenerAtAPort : public testing::Test {
  protected:
    SpiListenerAtAPort() {
        auto opened = SpiListener::open(kDevice, kSbusLine, {.now = SpiPort::now});
        EXPECT_TRUE(opened.has_value()) << (opened ? "" : opened.error());
        link_ = std::move(*opened);
        port_.take_blocks(0);
    }
    ~SpiListenerAtAPort() override { port_.allow_all(); }

    /// Returns what the next read has; empty if it has nothing.
    Reception read() {
        Reception reception;
        status_ = link_->read(reception);
        return reception;
    }
    Bytes bytes_of(const Reception& reception) {
        return {reception.view().begin(), reception.view().end()};
    }
    /// Reads all that is there; returns how many bursts of 25 undamaged bytes.
    int whole_bursts() {
        int count = 0;
        for (Reception reception = read(); reception.count > 0; reception = read()) {
            count += reception.count == 25 && reception.damaged.none() ? 1 : 0;
        }
        return count;
    }

    SpiPort port_;
    std::unique_ptr<SpiListener> link_;
    ReadStatus status_{};
};

TEST_F(SpiListenerAtAPort, ReadsEachBurstByItselfWithTheTimeOfItsSamples) {
    const Instant begin = SpiPort::now();
    port_.send(begin + 2ms, frame(1));
    port_.send(begin + 9ms, frame(2));
    EXPECT_EQ(read().count, 0U);
    EXPECT_EQ(status_, ReadStatus::nothing);
    port_.take_blocks(1);
    const Reception first = read();
    EXPECT_EQ(status_, ReadStatus::received);
    EXPECT_EQ(bytes_of(first), frame(1));
    EXPECT_TRUE(first.full);
    EXPECT_LE(std::chrono::abs(first.at - (begin + 5ms)), 20us);
    const Reception second = read();
    EXPECT_EQ(bytes_of(second), frame(2));
    EXPECT_FALSE(second.full);
    EXPECT_LE(std::chrono::abs(second.at - (begin + 12ms)), 20us);
    EXPECT_EQ(read().count, 0U);
}

TEST_F(SpiListenerAtAPort, MarksADamagedByte) {
    // The line is high where the second byte has its first stop bit.
    const Instant begin = SpiPort::now();
    port_.send(begin + 2ms, {0x0F, 0x0F});
    port_.send(begin + 2ms + 222us, {0x0F});
    port_.take_blocks(1);
    const Reception reception = read();
    ASSERT_GE(reception.count, 2U);
    EXPECT_FALSE(reception.damaged[0]);
    EXPECT_TRUE(reception.damaged[1]);
}

/// A recorded receiver's rate, 9 ms.
TEST_F(SpiListenerAtAPort, LosesNoFrameOfAReceiverOnceItKnowsItsRhythm) {
    const Instant begin = SpiPort::now();
    constexpr int kFrames = 511;
    for (int i = 0; i < kFrames; ++i) {
        port_.send(begin + 2ms + i * 9ms, frame(static_cast<std::uint8_t>(i)));
    }
    port_.take_until(begin + 101ms);
    whole_bursts();
    int whole = 0;
    while (SpiPort::now() < begin + kFrames * 9ms) {
        port_.take_blocks(1);
        whole += whole_bursts();
    }
    EXPECT_EQ(whole, kFrames - 12);
}

TEST_F(SpiListenerAtAPort, WakesWhoWaitsForItsDescriptor) {
    const auto is_ready = [&] {
        pollfd ready{.fd = link_->descriptor(), .events = POLLIN, .revents = 0};
        return ::poll(&ready, 1, 0) == 1;
    };
    port_.take_blocks(1);
    EXPECT_FALSE(is_ready()) << "nothing came";
    port_.send(SpiPort::now() + 2ms, frame(1));
    port_.take_blocks(1);
    EXPECT_TRUE(is_ready());
    EXPECT_TRUE(link_->has_unread());
    whole_bursts();
    EXPECT_FALSE(is_ready());
    EXPECT_FALSE(link_->has_unread());
}

TEST_F(SpiListenerAtAPort, KeepsNothingThatWasDiscarded) {
    port_.send(SpiPort::now() + 2ms, frame(1));
    port_.take_blocks(1);
    link_->discard_unread();
    EXPECT_EQ(read().count, 0U);
}

TEST_F(SpiListenerAtAPort, HasRoomForFortyFramesAndDropsWhatNobodyReads) {
    const Instant begin = SpiPort::now();
    for (int i = 0; i < 60; ++i) {
        port_.send(begin + 2ms + i * 7ms, frame(static_cast<std::uint8_t>(i)));
    }
    port_.take_until(begin + 450ms);
    int bytes = 0;
    for (Reception reception = read(); reception.count > 0; reception = read()) {
        bytes += static_cast<int>(reception.count);
    }
    EXPECT_EQ(bytes, 40 * 25) << "and no half of a further one";
    port_.send(SpiPort::now() + 10ms, frame(1));
    port_.take_until(SpiPort::now() + 40ms);
    EXPECT_EQ(whole_bursts(), 1);
}

/// Both may come before who waits for the descriptor runs, and nothing wakes it a second time.
TEST_F(SpiListenerAtAPort, IsLostWithItsPortInTheReadAfterWhatCameBefore) {
    port_.send(SpiPort::now() + 2ms, frame(1));
    port_.take_blocks(1);
    port_.failure = ESHUTDOWN;
    port_.allow(1);
    ASSERT_TRUE(seen_within([&] { return link_->has_unread() && !port_.waits(); }));
    std::this_thread::sleep_for(20ms);
    const Reception last = read();
    EXPECT_EQ(last.count, 25U);
    EXPECT_TRUE(last.full) << "there is more to read: the loss";
    EXPECT_TRUE(link_->has_unread());
    EXPECT_EQ(read().count, 0U);
    EXPECT_EQ(status_, ReadStatus::lost);
}

TEST_F(SpiListenerAtAPort, AsksAPortAgainThatRefusesABlock) {
    port_.failure = EIO;
    port_.take_blocks(3);
    port_.failure = 0;
    port_.send(SpiPort::now() + 2ms, frame(1));
    port_.take_blocks(1);
    EXPECT_EQ(whole_bursts(), 1);
    EXPECT_EQ(read().count, 0U);
    EXPECT_EQ(status_, ReadStatus::nothing);
}

/// A Raspberry Pi 4 from 200 to 500 MHz, or back.
TEST_F(SpiListenerAtAPort, HearsAgainAfterItsClockHasChanged) {
    for (const double change : {0.4, 2.5}) {
        port_.slowness = change;
        for (int i = 0; i < 200; ++i) {
            port_.take_blocks(1);
        }
        whole_bursts();
        const Instant begin = SpiPort::now();
        for (int i = 0; i < 20; ++i) {
            port_.send(begin + 10ms + i * 9ms, frame(static_cast<std::uint8_t>(i)));
        }
        port_.take_until(begin + 200ms);
        EXPECT_GE(whole_bursts(), 10) << change;
    }
}

/// The appliance opens it again, and says which rates it tried.
TEST_F(SpiListenerAtAPort, IsLostIfNoRateFitsAnyMore) {
    port_.slowness = 0.01;
    port_.allow_all();
    EXPECT_TRUE(seen_within([&] { return read().count == 0 && status_ == ReadStatus::lost; }));
}

/// Zeros that the watch of the clock sends do not fit into each pause.
TEST_F(SpiListenerAtAPort, LosesNoFrameOfAFastSenderToTheWatchOfItsClock) {
    const Instant begin = SpiPort::now();
    constexpr int kFrames = 500;
    for (int i = 0; i < kFrames; ++i) {
        port_.send(begin + 2ms + i * 7ms, frame(static_cast<std::uint8_t>(i)));
    }
    port_.take_until(begin + 100ms);
    whole_bursts();
    int whole = 0;
    while (SpiPort::now() < begin + kFrames * 7ms) {
        port_.take_blocks(1);
        whole += whole_bursts();
    }
    EXPECT_GE(whole, kFrames - 100 / 7 - 2);
}

/// A block that ends at once has no samples of the line.
TEST_F(SpiListenerAtAPort, TakesNothingFromAPortThatNeedsNoTime) {
    port_.send(SpiPort::now() + 2ms, frame(1));
    port_.needs_no_time = true;
    port_.take_blocks(3);
    EXPECT_EQ(whole_bursts(), 0);
}

/// Its samples may be that old.
TEST_F(SpiListenerAtAPort, IsNeverTooYoungWithABlockThatWasHeldUp) {
    const Instant begin = SpiPort::now();
    port_.send(begin + 2ms, frame(1));
    port_.held_up = 50ms;
    port_.take_blocks(1);
    const Reception reception = read();
    EXPECT_EQ(reception.count, 25U);
    EXPECT_LE(std::chrono::abs(reception.at - (begin + 5ms)), 20us);
}

TEST_F(SpiListenerAtAPort, StandsIfItsThreadDoesNotRunButNotIfTheKernelKeepsIt) {
    EXPECT_FALSE(link_->stands(SpiPort::now() + 10s)) << "it waits in the kernel";
    std::unique_lock held(SpiPort::clock_held);
    port_.allow(1);
    ASSERT_TRUE(seen_within([&] { return !port_.waits(); }));
    const Instant now(Duration(SpiPort::clock_ns.load()));
    EXPECT_TRUE(seen_within([&] { return link_->stands(now + 1100ms); }));
    EXPECT_FALSE(link_->stands(now + 900ms));
    held.unlock();
}

TEST_F(SpiListenerAtAPort, SendsNothing) {
    EXPECT_EQ(link_->write(frame(1)), WriteStatus::unavailable);
}

/// An output needs a data line that rests low (docs/boards/spi.md); an input does not draw.
TEST(SpiListener, IsOpenedForAnInput) {
    SpiPort port;
    auto link = kSpiSerialMedium.open(
        kDevice, {.line = kSbusLine, .way = SettingScope::input, .worker = {.now = SpiPort::now}});
    ASSERT_TRUE(link.has_value()) << link.error();
    EXPECT_GE((*link)->descriptor(), 0);
    port.allow_all();
}

TEST(SpiListener, SaysWhatIsInItsWay) {
    class Refusing : public SpiPort {
        Answer open() override { return -EACCES; }
    };
    const Refusing port;
    const auto link = SpiListener::open(kDevice, kSbusLine, {.now = SpiPort::now});
    ASSERT_FALSE(link.has_value());
    EXPECT_TRUE(link.error().starts_with(std::string(kDevice) + ": this user may not use it"));
}

}  // namespace
}  // namespace tribus::test::spi_listener_test
