#include "tests/support/uart_wire.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace tribus::test {
namespace {

std::optional<Duration> after_break(const Wire& wire, Duration from) {
    const auto rise = wire.next_rise(from);
    return rise ? wire.next_fall(*rise) : std::nullopt;
}

}  // namespace

void Wire::send(Duration start, std::span<const std::uint8_t> bytes, unsigned pause_bits) {
    const LineSettings& line = sender_.line;
    const Duration begin = std::max(start, end_);
    std::uint64_t bit = 0;
    for (const std::uint8_t byte : bytes) {
        const auto put = [&](bool mark) { level(begin + line.bits_time(bit++), mark); };
        put(false);
        for (unsigned data = 0; data < 8; ++data) {
            put((byte >> data & 1U) != 0);
        }
        if (line.parity == Parity::even) {
            put((std::popcount(byte) % 2 != 0) != sender_.odd_parity);
        }
        put(true);
        bit += line.stop_bits - 1U + pause_bits;
    }
    end_ = begin + line.bits_time(bit);
}

bool Wire::high_at(Duration time) const {
    if (at_ > 0 && changes_[at_ - 1].at > time) {
        at_ = 0;
    }
    while (at_ < changes_.size() && changes_[at_].at <= time) {
        ++at_;
    }
    return at_ == 0 ? !sender_.inverted : changes_[at_ - 1].high;
}

void Wire::level(Duration at, bool mark) {
    const bool high = mark != sender_.inverted;
    if (high != high_) {
        changes_.push_back({at, high});
        high_ = high;
    }
}

std::optional<Duration> Wire::next(Duration time, bool high) const {
    high_at(time - Duration(1));
    std::size_t at = at_;
    while (at < changes_.size() && changes_[at].high != high) {
        ++at;
    }
    return at == changes_.size() ? std::nullopt : std::optional(changes_[at].at);
}

std::vector<Burst> UartEar::listen(const Wire& wire) {
    auto start = wire.high_at(Duration::zero()) ? wire.next_fall(Duration::zero())
                                                : after_break(wire, Duration::zero());
    while (start) {
        start = take(wire, *start);
    }
    return std::exchange(heard_, {});
}

std::optional<Duration> UartEar::take(const Wire& wire, Duration start) {
    const auto sample = [&](std::uint64_t bit) {
        return wire.high_at(start + line_.bits_time(2 * bit + 1) / 2);
    };
    unsigned value = 0;
    for (unsigned data = 0; data < 8; ++data) {
        value |= (sample(1 + data) ? 1U : 0U) << data;
    }
    std::uint64_t bit = 9;
    bool damaged = false;
    bool silent = value == 0;
    if (line_.parity == Parity::even) {
        const bool parity = sample(bit++);
        damaged = parity != (std::popcount(value) % 2 != 0);
        silent = silent && !parity;
    }
    const bool stop = sample(bit);
    const Duration stop_at = start + line_.bits_time(2 * bit + 1) / 2;
    heard_.push_back({.start = stop_at,
                      .bytes = {static_cast<std::uint8_t>(value)},
                      .damaged = {damaged || !stop}});
    if (stop) {
        return wire.next_fall(stop_at);
    }
    if (silent || kind_ == UartKind::waits_for_idle) {
        return after_break(wire, stop_at);
    }
    return start + line_.bits_time(bit);
}

std::vector<Burst> in_lumps(std::span<const Burst> bytes, Duration step) {
    std::vector<Burst> lumps;
    for (const Burst& byte : bytes) {
        const Duration at = (*byte.start / step + 1) * step;
        if (lumps.empty() || *lumps.back().start != at) {
            lumps.push_back({.start = at, .bytes = {}, .damaged = {}});
        }
        lumps.back().bytes.push_back(byte.bytes[0]);
        lumps.back().damaged.push_back(byte.damaged[0]);
    }
    return lumps;
}

}  // namespace tribus::test
