#include "transports/links/faulty_link.h"

#include <cstddef>

namespace tribus {

namespace {

void append(std::uint8_t byte, bool damaged, Reception& out) {
    if (out.count == out.bytes.size()) {
        return;
    }
    out.bytes[out.count] = byte;
    out.damaged.set(out.count, damaged);
    ++out.count;
}

}  // namespace

void FaultInjector::apply(std::span<const std::uint8_t> in, Reception& out) {
    for (const std::uint8_t byte : in) {
        apply_byte(byte, false, out);
    }
}

void FaultInjector::apply(const Reception& in, Reception& out) {
    for (std::size_t i = 0; i < in.count; ++i) {
        apply_byte(in.bytes[i], in.damaged.test(i), out);
    }
}

Duration FaultInjector::next_delay() {
    if (settings_.most_delay <= Duration::zero()) {
        return Duration::zero();
    }
    const auto choices = static_cast<std::uint64_t>(settings_.most_delay.count()) + 1;
    return Duration(static_cast<std::int64_t>(next() % choices));
}

void FaultInjector::apply_byte(std::uint8_t byte, bool damaged, Reception& out) {
    if (happens(settings_.add_byte)) {
        append(static_cast<std::uint8_t>(next()), false, out);
    }
    if (happens(settings_.lose_byte)) {
        return;
    }
    std::uint8_t wire = byte;
    if (happens(settings_.flip_bit)) {
        wire ^= random_bit();
    }
    if (happens(settings_.damage_byte)) {
        append(wire ^ random_bit(), true, out);
        return;
    }
    append(wire, damaged, out);
}

std::uint8_t FaultInjector::random_bit() {
    return static_cast<std::uint8_t>(1U << (next() % 8));
}

bool FaultInjector::happens(double probability) {
    // The upper 53 bits as a fraction: exact in a double, so equal on every machine.
    constexpr double kFraction = 1.0 / 9007199254740992.0;
    return static_cast<double>(next() >> 11) * kFraction < probability;
}

std::uint64_t FaultInjector::next() {
    // SplitMix64 (Steele, Lea, Flood 2014): one word of state, any seed is good.
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBU;
    return mixed ^ (mixed >> 31);
}

ReadStatus FaultyLink::read(Reception& reception) {
    Reception sound;
    const ReadStatus status = link_.read(sound);
    reception.count = 0;
    reception.damaged.reset();
    if (status != ReadStatus::received) {
        return status;
    }
    if (!injector_.drop_frame()) {
        injector_.apply(sound, reception);
    }
    return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
}

WriteStatus FaultyLink::write(std::span<const std::uint8_t> frame) {
    if (injector_.drop_frame()) {
        return WriteStatus::written;
    }
    Reception wire;
    injector_.apply(frame, wire);
    return wire.count > 0 ? link_.write(wire.view()) : WriteStatus::written;
}

}  // namespace tribus
