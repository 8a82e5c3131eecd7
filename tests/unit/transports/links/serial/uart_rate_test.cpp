#include "transports/links/serial/uart_rate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

namespace tribus::uart_rate_test {
namespace {

using ::testing::IsSubstring;

constexpr std::uint32_t kTtyS0Minor = 64;
constexpr std::uint32_t kTtyUsbMajor = 188;
constexpr std::uint32_t kTtyAmaMajor = 204;
constexpr int k16550A = 4;
constexpr int kPl011 = 32;

LineSettings sbus_line(std::uint32_t baud = 100000) {
    return {.baud = baud, .parity = Parity::even, .stop_bits = 2, .inverted_wire = true};
}

/// Returns a port that accepts all settings and reports the requested rate.
PortFacts port(std::uint32_t device_major, std::uint32_t device_minor, std::uint32_t baud) {
    PortFacts facts;
    facts.device_major = device_major;
    facts.device_minor = device_minor;
    facts.asked = sbus_line(baud);
    facts.reported_baud = baud;
    return facts;
}

PortFacts port_16550(std::uint32_t baud_base, std::uint32_t baud) {
    PortFacts facts = port(4, kTtyS0Minor + 1, baud);
    facts.driver = SerialDriverFacts{.type = k16550A, .baud_base = baud_base};
    return facts;
}

PortFacts usb_adapter(std::uint32_t baud) {
    return port(kTtyUsbMajor, 0, baud);
}

PortFacts pty(std::uint32_t device_major, std::uint32_t baud) {
    return port(device_major, 5, baud);
}

// A PC's 16550 has baud_base 115200. It reports 100000 but runs at 115200, and reports 60000 but
// runs at 57600: docs/protocols/sbus.md, "Serial port: bit rate", confirmed by the emulator's
// trace.
TEST(UartRateTest, A16550RunsAtAWholeDivisorOfItsBaseWhateverItReports) {
    EXPECT_EQ(wire_baud(port_16550(115200, 100000)), 115200U);
    EXPECT_EQ(wire_baud(port_16550(115200, 60000)), 57600U);
    EXPECT_EQ(wire_baud(port_16550(115200, 115200)), 115200U);
}

// CRSF asks for 420000 baud. UARTs with a clock of 24 MHz, as on Allwinner boards, make 375000: the
// cause of "no data on my board" (docs/protocols/crsf.md, "Line").
TEST(UartRateTest, An8250At24MegahertzIsRefusedForCrsfWithTheRatesThatItMakes) {
    const PortFacts facts = port_16550(1'500'000, 420'000);
    EXPECT_EQ(wire_baud(facts), 375'000U);
    const auto refusal = port_refusal(facts);
    ASSERT_TRUE(refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "375000, 10.7 % off", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "nearest rates are 375000 and 500000", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "115200 works on nearly every one", *refusal);
    EXPECT_EQ(port_refusal(port_16550(1'500'000, 115'200)), std::nullopt);
}

TEST(UartRateTest, APcs16550IsRefusedForCrsf) {
    EXPECT_EQ(wire_baud(port_16550(921'600, 420'000)), 460'800U);
    EXPECT_TRUE(port_refusal(port_16550(921'600, 420'000)));
}

TEST(UartRateTest, A16550CannotExceedItsBase) {
    EXPECT_EQ(wire_baud(port_16550(115200, 200000)), 115200U);
}

TEST(UartRateTest, APc16550IsRefusedFor100000WithWhatItDoesInstead) {
    const auto refusal = port_refusal(port_16550(115200, 100000));
    ASSERT_TRUE(refusal.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, "asked for 100000 baud", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "runs at 115200, 15.2 % off", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "nearest rates are 57600 and 115200", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "FTDI FT232R", *refusal);
}

TEST(UartRateTest, APc16550IsRefusedFor200000) {
    const auto refusal = port_refusal(port_16550(115200, 200000));
    ASSERT_TRUE(refusal.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, "runs at 115200, 42.4 % off", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "cannot go faster", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "ttyAMA) does 100000 and 200000 baud", *refusal);
}

TEST(UartRateTest, TheFirstTtySIsJudgedByItsBaseToo) {
    PortFacts facts = port(4, kTtyS0Minor, 100000);
    facts.driver = SerialDriverFacts{.type = k16550A, .baud_base = 115200};
    EXPECT_EQ(wire_baud(facts), 115200U);
}

TEST(UartRateTest, ABaseOf0IsNoneAndABaseOf1IsOne) {
    EXPECT_EQ(wire_baud(port_16550(0, 100000)), 100000U);
    EXPECT_EQ(wire_baud(port_16550(1, 100000)), 1U);
}

TEST(UartRateTest, SaysHowFarARateIsOffInTenthsOfAPercent) {
    const auto refusal_of = [](std::uint32_t reported) {
        PortFacts facts = usb_adapter(100000);
        facts.reported_baud = reported;
        return port_refusal(facts).value_or("");
    };
    EXPECT_PRED_FORMAT2(IsSubstring, ", 15.2 % off", refusal_of(115249));
    EXPECT_PRED_FORMAT2(IsSubstring, ", 15.3 % off", refusal_of(115250));
    EXPECT_PRED_FORMAT2(IsSubstring, ", 100.1 % off", refusal_of(200100));
    EXPECT_PRED_FORMAT2(IsSubstring, ", 90.0 % off", refusal_of(10000));
}

TEST(UartRateTest, APc16550Serves115200) {
    EXPECT_EQ(port_refusal(port_16550(115200, 115200)), std::nullopt);
}

TEST(UartRateTest, AFastBaseClockServesBothSbusRates) {
    EXPECT_EQ(port_refusal(port_16550(24000000, 100000)), std::nullopt);
    EXPECT_EQ(port_refusal(port_16550(24000000, 200000)), std::nullopt);
}

/// Tries all whole divisors, to compare with the decision of the program.
bool some_divisor_is_near(std::uint32_t baud_base, std::uint32_t baud) {
    for (std::uint32_t divisor = 1; divisor <= baud_base / baud + 1; ++divisor) {
        const double rate = static_cast<double>(baud_base) / divisor;
        if (std::abs(rate - baud) <= 0.015 * baud) {
            return true;
        }
    }
    return false;
}

/// Returns whether a rate is so near the limit that rounding to a whole baud may decide.
bool on_the_limit(std::uint32_t baud_base, std::uint32_t baud) {
    for (std::uint32_t divisor = 1; divisor <= baud_base / baud + 1; ++divisor) {
        const double rate = static_cast<double>(baud_base) / divisor;
        if (std::abs(std::abs(rate - baud) - 0.015 * baud) <= 1) {
            return true;
        }
    }
    return false;
}

TEST(UartRateTest, A16550IsRefusedExactlyWhereNoDivisorIsNear) {
    for (const std::uint32_t baud_base : {115200U, 460800U, 1500000U}) {
        for (std::uint32_t baud = 9600; baud <= 250000; baud += 7) {
            if (on_the_limit(baud_base, baud)) {
                continue;
            }
            ASSERT_EQ(!port_refusal(port_16550(baud_base, baud)).has_value(),
                      some_divisor_is_near(baud_base, baud))
                << baud << " baud from " << baud_base;
        }
    }
}

TEST(UartRateTest, EveryRateThatIsAWholeDivisorIsServed) {
    for (std::uint32_t divisor = 1; divisor <= 0xFFFF; ++divisor) {
        const std::uint32_t baud = 24000000 / divisor;
        ASSERT_EQ(port_refusal(port_16550(24000000, baud)), std::nullopt) << baud;
    }
}

TEST(UartRateTest, APl011IsNeverJudgedByItsBase) {
    // baud_base 1500000 would give 375000 instead of 420000, but its divisor is fractional
    // (docs/protocols/sbus.md, "Serial port: bit rate").
    for (const std::uint32_t device_major : {4U, kTtyAmaMajor}) {
        PortFacts facts = port(device_major, kTtyS0Minor, 420000);
        facts.driver = SerialDriverFacts{.type = kPl011, .baud_base = 1500000};
        EXPECT_EQ(wire_baud(facts), 420000U);
        EXPECT_EQ(port_refusal(facts), std::nullopt);
    }
}

TEST(UartRateTest, AUsbAdapterIsBelievedWhateverItsBase) {
    PortFacts facts = usb_adapter(100000);
    facts.driver = SerialDriverFacts{.type = 0, .baud_base = 115200};
    EXPECT_EQ(port_refusal(facts), std::nullopt);
}

TEST(UartRateTest, ATtySThatTellsNoBaseIsBelieved) {
    EXPECT_EQ(port_refusal(port(4, kTtyS0Minor, 100000)), std::nullopt);
}

TEST(UartRateTest, AConsoleIsNoTtyS) {
    PortFacts facts = port(4, kTtyS0Minor - 1, 100000);
    facts.driver = SerialDriverFacts{.type = k16550A, .baud_base = 115200};
    EXPECT_EQ(wire_baud(facts), 100000U);
}

TEST(UartRateTest, AnAdapterThatReportsAnotherRateIsRefused) {
    // An old CP2102 changes 100000 to 115200: docs/protocols/sbus.md, "Serial port: bit rate".
    PortFacts facts = usb_adapter(100000);
    facts.reported_baud = 115200;
    const auto refusal = port_refusal(facts);
    ASSERT_TRUE(refusal.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, "runs at 115200, 15.2 % off", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "a CP2102", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "; that is the nearest rate that its driver can set; ",
                        *refusal);
}

TEST(UartRateTest, TheLimitIsOneAndAHalfPercentEitherWay) {
    for (std::uint32_t reported = 0; reported <= 200000; ++reported) {
        PortFacts facts = usb_adapter(100000);
        facts.reported_baud = reported;
        const bool near = reported >= 98500 && reported <= 101500;
        ASSERT_EQ(!port_refusal(facts).has_value(), near) << reported;
    }
}

TEST(UartRateTest, ADriverThatChangesNothingIsRefused) {
    // A UML ttyS takes the settings and stays at 38400 8N1: docs/protocols/sbus.md, "Serial port:
    // bit rate".
    PortFacts facts = port(4, kTtyS0Minor, 100000);
    facts.reported_baud = 38400;
    facts.parity_kept = false;
    facts.stop_bits_kept = false;
    EXPECT_TRUE(port_refusal(facts).has_value());
}

TEST(UartRateTest, ALostParityIsRefusedOnAUartAndNamesTheMiniUart) {
    // A Raspberry Pi's mini UART takes 8E2 and clears PARENB: docs/protocols/sbus.md, "Serial port:
    // parity".
    PortFacts facts = port(4, kTtyS0Minor + 1, 100000);
    facts.driver = SerialDriverFacts{.type = k16550A, .baud_base = 31250000};
    facts.parity_kept = false;
    const auto refusal = port_refusal(facts);
    ASSERT_TRUE(refusal.has_value());
    EXPECT_PRED_FORMAT2(IsSubstring, "drops the parity bit", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "mini UART", *refusal);
    EXPECT_PRED_FORMAT2(IsSubstring, "ttyAMA", *refusal);
}

TEST(UartRateTest, AParityBitThatNobodyAskedForIsRefused) {
    PortFacts facts = usb_adapter(115200);
    facts.asked = LineSettings{};
    facts.parity_kept = false;
    EXPECT_PRED_FORMAT2(IsSubstring, "asked for no parity bit", port_refusal(facts).value_or(""));
}

TEST(UartRateTest, LostStopBitsAreRefusedOnAUart) {
    PortFacts facts = usb_adapter(100000);
    facts.stop_bits_kept = false;
    EXPECT_PRED_FORMAT2(IsSubstring, "2 stop bits", port_refusal(facts).value_or(""));
}

TEST(UartRateTest, AnotherCharacterSizeIsRefusedOnAUart) {
    PortFacts facts = usb_adapter(100000);
    facts.data_bits_kept = false;
    EXPECT_PRED_FORMAT2(IsSubstring, "8 data bits", port_refusal(facts).value_or(""));
}

TEST(UartRateTest, APtyMayDropParityOnAnyOfItsMajors) {
    for (std::uint32_t device_major = 0; device_major < 512; ++device_major) {
        PortFacts facts = pty(device_major, 100000);
        facts.parity_kept = false;
        const bool is_pty = device_major >= 136 && device_major <= 143;
        ASSERT_EQ(!port_refusal(facts).has_value(), is_pty) << "major " << device_major;
    }
}

TEST(UartRateTest, ZeroBaudIsRefusedAndNotDividedBy) {
    EXPECT_TRUE(port_refusal(port_16550(115200, 0)).has_value());
    EXPECT_TRUE(port_refusal(usb_adapter(0)).has_value());
}

TEST(UartRateTest, ExtremeRatesAreJudgedWithoutOverflow) {
    EXPECT_EQ(wire_baud(port_16550(UINT32_MAX, UINT32_MAX)), UINT32_MAX);
    EXPECT_TRUE(port_refusal(port_16550(115200, UINT32_MAX)).has_value());
    EXPECT_EQ(port_refusal(usb_adapter(UINT32_MAX)), std::nullopt);
}

}  // namespace
}  // namespace tribus::uart_rate_test
