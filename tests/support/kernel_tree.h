#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "tests/support/shell.h"

/// A folder with files like those of the kernel in /sys, /proc and /dev.
namespace tribus::test {

class KernelTree {
  public:
    const std::filesystem::path root() const { return folder_ / ""; }

    void write(const std::string& path, std::string_view content) const {
        const std::filesystem::path file = folder_ / path;
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file, std::ios::binary) << content;
    }
    void folder(const std::string& path) const {
        std::filesystem::create_directories(folder_ / path);
    }
    /// Adds a link inside the tree. Both paths start at its root.
    void link(const std::string& path, const std::string& target) const {
        const std::filesystem::path link = folder_ / path;
        std::filesystem::create_directories(link.parent_path());
        folder(target);
        std::filesystem::create_directory_symlink(
            std::filesystem::relative(folder_ / target, link.parent_path()), link);
    }
    /// Adds a link as in /proc, to any target.
    void plain_link(const std::string& path, const std::string& target) const {
        const std::filesystem::path link = folder_ / path;
        std::filesystem::create_directories(link.parent_path());
        std::filesystem::create_symlink(target, link);
    }

    /// Adds the port NAME with its node, its driver and its device, which is a path below
    /// sys/devices.
    void port(const std::string& name, const std::string& device, const std::string& driver) const {
        write("dev/" + name, "");
        link("sys/class/tty/" + name + "/device", "sys/devices/" + device);
        link("sys/devices/" + device + "/driver", "sys/bus/drivers/" + driver);
    }
    /// Adds the port of a USB adapter.
    void usb_port(const std::string& name, const std::string& driver, const std::string& product,
                  const std::string& release) const {
        port(name, "usb1/1-1/1-1:1.0/" + name, driver);
        write("sys/devices/usb1/1-1/1-1:1.0/bInterfaceNumber", "00\n");
        write("sys/devices/usb1/1-1/idVendor", "0403\n");
        write("sys/devices/usb1/1-1/idProduct", "6001\n");
        write("sys/devices/usb1/1-1/bcdDevice", release + "\n");
        write("sys/devices/usb1/1-1/product", product + "\n");
    }
    /// Adds a process, with a file that it has open if `open` is given.
    void process(int number, const std::string& command, const std::string& open = {}) const {
        const std::string folder = "proc/" + std::to_string(number) + "/";
        write(folder + "comm", command + "\n");
        this->folder(folder + "fd");
        if (!open.empty()) {
            plain_link(folder + "fd/3", open);
        }
    }

  private:
    TemporaryFolder folder_;
};

}  // namespace tribus::test
