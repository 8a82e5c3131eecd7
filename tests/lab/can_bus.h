#pragma once

#include <string>

namespace tribus::test {

/// A virtual bus without a bit rate: every socket on it sees what the others send. It is up at
/// once, accepts FD frames and is removed with its object.
class VirtualBus {
  public:
    explicit VirtualBus(const std::string& name = "vcan0");
    VirtualBus(const VirtualBus&) = delete;
    VirtualBus& operator=(const VirtualBus&) = delete;
    ~VirtualBus();

    const std::string& name() const { return name_; }
    void down() const;
    void up() const;
    /// Removes the interface, like a USB adapter that is unplugged.
    void remove();
    /// Creates the interface again, with another index.
    void create();

  private:
    std::string name_;
    bool there_ = false;
};

/// A bus of two nodes with a bit rate: a vxcan pair. Both ends send no faster than the rate and
/// queue ten frames, as a controller does; the eleventh gets ENOBUFS. Every classic frame takes 128
/// bits and every FD frame 576 bits, because the queue counts the kernel's bytes
/// (docs/laboratory.md, "CAN: what the drivers do"). It does not show arbitration, acknowledgement
/// or errors.
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
    /// Stops what `near` sends, like a bus without acknowledgement. One more frame is sent, the
    /// others stay in the queue until `flow`.
    void stall() const;
    void flow() const;

  private:
    void set_rate(const std::string& end, unsigned bits_per_second) const;

    Kind kind_;
    unsigned rate_;
    std::string near_;
    std::string far_;
};

/// Two emulated SJA1000 controllers with Debian's own driver (kvaser_pci) on one bus, both up.
/// Classic CAN, in the emulator only. It does not show bus errors, bus-off or a bit rate on the
/// wire (docs/laboratory.md, "CAN: what the drivers do").
class ControllerPair {
  public:
    explicit ControllerPair(unsigned bits_per_second = 1'000'000,
                            const std::string& options = "restart-ms 100");
    ControllerPair(const ControllerPair&) = delete;
    ControllerPair& operator=(const ControllerPair&) = delete;
    ~ControllerPair();

    /// Names of the interfaces, such as can0. The name of `near` may change when it is plugged in
    /// again.
    const std::string& near() const { return near_; }
    const std::string& far() const { return far_; }
    /// Takes the card of `near` out of the machine, then puts it back and sets it up again.
    void unplug();
    void plug();
    /// Sets the interface down, configures it with other options of `ip link set ... type can`, and
    /// sets it up.
    void configure(const std::string& interface, unsigned bits_per_second,
                   const std::string& options) const;

  private:
    std::string near_;
    std::string far_;
    unsigned rate_;
    std::string options_;
};

/// Two emulated CTU CAN FD controllers on one bus, up, with bit rates of 1 and 4 Mbit/s. In a guest
/// of the full tier only. They show neither bus errors nor states (docs/laboratory.md, "CAN: what
/// the drivers do").
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

/// Gives each of two interfaces the name of the other at once, as udev does with adapters that it
/// finds in another order. Both are up at the end.
void swap_names(const std::string& one, const std::string& other);
void set_link_up(const std::string& interface);
void set_link_down(const std::string& interface);
/// Index of the interface, or 0 if there is none.
unsigned interface_index(const std::string& interface);

}  // namespace tribus::test
