#include "transports/links/serial/serial_medium.h"

#include <linux/major.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include "transports/links/device_path.h"
#include "transports/links/serial/serial_port.h"

namespace tribus {
namespace {

/// What `path` is, if it can never be a serial port. Empty if nothing is there or it may be one.
std::string_view what_else(const std::string& path) {
    struct stat told {};
    if (::stat(path.c_str(), &told) != 0) {
        return {};
    }
    // Memory devices: /dev/null, /dev/zero, /dev/random and others.
    if (S_ISCHR(told.st_mode) && major(told.st_rdev) == MEM_MAJOR) {
        return "this is not a serial device";
    }
    return S_ISDIR(told.st_mode)   ? "this is a folder"
           : S_ISBLK(told.st_mode) ? "this is a disk"
                                   : std::string_view();
}

std::string refusal(const std::string& device) {
    const std::string_view other = what_else(device);
    return other.empty() ? std::string()
                         : std::string(other) + "; give a serial device, such as /dev/ttyUSB0";
}

}  // namespace

constinit const Medium kSerialMedium{
    .name = "a serial line",
    .shape = WireShape::bytes,
    .place = kDeviceSetting,
    .place_absent = "required on a serial line",
    .place_is_path = true,
    .has_line = true,
    .users = Users::one_each_way,
    .silence = {.nothing = "no byte yet; check wire, ground and power of the receiver",
                .no_frame = "but no frame yet; check protocol and rate, and the inverter: SBUS "
                            "needs one, i.Bus must not have one",
                .counts = "byte",
                .doctor = "listens there once this program is stopped"},
    .is_missing = SerialPort::is_missing,
    .identity = device_identity,
    .refusal = refusal,
    .open = [](const std::string& device,
               const LinkUse& use) { return as_link(SerialPort::open(device, use.line)); },
};

}  // namespace tribus
