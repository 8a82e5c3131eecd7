#pragma once

#include <string>

namespace tribus::test {

/// A character device in the /dev that a program of tests has for itself (own_dev.cpp): there, it
/// does what /dev/null does. Removed with its object.
class DeviceFile {
  public:
    explicit DeviceFile(const std::string& name);
    DeviceFile(const DeviceFile&) = delete;
    DeviceFile& operator=(const DeviceFile&) = delete;
    ~DeviceFile() { remove(); }

    const std::string& path() const { return path_; }
    void remove();

  private:
    std::string path_;
};

}  // namespace tribus::test
