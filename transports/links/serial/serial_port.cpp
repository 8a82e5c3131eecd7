#include "transports/links/serial/serial_port.h"

// <termios.h> lacks termios2 and BOTHER and cannot be included beside this header
// (docs/protocols/sbus.md, "Serial port: bit rate").
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <optional>
#include <thread>

#include "transports/links/direct_call.h"
#include "transports/links/serial/uart_rate.h"

namespace tribus {

namespace {

// Number of tries of a read that a signal interrupts. Only the signal that stops the program
// interrupts the data thread.
constexpr int kInterruptedTries = 3;
constexpr auto kDrainPause = std::chrono::milliseconds(1);

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
                   "connected USB adapters";
        case EACCES:
        case EPERM:
            return "no permission to open it; serial devices belong to the group dialout: "
                   "`sudo usermod -aG dialout $USER`, then log in again";
        case EBUSY:
            return kInUse;
        case ENXIO:
        case ENODEV:
        case EIO:
            return "the device node exists, but it has no device; is the port enabled?";
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
    // Checked before opening, because opening other devices can have effects.
    if (!S_ISCHR(node.st_mode)) {
        return tl::unexpected(not_serial());
    }
    UniqueFd fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    if (!fd.valid()) {
        return tl::unexpected(open_problem(errno));
    }
    return fd;
}

/// Why the device cannot be used by this program alone; nothing if it can. Called before any
/// setting is changed.
std::optional<std::string> claim(int fd, bool pseudo_terminal) {
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        return errno == EWOULDBLOCK ? std::string(kInUse) : open_problem(errno);
    }
    // TIOCEXCL excludes everyone but root, so root must ask. Not on a pty, where the mark of a
    // killed program stays as long as the other end is open.
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
    // With VMIN 0, an empty queue and a missing device would both read as no bytes. VTIME is 0.
    line.c_cc[VMIN] = 1;
    return line;
}

/// Sets the line and reports which settings the port kept.
tl::expected<PortFacts, std::string> set_line(int fd, dev_t node, const LineSettings& settings) {
    // Sets raw mode and line in one call, then flushes: bytes that came while echo was on are
    // neither read nor sent back.
    const struct termios2 wanted = raw_line(settings);
    if (::ioctl(fd, TCSETS2, &wanted) != 0) {
        return tl::unexpected(settings_problem(errno));
    }
    ::ioctl(fd, TCFLSH, TCIOFLUSH);
    struct termios2 line {};
    if (::ioctl(fd, TCGETS2, &line) != 0) {
        return tl::unexpected(settings_problem(errno));
    }
    // Never compare the whole of c_cflag: the kernel replaces BOTHER by B115200
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
    // After setting the rate, because some drivers change their base clock with it.
    struct serial_struct driver {};
    if (::ioctl(fd, TIOCGSERIAL, &driver) == 0) {
        facts.driver = SerialDriverFacts{driver.type, static_cast<std::uint32_t>(driver.baud_base)};
    }
    return facts;
}

/// Requests delivery of bytes without delay (an FTDI holds them back 16 ms otherwise;
/// docs/protocols/sbus.md, "Serial port: latency") and a short wait at close. Optional: some
/// drivers support neither, and some users lack the right.
void prefer_low_latency(int fd) {
    constexpr unsigned short kClosingWaitCentiseconds = 10;
    struct serial_struct driver {};
    if (::ioctl(fd, TIOCGSERIAL, &driver) != 0) {
        return;
    }
    driver.flags = static_cast<int>(static_cast<unsigned>(driver.flags) | ASYNC_LOW_LATENCY);
    ::ioctl(fd, TIOCSSERIAL, &driver);
    // A separate call: only root may change this, and its refusal would undo the low latency.
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
        std::this_thread::sleep_for(kDrainPause);
    }
    if (queued > 0) {
        ::ioctl(fd_.get(), TCFLSH, TCOFLUSH);
    }
    // The mark would outlive the port if something else keeps the terminal open, such as the other
    // end of a pty.
    ::ioctl(fd_.get(), TIOCNXCL);
}

ReadStatus SerialPort::read(Reception& reception) {
    reception.count = 0;
    reception.damaged.reset();
    reception.full = false;
    if (lost_) {
        return ReadStatus::lost;
    }
    ssize_t taken = -1;
    int tries = 0;
    do {
        taken = read_directly(fd_.get(), reception.bytes.data(), reception.bytes.size());
        ++tries;
    } while (taken == -1 && errno == EINTR && tries < kInterruptedTries);
    if (taken > 0) {
        reception.full = taken == static_cast<ssize_t>(reception.bytes.size());
        marks_.remove(static_cast<std::size_t>(taken), reception);
        return reception.count > 0 ? ReadStatus::received : ReadStatus::nothing;
    }
    if (taken == -1 && (errno == EAGAIN || errno == EINTR)) {
        reception.full = errno == EINTR;
        return ReadStatus::nothing;
    }
    // End of file is a hang-up. Any other error would occur again at every wake-up, so the port is
    // given up too.
    lost_ = true;
    return ReadStatus::lost;
}

/// A read of a terminal without bytes waits for the kernel's worker (Link::wakes_at_each_arrival).
bool SerialPort::has_unread() const {
    int bytes = 0;
    return ::ioctl(fd_.get(), TIOCINQ, &bytes) == 0 && bytes > 0;
}

void SerialPort::discard_unread() {
    // Bytes for which the line buffer has no room are moved there later, so only the kernel can
    // discard both.
    ::ioctl(fd_.get(), TCFLSH, TCIFLUSH);
    marks_ = {};
}

WriteStatus SerialPort::write(std::span<const std::uint8_t> frame) {
    const WriteStatus asked = ask();
    return asked == WriteStatus::written ? write_asked(frame, {}) : asked;
}

WriteStatus SerialPort::ask() {
    int queued = 0;
    if (!lost_ && ::ioctl(fd_.get(), TIOCOUTQ, &queued) != 0) {
        lost_ = device_is_gone(errno);
        queued = 0;  // a driver that gives no count: the write decides
    }
    return lost_ ? WriteStatus::lost : queued > 0 ? WriteStatus::busy : WriteStatus::written;
}

WriteStatus SerialPort::write_asked(std::span<const std::uint8_t> frame, FrameLife /*life*/) {
    const ssize_t taken = write_directly(fd_.get(), frame.data(), frame.size());
    if (taken == -1 && errno == EINTR) {
        // Not repeated: the time that it took is unknown.
        return WriteStatus::busy;
    }
    if (taken == -1 && device_is_gone(errno)) {
        lost_ = true;
        return WriteStatus::lost;
    }
    if (taken != static_cast<ssize_t>(frame.size())) {
        // The queue holds a part of a frame, or on a pty bytes that nobody reads: both are stale.
        ::ioctl(fd_.get(), TCFLSH, TCOFLUSH);
        return WriteStatus::busy;
    }
    return WriteStatus::written;
}

}  // namespace tribus
