#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "transports/links/unique_fd.h"

namespace tribus::test {

/// A CAN adapter with the SLCAN protocol, simulated by the test on the master of a pty, with the
/// kernel's own driver (slcan) in between. It is the only controller whose faults a test can
/// trigger (docs/laboratory.md, "CAN: what the drivers do").
///
/// Classic CAN. It differs from real hardware: in bus-off the kernel accepts frames and drops them,
/// restart-ms is not supported (`set_link_down` and `set_link_up` restart it), and nothing is
/// acknowledged unless the test says so.
class SlcanAdapter {
  public:
    /// Attaches the adapter with a bit rate of 1 Mbit/s and sets it up.
    SlcanAdapter();
    SlcanAdapter(const SlcanAdapter&) = delete;
    SlcanAdapter& operator=(const SlcanAdapter&) = delete;
    ~SlcanAdapter();

    /// Name of its interface, such as can2.
    const std::string& name() const { return name_; }

    /// Sends a line as the adapter. `line` has no carriage return at its end.
    void say(const std::string& line);
    void error_warning() { say("sw100000"); }
    void error_passive() { say("sp130000"); }
    void bus_off() { say("sb255000"); }
    void error_active() { say("sa000000"); }
    void missing_acknowledge() { say("e1a"); }
    /// Sends a frame of another node: `t1232AABB` is id 123 with two bytes.
    void frame(const std::string& line) { say(line); }

    /// Returns the lines that the driver has sent so far: the set-up ("C", "S8", "O"), then frames
    /// such as `t1232AABB`. Leaves out the first `known` lines.
    std::vector<std::string> heard(std::size_t known = 0) const;
    /// Stops accepting frames, like a dead bus. `unblock` accepts them again.
    void block() { blocked_ = true; }
    void unblock() { blocked_ = false; }

    /// Unplugs the adapter: its interface vanishes. `plug` plugs it in again, as if it were new.
    void unplug();
    void plug();

  private:
    void listen(const std::stop_token& stop);

    std::string name_;
    UniqueFd master_;
    UniqueFd slave_;
    mutable std::mutex mutex_;  // of heard_ and partial_
    std::vector<std::string> heard_;
    std::string partial_;
    std::atomic<bool> blocked_ = false;
    std::jthread listener_;
};

}  // namespace tribus::test
