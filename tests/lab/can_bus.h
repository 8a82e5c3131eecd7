#pragma once

#include <string>

namespace tribus::test {

/// A virtual bus without a rate: every socket on it sees what the others send. Comes up at once,
/// takes FD frames, and is gone with its object.
class VirtualBus {
  public:
    explicit VirtualBus(const std::string& name = "vcan0");
    VirtualBus(const VirtualBus&) = delete;
    VirtualBus& operator=(const VirtualBus&) = delete;
    ~VirtualBus();

    const std::string& name() const { return name_; }
    void down() const;
    void up() const;
    /// The interface vanishes, as a USB adapter that is pulled...
    void remove();
    /// ...and comes back, with another index.
    void create();

  private:
    std::string name_;
    bool there_ = false;
};

/// A bus of two nodes with a bit rate: a vxcan pair, whose both ends send no faster than the rate
/// and queue ten frames, as a controller does; the eleventh gets ENOBUFS. A classic frame takes
/// 128 bits and one of FD 576, whatever is in it, since the queue counts the kernel's bytes
/// (docs/laboratory.md, "CAN: what the drivers do"). What it cannot show: arbitration,
/// acknowledgement, errors.
class PacedBus {
  public:
    enum class Kind { classic, fd };

    explicit PacedBus(unsigned bits_per_second, Kind kind = Kind::classic,
                      const std::string& name = "paced");
    PacedBus(const PacedBus&) = delete;
    PacedBus& operator=(const PacedBus&) = delete;
    ~PacedBus();

    const std::string& near() const { return near_; }
    const std::string& far() const { return far_; }
    /// Stops what `near` sends, as a bus where nobody acknowledges: after one more frame the
    /// others stay in the queue, until `flow`.
    void stall() const;
    void flow() const;

  private:
    void set_rate(const std::string& end, unsigned bits_per_second) const;

    Kind kind_;
    unsigned rate_;
    std::string near_;
    std::string far_;
};

/// Two emulated SJA1000 controllers with Debian's own driver (kvaser_pci) on one bus; classic CAN,
/// in a guest only. They are up. What it cannot show: bus errors, bus-off, a bit rate on the wire
/// (docs/laboratory.md, "CAN: what the drivers do").
class ControllerPair {
  public:
    explicit ControllerPair(unsigned bits_per_second = 1'000'000,
                            const std::string& options = "restart-ms 100");
    ControllerPair(const ControllerPair&) = delete;
    ControllerPair& operator=(const ControllerPair&) = delete;
    ~ControllerPair();

    /// Names of the interfaces, as can0; those of `near` may change when it is plugged again.
    const std::string& near() const { return near_; }
    const std::string& far() const { return far_; }
    /// Takes the card of `near` out of the machine, and puts it back, up again.
    void unplug();
    void plug();
    /// Down, set with other words of `ip link set ... type can`, up.
    void configure(const std::string& interface, unsigned bits_per_second,
                   const std::string& options) const;

  private:
    std::string near_;
    std::string far_;
    unsigned rate_;
    std::string options_;
};

/// Two emulated CTU CAN FD controllers on one bus, up, with bit rates of 1 and 4 Mbit/s; in a guest
/// of the full tier only. Neither bus errors nor states (docs/laboratory.md, "CAN: what the drivers
/// do").
class FdControllerPair {
  public:
    FdControllerPair();
    FdControllerPair(const FdControllerPair&) = delete;
    FdControllerPair& operator=(const FdControllerPair&) = delete;
    ~FdControllerPair();

    const std::string& near() const { return near_; }
    const std::string& far() const { return far_; }

  private:
    std::string near_;
    std::string far_;
};

void set_link_up(const std::string& interface);
void set_link_down(const std::string& interface);
/// Number of the interface; 0 if there is none.
unsigned interface_index(const std::string& interface);

}  // namespace tribus::test
