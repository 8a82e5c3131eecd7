#include "transports/links/spi/spi_link.h"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <memory>
#include <mutex>
#include <semaphore>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipelines/realtime/clock.h"
#include "tests/support/edges.h"
#include "tests/support/fewer_descriptors.h"
#include "tests/support/nothing_to_read.h"
#include "tests/support/seen_within.h"
#include "tests/support/spi_port_stand_in.h"
#include "transports/links/pulse_line/pulse_line_medium.h"
#include "transports/links/pulse_line/waveform.h"
#include "transports/links/spi/spi_serial_medium.h"

/// The link that makes pulses with an SPI port, with a stand-in for spidev.
namespace tribus::test::spi_link_test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kDevice = "/dev/spidev9.9";

/// A write returns when its bytes were sent, ESHUTDOWN where the controller is gone.
class SpiPort : public SpiPortStandIn {
  public:
    SpiPort() : SpiPortStandIn(kDevice) {}

    Answer open() override { return opening; }

    Answer control(unsigned long request, void* argument) override {
        switch (request) {
            case SPI_IOC_WR_MODE32:
                mode = static_cast<int>(*static_cast<std::uint32_t*>(argument));
                return knows_idle_low ? 0 : -EINVAL;
            case SPI_IOC_WR_MODE:
                mode = *static_cast<std::uint8_t*>(argument);
                return 0;
            case SPI_IOC_WR_BITS_PER_WORD:
                bits = *static_cast<std::uint8_t*>(argument);
                return 0;
            default:
                return SpiPortStandIn::control(request, argument);
        }
    }

    Answer write(std::span<const std::uint8_t> bytes) override {
        waited_ns += bytes_ns(bytes.size()) + kCallNs;
        ++writes;
        if (std::ranges::all_of(bytes, [](std::uint8_t byte) { return byte == 0; })) {
            return static_cast<long>(bytes.size());
        }
        ++begun;
        if (keeps) {
            let_go.acquire();
        }
        const std::scoped_lock lock(mutex);
        sent.emplace_back(bytes.begin(), bytes.end());
        return failure != 0 ? -failure : static_cast<long>(bytes.size()) - missing;
    }

    std::vector<Bytes> all_sent() {
        const std::scoped_lock lock(mutex);
        return sent;
    }

    /// The time that bytes take on its line is added to that of the machine.
    static Instant now() { return monotonic_now() + Duration(waited_ns.load()); }
    static inline std::atomic<std::int64_t> waited_ns = 0;

    std::atomic<int> writes = 0;
    bool knows_idle_low = false;
    Answer opening{};
    int mode = -1;
    int bits = -1;
    std::atomic<int> failure = 0;
    std::atomic<int> missing = 0;
    std::atomic<bool> keeps = false;
    std::atomic<int> begun = 0;
    std::counting_semaphore<> let_go{0};

  private:
    std::mutex mutex;
    std::vector<Bytes> sent;
};

std::unique_ptr<SpiLink> opened() {
    auto link = SpiLink::open(kDevice, pulse_signal(1), {.now = SpiPort::now});
    EXPECT_TRUE(link.has_value()) << (link ? "" : link.error());
    return link ? std::move(*link) : nullptr;
}

std::string refusal() {
    const auto link = SpiLink::open(kDevice, pulse_signal(1), {.now = SpiPort::now});
    return link ? "it opened" : link.error();
}

FrameLife long_lived() {
    return {.made = SpiPort::now(), .valid_for = 60s};
}

/// Bits that are 1 from each first up to the second, as bytes with the highest bit first.
Bytes bits(std::size_t bytes, const std::vector<std::pair<std::size_t, std::size_t>>& ups) {
    Bytes all(bytes);
    for (const auto& [begin, end] : ups) {
        for (std::size_t bit = begin; bit < end; ++bit) {
            all.at(bit / 8) |= static_cast<std::uint8_t>(0x80 >> bit % 8);
        }
    }
    return all;
}

/// Pulses at 0 and 1000 us, and the pause of 2700 us.
Bytes frame() {
    return ppm_frame({1000});
}

TEST(SpiLink, SendsEightBitsInMode0SoThatABitIsAMicrosecond) {
    const SpiPort port;
    const auto link = opened();
    EXPECT_EQ(port.mode, SPI_MODE_0);
    EXPECT_EQ(port.bits, 8);
    EXPECT_NEAR(port.hz, 1'000'000, 5'000);
}

/// A Raspberry Pi without DMA needs nine clocks for a byte: it is asked for more of them.
TEST(SpiLink, MeasuresHowManyClocksAByteTakes) {
    SpiPort port;
    port.clocks_a_byte = 9;
    const auto link = opened();
    EXPECT_NEAR(port.hz, 1'125'000, 6'000);
}

/// Linux 6.5 (include/uapi/linux/spi/spi.h, SPI_MOSI_IDLE_LOW).
TEST(SpiLink, AsksForADataLineThatRestsLow) {
    SpiPort port;
    port.knows_idle_low = true;
    const auto link = opened();
    EXPECT_EQ(port.mode, SPI_MODE_0 | 1 << 17);
}

/// An output may be using it.
TEST(SpiLink, IsLookedAtWithoutSendingAnything) {
    SpiPort port;
    EXPECT_EQ(why_no_spi_port(kDevice, SpiUse::draws), "");
    EXPECT_EQ(port.writes, 0);
    EXPECT_EQ(port.hz, 0U);
    port.opening = -EACCES;
    EXPECT_TRUE(why_no_spi_port(kDevice, SpiUse::draws).starts_with("this user may not use it"));
}

TEST(SpiLink, RefusesAPortThatNeedsNoTime) {
    SpiPort port;
    port.slowness = 0;
    EXPECT_NE(refusal().find("so it is no SPI port that sends by a clock"), std::string::npos)
        << refusal();
}

TEST(SpiLink, SaysWhatIsInItsWay) {
    SpiPort port;
    port.opening = -EACCES;
    EXPECT_TRUE(refusal().starts_with(std::string(kDevice) + ": this user may not use it"));
    port.opening = -ENOENT;
    EXPECT_TRUE(refusal().starts_with(std::string(kDevice) + ": there is no such device"));
    EXPECT_TRUE(port.asked.empty());
}

TEST(SpiLink, RefusesAPortThatRefusesAnyOfItsSettings) {
    for (const unsigned long request : {SPI_IOC_WR_MODE, SPI_IOC_WR_BITS_PER_WORD}) {
        SpiPort port;
        port.refused = {{request, EINVAL}};
        EXPECT_EQ(refusal(), std::string(kDevice) +
                                 ": this is no SPI port that sends bytes of 8 bits; give one such "
                                 "as /dev/spidev0.0");
    }
    SpiPort port;
    port.refused = {{SPI_IOC_WR_MAX_SPEED_HZ, EINVAL}};
    EXPECT_EQ(refusal(), std::string(kDevice) + ": it refuses a transfer at 1000000 Hz");
}

TEST(SpiLink, SaysThatThereIsNoDescriptorLeftForItsThread) {
    const SpiPort port;
    const FewerDescriptors fewer(1);
    EXPECT_EQ(refusal(), std::string(kDevice) + ": Too many open files");
}

TEST(SpiLink, DrawsAFrameAsBits) {
    SpiPort port;
    const auto link = opened();
    EXPECT_EQ(link->write(frame()), WriteStatus::written);
    ASSERT_TRUE(seen_within([&] { return port.all_sent().size() == 1; }));
    EXPECT_EQ(port.all_sent()[0], bits(463, {{0, 300}, {1000, 1300}}));
}

TEST(SpiLink, IsCalibratedAsTheConfigurationSays) {
    SpiPort port;
    const auto sent_with = [&](const SettingValues& settings) {
        auto link =
            kPulseLineMedium.open(kDevice, {.settings = settings, .worker = {.now = SpiPort::now}});
        EXPECT_TRUE(link.has_value()) << link.error();
        const std::size_t before = port.all_sent().size();
        (*link)->as_bytes()->write_asked(frame(), long_lived());
        EXPECT_TRUE(seen_within([&] { return port.all_sent().size() > before; }));
        return port.all_sent().back();
    };
    EXPECT_EQ(sent_with({}), bits(463, {{0, 300}, {1000, 1300}}));
    SettingValues fast;
    fast.set("calibration", 1.02);
    EXPECT_EQ(sent_with(fast), bits(472, {{0, 306}, {1020, 1326}}));
}

TEST(SpiLink, TakesFramesOfAtMost96Bytes) {
    SpiPort port;
    const auto link = opened();
    Bytes longest = frame();
    longest.resize(96);
    for (std::size_t record = 15; record < 95; record += 5) {
        const Bytes quiet = edge_record(Edge::quiet, 0);
        std::copy(quiet.begin(), quiet.end(),
                  longest.begin() + static_cast<std::ptrdiff_t>(record));
    }
    Bytes longer = longest;
    longer.push_back(0);
    EXPECT_EQ(link->write_asked(longer, long_lived()), WriteStatus::unavailable);
    EXPECT_EQ(link->write_asked(longest, long_lived()), WriteStatus::written);
    ASSERT_TRUE(seen_within([&] { return port.all_sent().size() == 1; }));
    EXPECT_EQ(port.all_sent()[0], bits(463, {{0, 300}, {1000, 1300}}));
}

TEST(SpiLink, TellsWhatBecameOfTheFrameBefore) {
    for (const auto& [failure, status] :
         {std::pair(ENODEV, WriteStatus::lost), std::pair(ENXIO, WriteStatus::lost),
          std::pair(ESHUTDOWN, WriteStatus::lost), std::pair(EIO, WriteStatus::unavailable),
          std::pair(EMSGSIZE, WriteStatus::unavailable)}) {
        SpiPort port;
        const auto link = opened();
        port.failure = failure;
        EXPECT_TRUE(seen_within([&] { return link->write(frame()) == status; })) << failure;
        port.failure = 0;
        EXPECT_TRUE(seen_within([&] { return link->write(frame()) == WriteStatus::written; }));
    }
}

TEST(SpiLink, AFrameThatWasSentInPartIsNotWritten) {
    SpiPort port;
    const auto link = opened();
    port.missing = 1;
    EXPECT_TRUE(seen_within([&] { return link->write(frame()) == WriteStatus::unavailable; }));
}

TEST(SpiLink, DropsAFrameThatIsTooOld) {
    SpiPort port;
    const auto link = opened();
    EXPECT_TRUE(seen_within([&] {
        return link->write_asked(frame(), {.made = SpiPort::now() - 1s, .valid_for = 1ms}) ==
               WriteStatus::busy;
    }));
    EXPECT_TRUE(port.all_sent().empty());
}

TEST(SpiLink, SendsTheNewestOfTheFramesThatWaited) {
    SpiPort port;
    port.keeps = true;
    const auto link = opened();
    link->write_asked(frame(), long_lived());
    ASSERT_TRUE(seen_within([&] { return port.begun == 1; }));
    link->write_asked(ppm_frame({1200}), long_lived());
    link->write_asked(ppm_frame({1400}), long_lived());
    port.let_go.release(2);
    ASSERT_TRUE(seen_within([&] { return port.all_sent().size() == 2; }));
    EXPECT_EQ(port.all_sent()[1], bits(513, {{0, 300}, {1400, 1700}}));
}

TEST(SpiLink, WithdrawsAFrameThatWaits) {
    SpiPort port;
    port.keeps = true;
    const auto link = opened();
    link->write_asked(frame(), long_lived());
    ASSERT_TRUE(seen_within([&] { return port.begun == 1; }));
    link->write_asked(ppm_frame({1200}), long_lived());
    link->write_asked(quiet_record(), long_lived());
    port.let_go.release(1);
    // The thread has looked at the record when it is idle; then a frame is the second one.
    EXPECT_TRUE(seen_within(
        [&] { return link->write_asked(quiet_record(), long_lived()) == WriteStatus::written; }));
    std::this_thread::sleep_for(50ms);
    EXPECT_EQ(port.begun, 1);
    port.let_go.release(1);
    link->write_asked(ppm_frame({1400}), long_lived());
    ASSERT_TRUE(seen_within([&] { return port.all_sent().size() == 2; }));
    EXPECT_EQ(port.all_sent()[1], bits(513, {{0, 300}, {1400, 1700}}));
}

std::vector<std::string>& warnings() {
    static std::vector<std::string> all;
    return all;
}
void warn(std::string text) {
    warnings().push_back(std::move(text));
}

class SpiLinkAtAClockThatChanges : public testing::Test {
  protected:
    SpiLinkAtAClockThatChanges() {
        warnings().clear();
        auto opened = SpiLink::open(kDevice, pulse_signal(1), {.now = SpiPort::now, .warn = warn});
        EXPECT_TRUE(opened.has_value());
        link_ = std::move(*opened);
        send(100);
    }
    /// Sends so many frames, one after the other.
    void send(int frames) {
        for (int i = 0; i < frames; ++i) {
            const std::size_t before = port_.all_sent().size();
            link_->write_asked(frame(), long_lived());
            ASSERT_TRUE(seen_within([&] { return port_.all_sent().size() > before; }));
        }
    }
    /// Whether a byte takes 8 us now. The machine's own time adds to that of the port.
    void expect_right_rate() const { EXPECT_NEAR(port_.hz / (1e6 * port_.slowness), 1, 0.01); }

    SpiPort port_;
    std::unique_ptr<SpiLink> link_;
};

TEST_F(SpiLinkAtAClockThatChanges, MeasuresItAnewAndSaysThatOnce) {
    expect_right_rate();
    port_.slowness = 1.05;
    send(120);
    expect_right_rate();
    port_.slowness = 0.5;
    send(120);
    expect_right_rate();
    link_.reset();
    ASSERT_EQ(warnings().size(), 1U);
    EXPECT_TRUE(warnings()[0].starts_with(std::string(kDevice) + ": its clock has changed by -"))
        << warnings()[0];
    EXPECT_NE(warnings()[0].find(" %, so bits had the wrong length"), std::string::npos);
    EXPECT_NE(warnings()[0].find("core_freq_min=500"), std::string::npos);
}

/// The appliance opens it again, and says which rates it tried.
TEST_F(SpiLinkAtAClockThatChanges, IsLostIfNoRateFitsAnyMore) {
    port_.slowness = 0.01;
    EXPECT_TRUE(seen_within(
        [&] { return link_->write_asked(frame(), long_lived()) == WriteStatus::lost; }));
    link_.reset();
    EXPECT_TRUE(warnings().empty());
}

/// Each bit of the line is a byte of the port (docs/protocols/sbus.md, "Line").
TEST(SpiSerialPort, DrawsWhatAnInvertedLineCarries) {
    SpiPort port;
    port.clocks_a_byte = 9;
    const LineSettings line{
        .baud = 100'000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};
    auto link = kSpiSerialMedium.open(kDevice, {.line = line, .worker = {.now = SpiPort::now}});
    ASSERT_TRUE(link.has_value()) << link.error();
    EXPECT_NEAR(port.hz, 900'000, 4'500);
    (*link)->as_bytes()->write_asked(Bytes{0x0F}, long_lived());
    ASSERT_TRUE(seen_within([&] { return port.all_sent().size() == 1; }));
    EXPECT_EQ(port.all_sent()[0],
              (Bytes{0, 0, 0xFF, 0, 0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0}));
}

TEST(SpiLink, HasNothingToRead) {
    const SpiPort port;
    const auto link = opened();
    expect_nothing_to_read(*link);
}

}  // namespace
}  // namespace tribus::test::spi_link_test
