#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "tests/loopback/program.h"
#include "tests/loopback/wire.h"
#include "tests/support/far_end.h"

/// The far ends of a sensor bus, written again for the tests and independent of the program's codec
/// (docs/protocols/ibus.md, "Sensor bus: frames" and "Sensor bus: timing").
namespace tribus::test {

/// The second byte of a frame says who is asked for what: 0x81, 0x91, 0xA1 are discover, type and
/// value of address 1.
Bytes sensor_frame(unsigned command_and_address, const Bytes& data = {});

/// Of a value with two bytes.
Bytes value_reply(unsigned address, int raw);

/// Cuts frames off the front of `bytes`. The others stay there, but for such that begin none, which
/// are dropped and counted.
std::vector<Bytes> cut_sensor_frames(Bytes& bytes, std::size_t& strays);

enum class FarWires {
    one,  ///< what the program sends comes back to it
    two,
};

/// A receiver at the far end, which asks one thing in each of its slots.
class Asker {
  public:
    /// How it is joined to the wire; neither waits.
    struct Port {
        std::function<void(const Bytes&)> send;
        std::function<Bytes()> receive;
    };
    /// With slots of 7.7 ms.
    Asker(FarEnd& wire, FarWires wires);
    Asker(Port port, FarWires wires, std::chrono::milliseconds slot)
        : port_(std::move(port)), wires_(wires), slot_(slot) {}

    /// One slot, or more: asks, and waits until the slot is over, or until an answer to
    /// the request is there. Empty where none came.
    Bytes ask(unsigned command_and_address);
    /// Asks again until an answer comes, since a program that was held up withholds one; empty if
    /// patience ends first.
    Bytes ask_until_answered(unsigned command_and_address);
    /// Asks until the answer is this one.
    bool ask_until(unsigned command_and_address, const Bytes& answer);

    /// What stands on the wire in front of each request, as where a receiver joins its two ports.
    void send_before(Bytes bytes) { before_ = std::move(bytes); }

    /// Every frame that ever came, in its order, also such that came later than its slot.
    const std::vector<Bytes>& frames() const { return frames_; }
    std::size_t requests() const { return requests_; }
    std::size_t strays() const { return strays_; }

  private:
    bool listen();

    Port port_;
    FarWires wires_;
    std::chrono::nanoseconds slot_;
    Bytes before_;
    Bytes pending_;
    std::vector<Bytes> frames_;
    std::size_t requests_ = 0;
    std::size_t strays_ = 0;
    Clock::time_point slot_end_{};
};

/// Sensors at the far end, from address 1 on, which answer as long as they live. All that they do
/// in a thread of their own excludes the calls.
class SensorString {
  public:
    struct Sensor {
        std::uint8_t type = 0;
        Bytes value;
    };
    SensorString(FarEnd& wire, FarWires wires, std::vector<Sensor> sensors);
    SensorString(const SensorString&) = delete;
    SensorString& operator=(const SensorString&) = delete;
    ~SensorString();

    void set(std::vector<Sensor> sensors);
    void pull();
    void plug_in();
    /// How often a request came, by its second byte.
    std::size_t asked(unsigned command_and_address) const;
    /// Bytes of the program that were no request.
    std::size_t strays() const;

  private:
    void work(const std::stop_token& stop);
    void answer(const Bytes& request);

    FarEnd& wire_;
    FarWires wires_;
    std::vector<Sensor> sensors_;
    Bytes pending_;
    std::map<unsigned, std::size_t> asked_;
    std::size_t strays_ = 0;
    mutable std::mutex mutex_;
    std::jthread thread_;
};

/// A wire between two devices of the program, as long as it lives: what one sends comes out at the
/// other, and on a single wire at itself as well.
class Joint {
  public:
    Joint(FarEnd& a, FarEnd& b, FarWires wires);
    Joint(const Joint&) = delete;
    Joint& operator=(const Joint&) = delete;
    ~Joint() = default;

  private:
    std::jthread thread_;
};

}  // namespace tribus::test
