#include "tests/reference/plain_uart.h"

namespace tribus::test {

std::vector<UartByte> PlainUart::read(const std::function<bool(double us)>& level, double from_us,
                                      double to_us) const {
    const double sample_us = 1e6 / baud / 16 / (1 + rate_error);
    const auto mark = [&](double at) { return level(at) != inverted; };
    const auto bit_at = [&](double start, int bit) {
        int marks = 0;
        for (const int sample : {7, 8, 9}) {
            marks += mark(start + (16 * bit + sample) * sample_us) ? 1 : 0;
        }
        return marks >= 2;
    };
    std::vector<UartByte> bytes;
    bool before = true;
    for (double at = from_us; at < to_us; at += sample_us) {
        const bool now = mark(at);
        const bool falls = before && !now;
        before = now;
        if (!falls || bit_at(at, 0)) {
            continue;
        }
        UartByte byte;
        int ones = 0;
        for (int bit = 0; bit < 8; ++bit) {
            const bool one = bit_at(at, 1 + bit);
            ones += one ? 1 : 0;
            byte.value = static_cast<std::uint8_t>(byte.value | (one ? 1 << bit : 0));
        }
        int next = 9;
        if (even_parity) {
            ones += bit_at(at, next++) ? 1 : 0;
            byte.parity_error = ones % 2 != 0;
        }
        byte.framing_error = !bit_at(at, next);
        bytes.push_back(byte);
        // It looks for the next start in the middle of the first stop bit.
        at += (16 * next + 9) * sample_us;
        before = mark(at);
    }
    return bytes;
}

}  // namespace tribus::test
