#include "tests/loopback/sensor_bus.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <initializer_list>
#include <utility>

#include "tests/support/ibus_checksum.h"

namespace tribus::test {
namespace {

constexpr std::chrono::microseconds kSlot{7700};
/// Time within which a thread notices that it must end.
constexpr std::chrono::milliseconds kIdle{10};
constexpr std::size_t kShortest = 4;
constexpr std::size_t kLongest = 18;
constexpr unsigned kDiscover = 0x80;
constexpr unsigned kType = 0x90;
constexpr unsigned kValue = 0xA0;

void add_word(Bytes& bytes, unsigned word) {
    bytes.push_back(static_cast<std::uint8_t>(word & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(word >> 8U & 0xFFU));
}

void append(Bytes& bytes, const Bytes& more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
}

void wait_readable(std::initializer_list<int> descriptors, std::chrono::nanoseconds most) {
    std::vector<pollfd> ready;
    for (const int descriptor : descriptors) {
        ready.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
    }
    const auto rest = std::max(most, std::chrono::nanoseconds(0));
    const timespec wait{.tv_sec = rest.count() / 1'000'000'000,
                        .tv_nsec = static_cast<long>(rest.count() % 1'000'000'000)};
    ::ppoll(ready.data(), ready.size(), &wait, nullptr);
    if (std::ranges::any_of(ready, [](const pollfd& one) { return one.revents == POLLHUP; })) {
        // Nobody has the device open, so the wait returns at once.
        const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
        ::nanosleep(&pause, nullptr);
    }
}

}  // namespace

Bytes sensor_frame(unsigned command_and_address, const Bytes& data) {
    Bytes frame;
    frame.reserve(kLongest);
    frame.push_back(static_cast<std::uint8_t>(kShortest + data.size()));
    frame.push_back(static_cast<std::uint8_t>(command_and_address));
    append(frame, data);
    return with_ibus_checksum(frame);
}

Bytes value_reply(unsigned address, int raw) {
    Bytes data;
    add_word(data, static_cast<unsigned>(raw));
    return sensor_frame(kValue | address, data);
}

std::vector<Bytes> cut_sensor_frames(Bytes& bytes, std::size_t& strays) {
    std::vector<Bytes> frames;
    std::size_t start = 0;
    while (bytes.size() - start >= kShortest) {
        const std::size_t length = bytes[start];
        const bool possible = length >= kShortest && length <= kLongest;
        if (possible && bytes.size() - start < length) {
            break;
        }
        const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(start);
        const auto end = at + static_cast<std::ptrdiff_t>(possible ? length : 1);
        const Bytes frame(at, end);
        if (possible && frame == sensor_frame(frame[1], Bytes(at + 2, end - 2))) {
            frames.push_back(frame);
            start += length;
        } else {
            ++strays;
            ++start;
        }
    }
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(start));
    return frames;
}

Asker::Asker(FarEnd& wire, FarWires wires)
    : port_{.send = [&wire](const Bytes& bytes) { wire.send(bytes); },
            .receive = [&wire] { return wire.receive(); }},
      wires_(wires),
      slot_(kSlot) {}

/// Waits a little for a frame. Returns whether one came.
bool Asker::listen() {
    const timespec pause{.tv_sec = 0, .tv_nsec = 100'000};
    ::nanosleep(&pause, nullptr);
    const Bytes more = port_.receive();
    if (wires_ == FarWires::one && !more.empty()) {
        port_.send(more);
    }
    append(pending_, more);
    const auto frames = cut_sensor_frames(pending_, strays_);
    frames_.insert(frames_.end(), frames.begin(), frames.end());
    return !frames.empty();
}

Bytes Asker::ask(unsigned command_and_address) {
    do {
        listen();
    } while (Clock::now() < slot_end_);
    slot_end_ = Clock::now() + slot_;
    Bytes sent = before_;
    append(sent, sensor_frame(command_and_address));
    port_.send(sent);
    ++requests_;
    while (Clock::now() < slot_end_) {
        const std::size_t before = frames_.size();
        if (!listen()) {
            continue;
        }
        const auto answer =
            std::find_if(frames_.begin() + static_cast<std::ptrdiff_t>(before), frames_.end(),
                         [&](const Bytes& frame) { return frame[1] == command_and_address; });
        if (answer != frames_.end()) {
            return *answer;
        }
    }
    return {};
}

Bytes Asker::ask_until_answered(unsigned command_and_address) {
    Bytes answer;
    eventually([&] {
        answer = ask(command_and_address);
        return !answer.empty();
    });
    return answer;
}

bool Asker::ask_until(unsigned command_and_address, const Bytes& answer) {
    return eventually([&] { return ask(command_and_address) == answer; });
}

SensorString::SensorString(FarEnd& wire, FarWires wires, std::vector<Sensor> sensors)
    : wire_(wire),
      wires_(wires),
      sensors_(std::move(sensors)),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

SensorString::~SensorString() {
    thread_.request_stop();
    thread_.join();
}

void SensorString::set(std::vector<Sensor> sensors) {
    const std::scoped_lock lock(mutex_);
    sensors_ = std::move(sensors);
}

void SensorString::pull() {
    const std::scoped_lock lock(mutex_);
    wire_.pull();
    pending_.clear();
}

void SensorString::plug_in() {
    const std::scoped_lock lock(mutex_);
    wire_.plug_in();
}

void SensorString::work(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        int descriptor = -1;
        {
            const std::scoped_lock lock(mutex_);
            descriptor = wire_.descriptor();
        }
        wait_readable({descriptor}, kIdle);
        const std::scoped_lock lock(mutex_);
        const Bytes more = wire_.receive();
        if (wires_ == FarWires::one && !more.empty()) {
            wire_.send(more);
        }
        append(pending_, more);
        for (const Bytes& request : cut_sensor_frames(pending_, strays_)) {
            answer(request);
        }
    }
}

void SensorString::answer(const Bytes& request) {
    ++asked_[request[1]];
    const unsigned command = request[1] & 0xF0U;
    const std::size_t address = request[1] & 0x0FU;
    if (address == 0 || address > sensors_.size()) {
        return;
    }
    const Sensor& sensor = sensors_[address - 1];
    if (command == kDiscover) {
        wire_.send(request);
    } else if (command == kType) {
        wire_.send(sensor_frame(request[1],
                                {sensor.type, static_cast<std::uint8_t>(sensor.value.size())}));
    } else if (command == kValue) {
        wire_.send(sensor_frame(request[1], sensor.value));
    }
}

std::size_t SensorString::asked(unsigned command_and_address) const {
    const std::scoped_lock lock(mutex_);
    const auto found = asked_.find(command_and_address);
    return found == asked_.end() ? 0 : found->second;
}

std::size_t SensorString::strays() const {
    const std::scoped_lock lock(mutex_);
    return strays_;
}

Joint::Joint(FarEnd& a, FarEnd& b, FarWires wires)
    : thread_([&a, &b, wires](const std::stop_token& stop) {
          const std::array<FarEnd*, 2> ends{&a, &b};
          while (!stop.stop_requested()) {
              wait_readable({a.descriptor(), b.descriptor()}, kIdle);
              for (std::size_t i = 0; i < ends.size(); ++i) {
                  const Bytes bytes = ends[i]->receive();
                  if (wires == FarWires::one && !bytes.empty()) {
                      ends[i]->send(bytes);
                  }
                  if (!bytes.empty()) {
                      ends[1 - i]->send(bytes);
                  }
              }
          }
      }) {}

}  // namespace tribus::test
