#include "transports/links/twins/faulty_link.h"

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

std::uint8_t random_bit(FaultRandom& random) {
    return static_cast<std::uint8_t>(1U << (random.next() % 8));
}

}  // namespace

std::uint64_t FaultRandom::next() {
    // SplitMix64 (Steele, Lea, Flood 2014): one word of state, any seed works.
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t mixed = state_;
    mixed = (mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9U;
    mixed = (mixed ^ (mixed >> 27)) * 0x94D049BB133111EBU;
    return mixed ^ (mixed >> 31);
}

bool FaultRandom::happens(double probability) {
    // The upper 53 bits as a fraction: exact in a double, so equal on every machine.
    constexpr double kFraction = 1.0 / 9007199254740992.0;
    return static_cast<double>(next() >> 11) * kFraction < probability;
}

Duration FaultRandom::delay(Duration most) {
    if (most <= Duration::zero()) {
        return Duration::zero();
    }
    const auto choices = static_cast<std::uint64_t>(most.count()) + 1;
    return Duration(static_cast<std::int64_t>(next() % choices));
}

void FaultInjector::apply(std::span<const std::uint8_t> in, Reception& out) {
    const Part part = cut(in.size());
    for (std::size_t i = part.begin; i < part.end; ++i) {
        apply_byte(in[i], false, out);
    }
}

void FaultInjector::apply(const Reception& in, Reception& out) {
    const Part part = cut(in.count);
    for (std::size_t i = part.begin; i < part.end; ++i) {
        apply_byte(in.bytes[i], in.damaged.test(i), out);
    }
}

/// A fault that is off draws no random number, so the other faults stay the same.
FaultInjector::Part FaultInjector::cut(std::size_t count) {
    still_to_lose_ = 0;
    if (settings_.cut_frame == 0 || !random_.happens(settings_.cut_frame) || count == 0) {
        return {0, count};
    }
    const bool head = random_.next() % 2 == 0;
    const auto at = static_cast<std::size_t>(random_.next() % count);
    return head ? Part{at, count} : Part{0, at};
}

unsigned FaultInjector::in_a_row() {
    return settings_.most_in_a_row <= 1
               ? 1
               : 1 + static_cast<unsigned>(random_.next() % settings_.most_in_a_row);
}

void FaultInjector::apply_byte(std::uint8_t byte, bool damaged, Reception& out) {
    if (random_.happens(settings_.add_byte)) {
        for (unsigned left = in_a_row(); left > 0; --left) {
            append(static_cast<std::uint8_t>(random_.next()), false, out);
        }
    }
    if (still_to_lose_ > 0) {
        --still_to_lose_;
        return;
    }
    if (random_.happens(settings_.lose_byte)) {
        still_to_lose_ = in_a_row() - 1;
        return;
    }
    std::uint8_t wire = byte;
    if (random_.happens(settings_.flip_bit)) {
        wire ^= random_bit(random_);
    }
    if (random_.happens(settings_.damage_byte)) {
        append(wire ^ random_bit(random_), true, out);
        return;
    }
    append(wire, damaged, out);
}

void CanFaultInjector::apply(const ReceivedCanFrame& in, CanReception& out) {
    if (random_.happens(settings_.lose_frame)) {
        return;
    }
    const int copies = random_.happens(settings_.duplicate_frame) ? 2 : 1;
    for (int copy = 0; copy < copies && out.count < out.frames.size(); ++copy) {
        ReceivedCanFrame& wire = out.frames[out.count];
        wire = in;
        if (wire.frame.length > 0 && random_.happens(settings_.flip_bit)) {
            const auto place = static_cast<std::size_t>(random_.next() % wire.frame.length);
            wire.frame.data[place] ^= random_bit(random_);
        }
        if (random_.happens(settings_.late_frame)) {
            wire.at += random_.delay(settings_.most_delay);
        }
        ++out.count;
    }
}

ReadStatus FaultyLink::read(Reception& reception) {
    Reception received;
    const ReadStatus status = link_.read(received);
    reception.count = 0;
    reception.damaged.reset();
    reception.full = received.full;
    if (status != ReadStatus::received) {
        return status;
    }
    if (!injector_.drop_frame()) {
        injector_.apply(received, reception);
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
