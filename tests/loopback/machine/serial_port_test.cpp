#include "transports/links/serial/serial_port.h"

// termios2 shows what the port really has. <termios.h> conflicts with this header.
#include <asm/termbits.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "pipelines/realtime/clock.h"
#include "tests/support/seen_within.h"
#include "transports/links/unique_fd.h"

namespace tribus::serial_port_test {
namespace {

using ::testing::IsSubstring;
using Bytes = std::vector<std::uint8_t>;
using OpenedPort = tl::expected<std::unique_ptr<SerialPort>, std::string>;

constexpr LineSettings kSbusLine{
    .baud = 100000, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};

/// Time for a kernel worker to carry the bytes from one end to the other, far longer than it takes.
constexpr int kArrivalMilliseconds = 30'000;
/// Time in which bytes that must not arrive would arrive, unless the machine is busy.
constexpr int kSilenceMilliseconds = 50;

/// Returns the events within `milliseconds`: POLLIN, POLLHUP and so on.
short wait_for(int fd, int milliseconds) {
    struct pollfd waiting {
        .fd = fd, .events = POLLIN, .revents = 0
    };
    ::poll(&waiting, 1, milliseconds);
    return waiting.revents;
}

std::string error_of(const OpenedPort& opened) {
    return opened ? "it opened" : opened.error();
}

/// A new pty, with echo, line editing and newline translation on.
class SerialPortTest : public ::testing::Test {
  protected:
    void SetUp() override {
        wire_ = UniqueFd(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
        ASSERT_TRUE(wire_.valid());
        ASSERT_EQ(::grantpt(wire_.get()), 0);
        ASSERT_EQ(::unlockpt(wire_.get()), 0);
        std::array<char, 64> name{};
        ASSERT_EQ(::ptsname_r(wire_.get(), name.data(), name.size()), 0);
        device_ = name.data();
    }

    std::unique_ptr<SerialPort> open_port(const LineSettings& settings = kSbusLine) {
        auto opened = SerialPort::open(device_, settings);
        EXPECT_TRUE(opened.has_value()) << error_of(opened);
        return opened ? std::move(*opened) : nullptr;
    }

    void send(const Bytes& bytes) {
        ASSERT_EQ(::write(wire_.get(), bytes.data(), bytes.size()),
                  static_cast<ssize_t>(bytes.size()));
    }

    /// Returns `count` bytes from the wire's end, or fewer if no more come.
    Bytes receive(std::size_t count, int milliseconds = kArrivalMilliseconds) {
        Bytes bytes;
        while (bytes.size() < count && (wait_for(wire_.get(), milliseconds) & POLLIN) != 0) {
            std::array<std::uint8_t, 4096> piece{};
            const ssize_t taken = ::read(wire_.get(), piece.data(), piece.size());
            if (taken <= 0) {
                break;
            }
            bytes.insert(bytes.end(), piece.begin(), piece.begin() + taken);
        }
        return bytes;
    }

    Bytes receive_all() { return receive(SIZE_MAX, kSilenceMilliseconds); }

    bool wire_is_silent() { return (wait_for(wire_.get(), kSilenceMilliseconds) & POLLIN) == 0; }

    UniqueFd wire_;
    std::string device_;
};

/// Reads until `count` bytes are there or no more come. None of them may be damaged.
Bytes read_from(SerialPort& port, std::size_t count) {
    Bytes bytes;
    while (bytes.size() < count && wait_for(port.descriptor(), kArrivalMilliseconds) == POLLIN) {
        Reception reception;
        port.read(reception);
        EXPECT_TRUE(reception.damaged.none());
        const auto view = reception.view();
        bytes.insert(bytes.end(), view.begin(), view.end());
    }
    return bytes;
}

Bytes every_byte_value() {
    Bytes bytes(256);
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
    return bytes;
}

/// Bytes to which a terminal reacts: CR, NL, ^C, ^D, ^S, ^Z.
Bytes terminal_traps() {
    return {'a', 0x0D, 0x0A, 0x03, 0x04, 0x13, 0x1A, 0x7F, 'b'};
}

TEST_F(SerialPortTest, OpensAPtyAt100000With8E2AlthoughItDropsTheParity) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    struct termios2 line {};
    ASSERT_EQ(::ioctl(port->descriptor(), TCGETS2, &line), 0);
    EXPECT_EQ(line.c_ospeed, 100000U);
    EXPECT_NE(line.c_cflag & CSTOPB, 0U);
    EXPECT_EQ(line.c_cflag & PARENB, 0U) << "this kernel's ptys keep parity: nothing was shown";
}

TEST_F(SerialPortTest, OpensWith8N1) {
    const auto port = open_port(LineSettings{});
    ASSERT_NE(port, nullptr);
    struct termios2 line {};
    ASSERT_EQ(::ioctl(port->descriptor(), TCGETS2, &line), 0);
    EXPECT_EQ(line.c_ospeed, 115200U);
    EXPECT_EQ(line.c_cflag & (CSTOPB | PARENB), 0U);
}

TEST_F(SerialPortTest, MarksParityErrorsAndNothingElseOfTheInput) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    struct termios2 line {};
    ASSERT_EQ(::ioctl(port->descriptor(), TCGETS2, &line), 0);
    EXPECT_EQ(line.c_iflag, static_cast<tcflag_t>(INPCK | PARMRK));
    EXPECT_EQ(line.c_oflag, 0U);
    EXPECT_EQ(line.c_lflag, 0U);
}

TEST_F(SerialPortTest, FollowsALinkLikeThoseUnderById) {
    const std::string link = ::testing::TempDir() + "tribus-link-" + std::to_string(::getpid());
    ASSERT_EQ(::symlink(device_.c_str(), link.c_str()), 0);
    const auto opened = SerialPort::open(link, kSbusLine);
    EXPECT_TRUE(opened.has_value()) << error_of(opened);
    ::unlink(link.c_str());
}

TEST_F(SerialPortTest, ThrowsAwayWhatCameInBeforeItWasOpened) {
    send({'o', 'l', 'd', 0x0A});
    ASSERT_EQ(receive(5), (Bytes{'o', 'l', 'd', '\r', '\n'})) << "the pty echoes what is there";
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    send({0x20, 0x40});
    EXPECT_EQ(read_from(*port, 2), (Bytes{0x20, 0x40}));
}

TEST_F(SerialPortTest, EchoesNothingOnceItIsOpen) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    const Bytes traps = terminal_traps();
    send(traps);
    ASSERT_EQ(read_from(*port, traps.size()), traps);
    EXPECT_TRUE(wire_is_silent());
}

TEST_F(SerialPortTest, ReadsEveryByteValueUnchanged) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    send(every_byte_value());
    EXPECT_EQ(read_from(*port, 256), every_byte_value());
}

TEST_F(SerialPortTest, ReadsWhatLooksLikeAParityMarkAsTheBytesThatItIs) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    const Bytes lookalike{0xFF, 0x00, 0x41, 0xFF, 0xFF, 0x00};
    send(lookalike);
    EXPECT_EQ(read_from(*port, lookalike.size()), lookalike);
}

TEST_F(SerialPortTest, ReadsMoreThanOneWakeOfDoubledBytesWithoutLoss) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    Bytes bytes(3 * kBytesPerRead + 1, 0xFF);
    bytes[1] = 0x0F;  // so that a doubled FF is cut by the end of each read
    send(bytes);
    EXPECT_EQ(read_from(*port, bytes.size()), bytes);
}

TEST_F(SerialPortTest, TellsAFullReadFromOneThatLeftNothing) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    send(Bytes(kBytesPerRead + 1, 0x0F));
    ASSERT_EQ(wait_for(port->descriptor(), kArrivalMilliseconds), POLLIN);
    Reception reception;
    port->read(reception);
    EXPECT_TRUE(reception.full);
    port->read(reception);
    EXPECT_FALSE(reception.full);
}

/// The kernel's terminal holds 4095 bytes, and further bytes that move up when these are read. It
/// keeps room for a parity mark of three.
TEST_F(SerialPortTest, ThrowsAwayAllThatWaitsAlsoWhatTheLineBufferHasNoRoomFor) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    for (int part = 0; part < 5; ++part) {
        send(Bytes(2048, 0x0F));
    }
    ASSERT_TRUE(test::seen_within([&] {
        int waiting = 0;
        return ::ioctl(port->descriptor(), FIONREAD, &waiting) == 0 && waiting > 4095 - 3;
    }));
    port->discard_unread();
    EXPECT_EQ(wait_for(port->descriptor(), kSilenceMilliseconds), 0);
    send(terminal_traps());
    EXPECT_EQ(read_from(*port, terminal_traps().size()), terminal_traps());
}

TEST_F(SerialPortTest, WritesInTwoStepsAsInOne) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    EXPECT_EQ(port->ask(), WriteStatus::written);
    EXPECT_EQ(port->write_asked(every_byte_value(), {}), WriteStatus::written);
    EXPECT_EQ(receive(256), every_byte_value());
}

TEST_F(SerialPortTest, WritesEveryByteValueUnchanged) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    EXPECT_EQ(port->write(every_byte_value()), WriteStatus::written);
    EXPECT_EQ(receive(256), every_byte_value());
}

TEST_F(SerialPortTest, HasNothingWhileNothingComes) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    Reception reception;
    reception.count = 5;
    EXPECT_EQ(port->read(reception), ReadStatus::nothing);
    EXPECT_EQ(reception.count, 0U);
}

TEST_F(SerialPortTest, ReadIsLostWhenTheOtherEndIsGone) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    wire_.reset();
    Reception reception;
    EXPECT_EQ(port->read(reception), ReadStatus::lost);
    EXPECT_EQ(port->read(reception), ReadStatus::lost);
}

TEST_F(SerialPortTest, WriteIsLostWhenTheOtherEndIsGone) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    wire_.reset();
    EXPECT_EQ(port->write(Bytes(25)), WriteStatus::lost);
    EXPECT_EQ(port->write(Bytes(25)), WriteStatus::lost);
}

/// Writes frames until one is refused. Returns their number, or nothing if none is ever refused.
std::optional<std::size_t> frames_until_busy(SerialPort& port, std::size_t frame_length) {
    constexpr std::size_t kMostBytes = 1 << 20;
    for (std::size_t frames = 0; frames * frame_length < kMostBytes; ++frames) {
        if (port.write(Bytes(frame_length, 0x0F)) == WriteStatus::busy) {
            return frames;
        }
    }
    return std::nullopt;
}

TEST_F(SerialPortTest, IsBusyAndDoesNotBlockWhenNobodyReads) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    EXPECT_TRUE(frames_until_busy(*port, 25).has_value());
}

TEST_F(SerialPortTest, ThrowsAwayMostOfWhatNobodyReadWhenItIsBusy) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    const auto frames = frames_until_busy(*port, 25);
    ASSERT_TRUE(frames.has_value());
    // The kernel's terminal holds 4095 bytes at the reader's end, which cannot be called back.
    constexpr std::size_t kReadersBuffer = 4096;
    ASSERT_GT(*frames * 25, 2 * kReadersBuffer);
    EXPECT_LT(receive_all().size(), kReadersBuffer);
}

TEST_F(SerialPortTest, WritesAgainOnceSomebodyReads) {
    const auto port = open_port();
    ASSERT_NE(port, nullptr);
    ASSERT_TRUE(frames_until_busy(*port, 25).has_value());
    const Bytes frame{0xC8, 0x01, 0x02};
    Bytes read;
    const auto read_more = [&] {
        const Bytes more = receive_all();
        read.insert(read.end(), more.begin(), more.end());
    };
    // A busy machine hands the bytes on so late that they come behind a silence.
    EXPECT_TRUE(test::seen_within([&] {
        read_more();
        return port->write(frame) == WriteStatus::written;
    }));
    EXPECT_TRUE(test::seen_within([&] {
        read_more();
        return std::ranges::search(read, frame).begin() != read.end();
    }));
}

TEST_F(SerialPortTest, ClosesAtOnceWithUnreadBytes) {
    auto port = open_port();
    ASSERT_NE(port, nullptr);
    ASSERT_TRUE(frames_until_busy(*port, 25).has_value());
    const Instant start = monotonic_now();
    port.reset();
    // The kernel would wait for half a minute until somebody reads.
    EXPECT_LT(monotonic_now() - start, std::chrono::seconds(15));
}

TEST_F(SerialPortTest, LastFrameBeforeTheEndStillGoesOut) {
    auto port = open_port();
    ASSERT_NE(port, nullptr);
    ASSERT_EQ(port->write(Bytes{0x0F, 0x0C}), WriteStatus::written);
    port.reset();
    EXPECT_EQ(receive(2), (Bytes{0x0F, 0x0C}));
}

TEST_F(SerialPortTest, RefusesADeviceThatIsOpenAlready) {
    const auto first = open_port();
    ASSERT_NE(first, nullptr);
    const auto second = SerialPort::open(device_, kSbusLine);
    ASSERT_FALSE(second.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, device_ + ": another program uses it", second.error());
    EXPECT_PRED_FORMAT2(IsSubstring, "fuser", second.error());
}

TEST_F(SerialPortTest, ARefusedSecondOpeningLeavesTheFirstAsItWas) {
    const auto first = open_port();
    ASSERT_NE(first, nullptr);
    send({0x20, 0x40});
    ASSERT_EQ(wait_for(first->descriptor(), kArrivalMilliseconds), POLLIN);
    ASSERT_FALSE(SerialPort::open(device_, LineSettings{}).has_value());
    EXPECT_EQ(read_from(*first, 2), (Bytes{0x20, 0x40}));
    struct termios2 line {};
    ASSERT_EQ(::ioctl(first->descriptor(), TCGETS2, &line), 0);
    EXPECT_EQ(line.c_ospeed, 100000U);
    int exclusive = 0;
    ASSERT_EQ(::ioctl(first->descriptor(), TIOCGEXCL, &exclusive), 0);
    EXPECT_EQ(exclusive, 1);
}

TEST_F(SerialPortTest, FreesTheDeviceForTheNextOne) {
    open_port().reset();
    const UniqueFd next(::open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    ASSERT_TRUE(next.valid());
    int exclusive = 1;
    ASSERT_EQ(::ioctl(next.get(), TIOCGEXCL, &exclusive), 0);
    EXPECT_EQ(exclusive, 0);
    EXPECT_NE(open_port(), nullptr);
}

/// Drops the rights of root during the object's lifetime.
class WithoutRoot {
  public:
    WithoutRoot() {
        constexpr uid_t kNobody = 65534;
        if (::geteuid() == 0 && ::seteuid(kNobody) != 0) {
            ADD_FAILURE() << "cannot change the user";
        }
    }
    WithoutRoot(const WithoutRoot&) = delete;
    WithoutRoot& operator=(const WithoutRoot&) = delete;
    ~WithoutRoot() {
        if (::seteuid(::getuid()) != 0) {
            std::abort();
        }
    }
};

TEST_F(SerialPortTest, WithoutPermissionItNamesTheGroup) {
    ASSERT_EQ(::chmod(device_.c_str(), 0), 0);
    const WithoutRoot without_root;
    const auto opened = SerialPort::open(device_, kSbusLine);
    ASSERT_FALSE(opened.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, device_ + ": no permission", opened.error());
    EXPECT_PRED_FORMAT2(IsSubstring, "dialout", opened.error());
}

TEST_F(SerialPortTest, RefusesADeviceThatAnotherProgramHasExclusively) {
    const UniqueFd other(::open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
    ASSERT_EQ(::ioctl(other.get(), TIOCEXCL), 0);
    ASSERT_EQ(::chmod(device_.c_str(), 0666), 0);
    const WithoutRoot without_root;
    const auto opened = SerialPort::open(device_, kSbusLine);
    ASSERT_FALSE(opened.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, device_ + ": another program uses it", opened.error());
}

TEST_F(SerialPortTest, RefusesAPtyWhoseOtherEndIsGone) {
    wire_.reset();
    const auto opened = SerialPort::open(device_, kSbusLine);
    ASSERT_FALSE(opened.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, device_ + ": ", opened.error());
}

std::string refusal(const std::string& device) {
    return error_of(SerialPort::open(device, kSbusLine));
}

TEST(SerialPortOpenTest, AMissingDeviceIsSaidToBeMissing) {
    EXPECT_PRED_FORMAT2(IsSubstring, "/dev/ttyNO0: there is no such device",
                        refusal("/dev/ttyNO0"));
    EXPECT_PRED_FORMAT2(IsSubstring, "/dev/serial/by-id", refusal("/dev/ttyNO0"));
}

TEST(SerialPortOpenTest, ARegularFileIsNoSerialDevice) {
    const std::string path = ::testing::TempDir() + "tribus-file-" + std::to_string(::getpid());
    const UniqueFd file(::open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0600));
    ASSERT_TRUE(file.valid());
    EXPECT_PRED_FORMAT2(IsSubstring, "not a serial device", refusal(path));
    ::unlink(path.c_str());
}

TEST(SerialPortOpenTest, AFolderIsNoSerialDevice) {
    EXPECT_PRED_FORMAT2(IsSubstring, "not a serial device", refusal("/"));
}

TEST(SerialPortOpenTest, ADeviceThatIsNoTerminalIsNoSerialDevice) {
    EXPECT_PRED_FORMAT2(IsSubstring, "/dev/null: this is not a serial device",
                        refusal("/dev/null"));
}

}  // namespace
}  // namespace tribus::serial_port_test
