#include <cerrno>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/uart_stand_in.h"
#include "transports/links/serial/serial_port.h"

/// How a serial port reads from and writes to a UART, with a stand-in for its driver.
namespace tribus::test::serial_uart_bytes_test {
namespace {

using Bytes = std::vector<std::uint8_t>;

class BytesOfASerialUart : public SerialUart {};

/// The result of a read.
struct Read {
    ReadStatus status;
    Bytes bytes;
    bool full;
    std::string damaged;

    bool operator==(const Read&) const = default;
};

Read read_of(SerialPort& port) {
    Reception reception;
    reception.count = 9;
    reception.full = true;
    reception.damaged.set();
    const ReadStatus status = port.read(reception);
    std::string damaged;
    for (std::size_t i = 0; i < reception.count; ++i) {
        damaged += reception.damaged.test(i) ? 'x' : '.';
    }
    return {status, Bytes(reception.view().begin(), reception.view().end()), reception.full,
            damaged};
}

TEST_F(BytesOfASerialUart, GivesASingleByte) {
    Uart uart(device_);
    const auto port = opened();
    uart.arrived = {{0x0F}};
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::received, {0x0F}, false, "."}));
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::nothing, {}, false, ""}));
}

TEST_F(BytesOfASerialUart, MarksABadByteWhoseMarkCameInTwoReads) {
    Uart uart(device_);
    const auto port = opened();
    uart.arrived = {{0xFF, 0x00}, {0x41, 0x42}};
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::nothing, {}, false, ""}));
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::received, {0x41, 0x42}, false, "x."}));
}

TEST_F(BytesOfASerialUart, ForgetsHalfAMarkWithWhatIsDiscarded) {
    Uart uart(device_);
    const auto port = opened();
    uart.flushed.clear();
    uart.arrived = {{0xFF, 0x00}, {0x41}};
    read_of(*port);
    port->discard_unread();
    EXPECT_EQ(uart.flushed, std::vector<int>{TCIFLUSH});
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::received, {0x41}, false, "."}));
}

TEST_F(BytesOfASerialUart, TriesAReadThatASignalInterruptsThreeTimes) {
    Uart uart(device_);
    const auto port = opened();
    uart.arrived = {{}, {}, {0x0F}};
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::received, {0x0F}, false, "."}));
    uart.arrived = {{}, {}, {}, {0x0F}};
    uart.reads = 0;
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::nothing, {}, true, ""})) << "more may be waiting";
    EXPECT_EQ(uart.reads, 3);
}

TEST_F(BytesOfASerialUart, StaysLostAfterAHangUpOrAnError) {
    for (const int failure : {0, EIO, ENODEV, EINVAL}) {
        Uart uart(device_);
        const auto port = opened();
        uart.read_failure = failure;
        errno = EAGAIN;
        EXPECT_EQ(read_of(*port), (Read{ReadStatus::lost, {}, false, ""})) << failure;
        EXPECT_EQ(uart.reads, 1);
        uart.arrived = {{0x0F}};
        EXPECT_EQ(read_of(*port), (Read{ReadStatus::lost, {}, false, ""})) << failure;
        EXPECT_EQ(port->write(Bytes{1}), WriteStatus::lost);
        EXPECT_EQ(uart.writes, 0);
    }
}

TEST_F(BytesOfASerialUart, TellsWhetherBytesWait) {
    Uart uart(device_);
    const auto port = opened();
    EXPECT_FALSE(port->has_unread());
    uart.unread = 1;
    EXPECT_TRUE(port->has_unread());
    uart.unread_failure = EIO;
    EXPECT_FALSE(port->has_unread());
}

TEST_F(BytesOfASerialUart, IsBusyUntilTheLastByteIsSent) {
    Uart uart(device_);
    const auto port = opened();
    uart.queue = {1, 0};
    EXPECT_EQ(port->write(Bytes{1}), WriteStatus::busy);
    EXPECT_EQ(uart.writes, 0);
    EXPECT_EQ(port->write(Bytes{1}), WriteStatus::written);
}

TEST_F(BytesOfASerialUart, IsWrittenToWhereItsDriverGivesNoCount) {
    Uart uart(device_);
    const auto port = opened();
    uart.queue = {7};
    uart.queue_failure = EINVAL;
    EXPECT_EQ(port->write(Bytes{1}), WriteStatus::written);
}

TEST_F(BytesOfASerialUart, IsLostForGoodWhereTheQuestionForItsQueueSaysSo) {
    Uart uart(device_);
    const auto port = opened();
    uart.queue_failure = EIO;
    EXPECT_EQ(port->ask(), WriteStatus::lost);
    uart.queue_failure = 0;
    EXPECT_EQ(port->ask(), WriteStatus::lost);
    EXPECT_EQ(read_of(*port), (Read{ReadStatus::lost, {}, false, ""}));
}

TEST_F(BytesOfASerialUart, IsNotLostByAnErrorOfAnotherCall) {
    Uart uart(device_);
    const auto port = opened();
    errno = EIO;
    EXPECT_EQ(port->ask(), WriteStatus::written);
    EXPECT_EQ(port->write_asked({}, {}), WriteStatus::written);
    errno = EINTR;
    EXPECT_EQ(port->write_asked({}, {}), WriteStatus::written);
}

TEST_F(BytesOfASerialUart, IsLostForGoodWhereAWriteSaysSo) {
    Uart uart(device_);
    const auto port = opened();
    uart.write_failure = ENODEV;
    EXPECT_EQ(port->write_asked(Bytes{1}, {}), WriteStatus::lost);
    uart.write_failure = 0;
    EXPECT_EQ(port->ask(), WriteStatus::lost);
}

TEST_F(BytesOfASerialUart, DiscardsAFrameThatWasTakenInPart) {
    Uart uart(device_);
    const auto port = opened();
    uart.flushed.clear();
    uart.missing = 1;
    EXPECT_EQ(port->write_asked(Bytes{1, 2}, {}), WriteStatus::busy);
    EXPECT_EQ(uart.flushed, std::vector<int>{TCOFLUSH});
    uart.write_failure = EAGAIN;
    EXPECT_EQ(port->write_asked(Bytes{1, 2}, {}), WriteStatus::busy);
    EXPECT_EQ(uart.flushed, (std::vector<int>{TCOFLUSH, TCOFLUSH}));
}

TEST_F(BytesOfASerialUart, DoesNotRepeatAWriteThatASignalInterrupts) {
    Uart uart(device_);
    const auto port = opened();
    uart.flushed.clear();
    uart.write_failure = EINTR;
    EXPECT_EQ(port->write_asked(Bytes{1, 2}, {}), WriteStatus::busy);
    EXPECT_EQ(uart.writes, 1);
    EXPECT_TRUE(uart.flushed.empty());
}

TEST_F(BytesOfASerialUart, WakesAtEachArrival) {
    const Uart uart(device_);
    EXPECT_TRUE(opened()->wakes_at_each_arrival());
}

}  // namespace
}  // namespace tribus::test::serial_uart_bytes_test
