#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "transports/links/unique_fd.h"

namespace tribus::test {

using Bytes = std::vector<std::uint8_t>;

/// The other end of a serial device's wire. The test holds the master of a pty. The program opens
/// `path()`, a link like those under /dev/serial/by-id, so the device can vanish and come back
/// under another number.
///
/// Cannot prove: bit rates, parity and stop bits, which a pty does not have.
class FarEnd {
  public:
    /// Plugs the device in.
    explicit FarEnd(const std::filesystem::path& path);
    FarEnd(const FarEnd&) = delete;
    FarEnd& operator=(const FarEnd&) = delete;
    ~FarEnd() { pull(); }

    void plug_in();
    void pull();

    const std::string& path() const { return path_; }
    int descriptor() const { return master_.get(); }

    /// Sends what the kernel takes; the rest is lost, as on a wire. Returns whether all was taken.
    bool send(std::span<const std::uint8_t> bytes);
    /// Returns what has arrived since the last call. Does not wait.
    Bytes receive();

  private:
    std::string path_;
    UniqueFd master_;
};

}  // namespace tribus::test
