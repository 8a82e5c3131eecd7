#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

/// Makes a frame. `data` has at most 8 bytes, or at most 64 in an FD frame.
CanFrame make_frame(std::uint32_t id, const std::vector<std::uint8_t>& data, bool fd = false);

/// A frame as a raw socket received it.
struct CanSight {
    CanFrame frame;  ///< in an error frame `id` has the CAN_ERR_ bits (linux/can/error.h)
    bool error = false;
    bool own = false;    ///< MSG_CONFIRM: a frame of this socket was sent
    bool local = false;  ///< MSG_DONTROUTE: from a socket on this machine
    std::chrono::steady_clock::time_point seen{};
    std::chrono::nanoseconds kernel_time{};  ///< when the kernel received it, since 1970
};

struct RawCanSettings {
    bool fd = true;            ///< accepts FD frames too
    bool own_frames = false;   ///< the socket receives its own frames, marked
    std::uint32_t errors = 0;  ///< CAN_ERR_ classes to receive; CAN_ERR_MASK for all
    bool data_frames = true;   ///< false: error frames only
};

/// A raw CAN socket, written for the tests and independent of the program's link.
class RawCan {
  public:
    /// Opens the interface. The test fails if there is none.
    explicit RawCan(const std::string& interface, const RawCanSettings& settings = {});

    /// Sends a frame without waiting. Returns 0, or the errno if the kernel refuses it.
    int send(const CanFrame& frame);
    /// Sends an error frame with CAN_ERR_ bits and 8 bytes. On vcan and vxcan it reaches the
    /// sockets at the other end that ask for errors, like one from a controller.
    int send_error(std::uint32_t classes, const std::vector<std::uint8_t>& data = {});

    /// Returns the next frame, or nothing if none comes in time.
    std::optional<CanSight> receive(std::chrono::milliseconds wait = std::chrono::seconds(15));
    /// Returns all frames that have arrived. Does not wait.
    std::vector<CanSight> receive_all();
    /// Waits for `expected` frames. Returns them and any further ones that have arrived.
    std::vector<CanSight> receive_all(std::size_t expected);
    /// The errno of the latest failed read, unless there was only nothing to read.
    int read_error() const { return read_error_; }

    int descriptor() const { return fd_.get(); }

  private:
    UniqueFd fd_;
    int read_error_ = 0;
};

}  // namespace tribus::test
