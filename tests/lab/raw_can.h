#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {

/// A frame with one call: `data` has at most 8 bytes, or at most 64 in an FD frame.
CanFrame make_frame(std::uint32_t id, const std::vector<std::uint8_t>& data, bool fd = false);

/// A frame as a raw socket saw it.
struct CanSight {
    CanFrame frame;  ///< of an error frame, `id` has the CAN_ERR_ bits (linux/can/error.h)
    bool error = false;
    bool own = false;    ///< MSG_CONFIRM: a frame of this socket has left
    bool local = false;  ///< MSG_DONTROUTE: of a socket on this machine
    std::chrono::steady_clock::time_point seen{};
    std::chrono::nanoseconds kernel_time{};  ///< when the kernel took it, since 1970
};

struct RawCanSettings {
    bool fd = true;            ///< takes FD frames too
    bool own_frames = false;   ///< its own frames come back, marked
    std::uint32_t errors = 0;  ///< CAN_ERR_ classes to receive; CAN_ERR_MASK for all
    bool data_frames = true;   ///< false: error frames only
};

/// A raw CAN socket, written again for the tests and independent of the program's link.
class RawCan {
  public:
    /// The test fails if there is no such interface.
    explicit RawCan(const std::string& interface, const RawCanSettings& settings = {});

    /// 0, or the errno of a frame that the kernel did not take. Does not wait.
    int send(const CanFrame& frame);
    /// An error frame, with CAN_ERR_ bits and its 8 bytes. On vcan and vxcan it reaches the sockets
    /// at the other end that ask for errors, as a controller's own would.
    int send_error(std::uint32_t classes, const std::vector<std::uint8_t>& data = {});

    /// The next frame, if one comes in time.
    std::optional<CanSight> receive(std::chrono::milliseconds wait = std::chrono::seconds(15));
    /// All that have arrived; does not wait.
    std::vector<CanSight> receive_all();
    /// Waits for so many, which may still be under way, and takes what there is beyond them.
    std::vector<CanSight> receive_all(std::size_t expected);
    /// The errno of the latest read that failed for another reason than that nothing was there.
    int read_error() const { return read_error_; }

    int descriptor() const { return fd_.get(); }

  private:
    UniqueFd fd_;
    int read_error_ = 0;
};

}  // namespace tribus::test
