#include "transports/links/serial_port.h"

// <termios.h> knows neither termios2 nor BOTHER and cannot stand beside this header.
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <optional>

#include "transports/links/uart_rate.h"

namespace tribus {

namespace {

// A read that a signal interrupts is repeated so often and no more: only the end of a stop
// interrupts the data thread.
constexpr int kInterruptedTries = 3;

constexpr const char* kInUse =
    "another program uses it, or this one opened it under another name; "
    "`fuser -v` with the device's path names the program: end it first";

bool device_is_gone(int error) {
    return error == EIO || error == ENXIO || error == ENODEV || error == EPIPE || error == EBADF;
}

std::string not_serial() {
    return "this is not a serial device; give one, such as /dev/ttyUSB0";
}

std::string open_problem(int error) {
    switch (error) {
        case ENOENT:
        case ENOTDIR:
            return "there is no such device; is it plugged in? `ls /dev/serial/by-id` lists the "
                   "USB adapters that are there";
        case EACCES:
        case EPERM:
            return "no permission to open it; serial devices belong to the group dialout: "
                   "`sudo usermod -aG dialout $USER`, then log in anew";
        case EBUSY:
            return kInUse;
        case ENXIO:
        case ENODEV:
        case EIO:
            return "the device node is there but no device is behind it; is the port enabled?";
        default:
            return std::string("cannot open it: ") + std::strerror(error);
    }
}

std::string settings_problem(int error) {
    if (error == ENOTTY) {
        return not_serial();
    }
    if (device_is_gone(error)) {
        return open_problem(EIO);
    }
    return std::string("its driver refuses the line settings: ") + std::strerror(error);
}

tl::expected<UniqueFd, std::string> open_device(const std::string& device) {
    struct stat node {};
    if (::stat(device.c_str(), &node) != 0) {
        return tl::unexpected(open_problem(errno));
    }
    // Only then open it: opening can have effects on what is no serial device.
    if (!S_ISCHR(node.st_mode)) {
        return tl::unexpected(not_serial());
    }
    UniqueFd fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (!fd.valid()) {
        return tl::unexpected(open_problem(errno));
    }
    return fd;
}

/// Nothing, or why the device cannot be ours alone. Called before any setting is touched.
std::optional<std::string> claim(int fd, bool pseudo_terminal) {
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        return errno == EWOULDBLOCK ? std::string(kInUse) : open_problem(errno);
    }
    // TIOCEXCL keeps out everyone but root, so root has to ask. Not on a pty, where the mark of
    // a program that was killed stays for as long as the other end is open.
    int exclusive = 0;
    if (!pseudo_terminal && ::ioctl(fd, TIOCGEXCL, &exclusive) == 0 && exclusive != 0) {
        return kInUse;
    }
    ::ioctl(fd, TIOCEXCL);
    return std::nullopt;
}

struct termios2 raw_line(const LineSettings& settings) {
    struct termios2 line {};
    line.c_iflag = INPCK | PARMRK;
    line.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
    if (settings.parity == Parity::even) {
        line.c_cflag |= PARENB;
    }
    if (settings.stop_bits == 2) {
        line.c_cflag |= CSTOPB;
    }
    line.c_ispeed = settings.baud;
    line.c_ospeed = settings.baud;
    // With VMIN 0 an empty queue and a device that is gone would both read as no bytes.
    line.c_cc[VMIN] = 1;
    line.c_cc[VTIME] = 0;
    return line;
}

/// Sets the line and reports what the port made of it.
tl::expected<PortFacts, std::string> set_line(int fd, dev_t node, const LineSettings& settings) {
    struct termios2 line {};
    if (::ioctl(fd, TCGETS2, &line) != 0) {
        return tl::unexpected(settings_problem(errno));
    }
    // Raw mode and line in one call, then the flush: what came in while echo was on is neither
    // read nor sent back.
    const struct termios2 wanted = raw_line(settings);
    if (::ioctl(fd, TCSETS2, &wanted) != 0) {
        return tl::unexpected(settings_problem(errno));
    }
    ::ioctl(fd, TCFLSH, TCIOFLUSH);
    if (::ioctl(fd, TCGETS2, &line) != 0) {
        return tl::unexpected(settings_problem(errno));
    }
    // Never compare c_cflag whole: the kernel puts B115200 where BOTHER was asked
    // (docs/protocols/sbus.md, "Serial port: bit rate").
    const tcflag_t changed = line.c_cflag ^ wanted.c_cflag;
    PortFacts facts;
    facts.device_major = major(node);
    facts.device_minor = minor(node);
    facts.asked = settings;
    facts.reported_baud = line.c_ospeed;
    facts.parity_kept = (changed & (PARENB | PARODD | CMSPAR)) == 0;
    facts.stop_bits_kept = (changed & CSTOPB) == 0;
    facts.data_bits_kept = (changed & CSIZE) == 0;
    // After the rate is set: some drivers change their base clock with it.
    struct serial_struct driver {};
    if (::ioctl(fd, TIOCGSERIAL, &driver) == 0 && driver.baud_base > 0) {
        facts.driver = SerialDriverFacts{driver.type, static_cast<std::uint32_t>(driver.baud_base)};
    }
    return facts;
}

/// Asks for bytes as soon as they arrive (an FTDI holds them back 16 ms otherwise) and for a
/// short wait at close. Drivers without either, and users without the right, go on without.
void prefer_low_latency(int fd) {
    constexpr unsigned short kClosingWaitCentiseconds = 10;
    struct serial_struct driver {};
    if (::ioctl(fd, TIOCGSERIAL, &driver) != 0) {
        return;
    }
    driver.flags = static_cast<int>(static_cast<unsigned>(driver.flags) | ASYNC_LOW_LATENCY);
    ::ioctl(fd, TIOCSSERIAL, &driver);
    // A call of its own: only root may change this, and would take the latency down with it.
    driver.closing_wait = kClosingWaitCentiseconds;
    ::ioctl(fd, TIOCSSERIAL, &driver);
}

}  // namespace

tl::expected<std::unique_ptr<SerialPort>, std::string> SerialPort::open(
    const std::string& device, const LineSettings& settings) {
    const auto failed = [&device](const std::string& why) {
        return tl::unexpected(device + ": " + why);
    };
    auto fd = open_device(device);
    if (!fd) {
        return failed(fd.error());
    }
    struct stat node {};
    if (::fstat(fd->get(), &node) != 0) {
        return failed(open_problem(errno));
    }
    if (::isatty(fd->get()) == 0) {
        return failed(settings_problem(errno));
    }
    const bool pseudo_terminal = is_pseudo_terminal(major(node.st_rdev));
    if (const auto why = claim(fd->get(), pseudo_terminal)) {
        return failed(*why);
    }
    std::unique_ptr<SerialPort> port(new SerialPort(std::move(*fd)));
    const auto facts = set_line(port->descriptor(), node.st_rdev, settings);
    if (!facts) {
        return failed(facts.error());
    }
    if (const auto why = port_refusal(*facts)) {
        return failed(*why);
    }
    prefer_low_latency(port->descriptor());
    return port;
}

bool SerialPort::is_missing(const std::string& device) {
    struct stat node {};
    return ::stat(device.c_str(), &node) != 0 && errno == ENOENT;
}

SerialPort::~SerialPort() {
    int queued = 0;
    for (int waited = 0; waited < kMostDrainMilliseconds; ++waited) {
        if (::ioctl(fd_.get(), TIOCOUTQ, &queued) != 0 || queued == 0) {
            break;
        }
        ::poll(nullptr, 0, 1);
    }
    if (queued > 0) {
        ::ioctl(fd_.get(), TCFLSH, TCOFLUSH);
    }
    // The mark outlives us where something else keeps the terminal, as a pty's other end does.
    ::ioctl(fd_.get(), TIOCNXCL);
}

ReadStatus SerialPort::read(Reception& reception) {
    reception.count = 0;
    reception.damaged.reset();
    reception.full = false;
    if (lost_) {
        return ReadStatus::lost;
    }
    // No larger than a Reception: marks only shrink, so all of it finds room.
    std::array<std::uint8_t, kBytesPerRead> raw;
    ssize_t taken = -1;
    int error = EINTR;
    for (int tries = 0; taken < 0 && error == EINTR && tries < kInterruptedTries; ++tries) {
        taken = ::read(fd_.get(), raw.data(), raw.size());
        error = errno;
    }
    if (taken > 0) {
        reception.full = taken == static_cast<ssize_t>(raw.size());
        marks_.take({raw.data(), static_cast<std::size_t>(taken)}, reception);
        return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
    }
    if (taken < 0 && (error == EAGAIN || error == EINTR)) {
        return ReadStatus::nothing;
    }
    // End of file is a hang-up. Any other error would come again at every wake: give up, too.
    lost_ = true;
    return ReadStatus::lost;
}

void SerialPort::discard_unread() {
    // What the line buffer had no room for is handed to it a while after it was read: only the
    // kernel can throw away both.
    ::ioctl(fd_.get(), TCFLSH, TCIFLUSH);
    marks_ = {};
}

WriteStatus SerialPort::write(std::span<const std::uint8_t> frame) {
    const WriteStatus asked = ask();
    return asked == WriteStatus::written ? write_asked(frame) : asked;
}

WriteStatus SerialPort::ask() {
    int queued = 0;
    if (!lost_ && ::ioctl(fd_.get(), TIOCOUTQ, &queued) != 0) {
        lost_ = device_is_gone(errno);
        queued = 0;  // a driver that cannot tell: let the write decide
    }
    return lost_ ? WriteStatus::lost : queued > 0 ? WriteStatus::busy : WriteStatus::written;
}

WriteStatus SerialPort::write_asked(std::span<const std::uint8_t> frame) {
    const ssize_t taken = ::write(fd_.get(), frame.data(), frame.size());
    const int error = errno;
    if (taken < 0 && error == EINTR) {
        // Not tried again: nobody knows how long that took.
        return WriteStatus::busy;
    }
    if (taken < 0 && device_is_gone(error)) {
        lost_ = true;
        return WriteStatus::lost;
    }
    if (taken != static_cast<ssize_t>(frame.size())) {
        // What was queued is a part of a frame, or on a pty what nobody reads: stale either way.
        ::ioctl(fd_.get(), TCFLSH, TCOFLUSH);
        return WriteStatus::busy;
    }
    return WriteStatus::written;
}

}  // namespace tribus
