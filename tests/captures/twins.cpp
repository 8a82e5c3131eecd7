#include "tests/captures/twins.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <utility>
#include <vector>

#include "tests/captures/receivers.h"
#include "tests/loopback/wire.h"
#include "tests/support/ibus_checksum.h"

namespace tribus::test {
namespace {

using std::chrono::nanoseconds;

struct SentBurst {
    nanoseconds at{};
    Bytes bytes;
};

/// A number without a visible pattern, the same each time.
unsigned scattered(std::size_t number) {
    return (static_cast<unsigned>(number) + 1U) * 2'654'435'761U >> 16U;
}

nanoseconds start_of(const Rhythm& rhythm, std::size_t period) {
    const nanoseconds place = rhythm.first + period * rhythm.period;
    if (period % rhythm.one_in != rhythm.one_in - 1) {
        return place;
    }
    const auto span = (rhythm.early + rhythm.late) / std::chrono::microseconds(1) + 1;
    return place - rhythm.early +
           std::chrono::microseconds(scattered(period) % static_cast<unsigned>(span));
}

int position(const Course& course, std::size_t frame) {
    const auto& points = course.points;
    const auto next =
        std::ranges::find_if(points, [frame](const Reached& point) { return point.frame > frame; });
    if (next == points.begin() || next == points.end()) {
        return next == points.begin() ? next->us : points.back().us;
    }
    const Reached& before = *std::prev(next);
    const double share =
        static_cast<double>(frame - before.frame) / static_cast<double>(next->frame - before.frame);
    return before.us + static_cast<int>(std::lround(share * (next->us - before.us)));
}

Sticks sticks_of(const ServoFrames& wire, std::size_t frame) {
    Sticks sticks = wire.channels;
    for (const Course& course : wire.moves) {
        sticks[course.channel - 1] = position(course, frame);
    }
    return sticks;
}

std::vector<SentBurst> sent(const ServoFrames& wire, const Rhythm& rhythm) {
    std::vector<SentBurst> bursts;
    if (wire.cut_first_bytes > 0) {
        const Bytes whole = ibus_bytes(sticks_of(wire, 0));
        bursts.push_back(
            {wire.cut_first_at,
             Bytes(whole.end() - static_cast<std::ptrdiff_t>(wire.cut_first_bytes), whole.end())});
        Bytes& tail = bursts.back().bytes;
        tail.front() = wire.torn_byte.value_or(tail.front());
    }
    for (std::size_t frame = 0; frame < rhythm.periods; ++frame) {
        bursts.push_back({start_of(rhythm, frame), ibus_bytes(sticks_of(wire, frame))});
    }
    return bursts;
}

std::vector<SentBurst> sent(const Sbus2Frames& wire, const Rhythm& rhythm) {
    SbusSight sight;
    std::ranges::copy(wire.raw, sight.raw.begin());
    std::vector<SentBurst> bursts;
    std::size_t slots = 0;
    for (std::size_t frame = 0; frame < rhythm.periods; ++frame) {
        const nanoseconds start = start_of(rhythm, frame);
        bursts.push_back({start, sbus_bytes(sight)});
        bursts.back().bytes.back() = wire.footers[frame % wire.footers.size()];
        if (frame % wire.footers.size() == 0) {
            bursts.push_back({start + wire.slot_after, wire.slots[slots % wire.slots.size()]});
            ++slots;
        }
    }
    return bursts;
}

Bytes request(unsigned kind, unsigned address) {
    return with_ibus_checksum({4, static_cast<std::uint8_t>(kind << 4U | address)});
}

Bytes answer(const WiredSensor& sensor, std::size_t exchange) {
    std::uint16_t raw = 0;
    for (const Measured& measured : sensor.values) {
        raw = measured.exchange <= exchange ? measured.raw : raw;
    }
    return with_ibus_checksum({6, static_cast<std::uint8_t>(0xA0U | sensor.address),
                               static_cast<std::uint8_t>(raw & 0xFFU),
                               static_cast<std::uint8_t>(raw >> 8U)});
}

std::vector<SentBurst> sent(const SensorExchanges& wire, const Rhythm& rhythm) {
    constexpr unsigned kProbe = 8;
    constexpr unsigned kValue = 0xA;
    const unsigned next_free = wire.sensors.back().address + 1U;
    const auto answer_range = static_cast<unsigned>(
        (wire.answer_most - wire.answer_least) / std::chrono::microseconds(1) + 1);
    std::vector<SentBurst> bursts;
    std::size_t asked = wire.first_sensor;
    for (std::size_t exchange = 0; exchange < rhythm.periods; ++exchange) {
        const nanoseconds start = start_of(rhythm, exchange);
        if (exchange >= wire.first_probe && (exchange - wire.first_probe) % wire.probe_each == 0) {
            bursts.push_back({start, request(kProbe, next_free)});
            asked = 0;
            continue;
        }
        const WiredSensor& sensor = wire.sensors[asked];
        bursts.push_back({start, request(kValue, sensor.address)});
        if (std::ranges::find(wire.missed, exchange) != wire.missed.end()) {
            continue;
        }
        if (!sensor.values.empty()) {
            const std::chrono::microseconds more(scattered(exchange) % answer_range);
            bursts.push_back({start + wire.answer_least + more, answer(sensor, exchange)});
        }
        asked = (asked + 1) % wire.sensors.size();
    }
    if (wire.cut_last_bytes > 0) {
        bursts.pop_back();
        bursts.back().bytes.resize(wire.cut_last_bytes);
    }
    return bursts;
}

std::vector<SentBurst> sent(const Receiver& receiver) {
    return std::visit([&](const auto& wire) { return sent(wire, receiver.rhythm); }, receiver.wire);
}

std::string timed(const Receiver& receiver, const Wear& wear) {
    std::ostringstream text;
    text << "# t_us  bytes   (twin of " << receiver.name << ", made from its figures)" << std::hex
         << std::setfill('0');
    std::size_t count = 0;
    for (const SentBurst& burst : sent(receiver)) {
        bool begins = true;
        nanoseconds at = burst.at;
        for (const std::uint8_t byte : burst.bytes) {
            if (begins) {
                text << "\n"
                     << std::dec << std::chrono::round<std::chrono::microseconds>(at).count()
                     << std::hex;
            }
            ++count;
            text << " " << std::setw(2) << unsigned{byte}
                 << (wear.damage_each > 0 && count % wear.damage_each == 0 ? "!" : "");
            begins = wear.split_each > 0 && count % wear.split_each == 0;
            at += receiver.byte_distance;
        }
    }
    text << "\n";
    return text.str();
}

std::string analysers_export(const Receiver& receiver) {
    std::ostringstream text;
    text << "Time [s],Value,Parity Error,Framing Error\n" << std::fixed << std::setfill('0');
    for (const SentBurst& burst : sent(receiver)) {
        nanoseconds at = burst.at;
        for (const std::uint8_t byte : burst.bytes) {
            text << std::setprecision(9) << std::chrono::duration<double>(at).count() << ",0x"
                 << std::hex << std::uppercase << std::setw(2) << unsigned{byte} << ",,\n";
            at += receiver.byte_distance;
        }
    }
    return text.str();
}

std::string channel_table(const Receiver& receiver) {
    const auto& wire = std::get<ServoFrames>(receiver.wire);
    std::ostringstream text;
    for (std::size_t channel = 1; channel <= wire.channels.size(); ++channel) {
        text << (channel > 1 ? "," : "") << "ch" << channel;
    }
    for (std::size_t frame = 0; frame < receiver.rhythm.periods; ++frame) {
        text << "\n";
        const char* separator = "";
        for (const int us : sticks_of(wire, frame)) {
            text << std::exchange(separator, ",") << us;
        }
    }
    text << "\n";
    return text.str();
}

}  // namespace

std::string twin_file(std::string_view file, const Wear& wear) {
    const std::size_t dot = file.find('.');
    const auto receiver = std::ranges::find(receivers(), file.substr(0, dot), &Receiver::name);
    if (receiver == receivers().end()) {
        return {};
    }
    const std::string_view ending = dot == std::string_view::npos ? "" : file.substr(dot);
    if (std::ranges::find(receiver->endings, ending) == receiver->endings.end()) {
        return {};
    }
    if (ending == ".saleae.csv") {
        return analysers_export(*receiver);
    }
    return ending == ".channels.csv" ? channel_table(*receiver) : timed(*receiver, wear);
}

}  // namespace tribus::test
