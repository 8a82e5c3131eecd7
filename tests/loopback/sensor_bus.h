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

/// The far ends of a sensor bus, written for the tests and independent of the program's codec
/// (docs/protocols/ibus.md, "Sensor bus: frames" and "Sensor bus: timing").
namespace tribus::test {

/// Returns a frame. Its second byte has the command and the address: 0x81, 0x91, 0xA1 are discover,
/// type and value of address 1.
Bytes sensor_frame(unsigned command_and_address, const Bytes& data = {});

/// Returns the reply with a value of two bytes.
Bytes value_reply(unsigned address, int raw);

/// Moves complete frames out of the front of `bytes`. Bytes that begin no frame are dropped and
/// counted in `strays`; the others stay.
std::vector<Bytes> cut_sensor_frames(Bytes& bytes, std::size_t& strays);

enum class FarWires {
    one,  ///< the program receives what it sends
    two,
};

/// A receiver at the far end, which sends one request in each of its slots.
class Asker {
  public:
    /// Access to the wire; neither function waits.
    struct Port {
        std::function<void(const Bytes&)> send;
        std::function<Bytes()> receive;
    };
    /// Has slots of 7.7 ms.
    Asker(FarEnd& wire, FarWires wires);
    Asker(Port port, FarWires wires, std::chrono::milliseconds slot)
        : port_(std::move(port)), wires_(wires), slot_(slot) {}

    /// Sends a request, and waits until the slot is over or the answer is there. Returns an empty
    /// answer if none came.
    Bytes ask(unsigned command_and_address);
    /// Repeats the request until an answer comes, because a program that was delayed withholds one.
    /// Returns an empty answer if kPatience ends first.
    Bytes ask_until_answered(unsigned command_and_address);
    /// Repeats the request until the answer is this one.
    bool ask_until(unsigned command_and_address, const Bytes& answer);

    /// Sets bytes to send before each request, as from a receiver that joins its two ports.
    void send_before(Bytes bytes) { before_ = std::move(bytes); }

    /// All frames in the order of arrival, including those that came after their slot.
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

/// Sensors at the far end, from address 1 on, which answer during the object's lifetime. Their
/// thread locks out the member functions while it works.
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
    /// Number of requests with this second byte.
    std::size_t asked(unsigned command_and_address) const;
    /// Bytes from the program that were no request.
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

/// A wire between two devices of the program. Each receives what the other sends, and on a single
/// wire also what it sends itself.
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
