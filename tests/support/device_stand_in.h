#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// Devices that this machine lacks. A program of tests that links device_stand_in.cpp has its own
/// `open`, `access`, `fstat`, `ioctl`, `read`, `write`, `sendto` and `syscall`. They ask the
/// stand-in that has the path or the descriptor, and the C library for everything else.
namespace tribus::test {

/// A device as long as this object is there; it must outlive who opens it. By itself it opens, and
/// refuses each request with ENOTTY. Subclasses say which driver of the kernel they copy.
class DeviceStandIn {
  public:
    /// A program that opens that path gets the file at it, or an empty one if there is none. A
    /// stand-in may also be for a descriptor that is open already, such as a socket.
    explicit DeviceStandIn(std::string path);
    explicit DeviceStandIn(int descriptor);
    DeviceStandIn(const DeviceStandIn&) = delete;
    DeviceStandIn& operator=(const DeviceStandIn&) = delete;
    virtual ~DeviceStandIn();

    /// The kernel's result; an error is an errno below zero (-EIO). Nothing: the file answers.
    using Answer = std::optional<long>;
    /// Also that of `access`.
    virtual Answer open() { return {}; }
    /// After the file said what it is; may change that.
    virtual Answer state(struct stat& /*node*/) { return {}; }
    virtual Answer control(unsigned long /*request*/, void* /*argument*/);
    virtual Answer read(std::span<std::uint8_t> /*room*/) { return {}; }
    /// Also what is sent by `sendto`.
    virtual Answer write(std::span<const std::uint8_t> /*bytes*/) { return {}; }

    /// How often it was opened, and what it was asked for by `ioctl`, in this order.
    int opened = 0;
    std::vector<unsigned long> asked{};
    /// Requests that it refuses, with the errno.
    std::map<unsigned long, int> refused{};

    /// For the functions of device_stand_in.cpp.
    int open_file(int flags);
    Answer take_control(unsigned long request, void* argument);
    bool has(const struct stat& node) const;
    const std::string& path() const { return path_; }

  private:
    void enter();

    std::string path_;
    int file_ = -1;  ///< an empty file
    struct stat node_ {};
};

}  // namespace tribus::test
