#include "app/replay/replay_target.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/line_use.h"
#include "app/cli/pty.h"
#include "app/cli/streams.h"
#include "app/journal/print_error.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/can/can_socket.h"
#include "transports/links/serial/serial_port.h"

namespace tribus {
namespace {

using Refused = tl::unexpected<std::string>;
using Opened = tl::expected<std::unique_ptr<ReplayTarget>, std::string>;

/// A new pseudo-terminal, with an optional symbolic link of a fixed name.
class PtyTarget final : public ReplayTarget {
  public:
    PtyTarget(Pty pty, std::string link)
        : pty_(std::move(pty)), link_(std::move(link)), link_inode_(inode_of(link_)) {}
    PtyTarget(const PtyTarget&) = delete;
    PtyTarget& operator=(const PtyTarget&) = delete;
    ~PtyTarget() override {
        // Somebody may have replaced the link by another file, which may even have its inode.
        if (link_inode_ && inode_of(link_) == link_inode_ && leads_to(link_, pty_.path)) {
            ::unlink(link_.c_str());
        }
    }

    static Opened open(const std::string& link) {
        auto pty = Pty::open();
        if (!pty) {
            return Refused(pty.error());
        }
        // From now on the master can tell whether the slave side is open. In raw mode it neither
        // echoes nor changes anything before the reader configures it.
        const UniqueFd slave(::open(pty->path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
        termios settings{};
        if (!slave.valid() || ::tcgetattr(slave.get(), &settings) != 0) {
            return Refused(fmt::format("{}: {}", pty->path, std::strerror(errno)));
        }
        ::cfmakeraw(&settings);
        ::tcsetattr(slave.get(), TCSANOW, &settings);
        if (auto linked = put_link(link, pty->path); !linked) {
            return Refused(linked.error());
        }
        // Before anybody can know of the link, so that it is this one that the target removes.
        auto target = std::make_unique<PtyTarget>(std::move(*pty), link);
        target->told_ = print_line_now(link.empty() ? target->pty_.path : link);
        return target;
    }

    bool wait_for_reader(MainWait& wait) override {
        if (!told_) {
            return false;
        }
        if (!has_reader()) {
            print_error("waiting for a program to open {}\n", link_.empty() ? pty_.path : link_);
        }
        while (!has_reader()) {
            if (wait.until(later(monotonic_now(), kPollPeriod))) {
                return false;
            }
        }
        // A program that opens a port usually discards earlier input.
        return !wait.until(later(monotonic_now(), kReaderPause));
    }

    ReplayOutcome send(const ReplayItem& item) override {
        if (!has_reader()) {
            return ReplayOutcome::refused;
        }
        const auto& bytes = item.burst->bytes;
        const ssize_t count = ::write(pty_.master.get(), bytes.data(), bytes.size());
        return count == static_cast<ssize_t>(bytes.size()) ? ReplayOutcome::sent
                                                           : ReplayOutcome::refused;
    }

  private:
    static constexpr Duration kPollPeriod = std::chrono::milliseconds(10);
    static constexpr Duration kReaderPause = std::chrono::milliseconds(100);

    static tl::expected<void, std::string> put_link(const std::string& link,
                                                    const std::string& path) {
        if (link.empty()) {
            return {};
        }
        if (::symlink(path.c_str(), link.c_str()) != 0) {
            return Refused(
                errno == EEXIST
                    ? fmt::format("--link {}: exists; remove it, or choose another name", link)
                    : fmt::format("--link {}: {}", link, std::strerror(errno)));
        }
        return {};
    }
    static std::optional<std::pair<dev_t, ino_t>> inode_of(const std::string& link) {
        struct stat there {};
        return !link.empty() && ::lstat(link.c_str(), &there) == 0
                   ? std::optional(std::pair(there.st_dev, there.st_ino))
                   : std::nullopt;
    }
    static bool leads_to(const std::string& link, const std::string& path) {
        std::error_code error;
        return std::filesystem::read_symlink(link, error) == path;
    }
    bool has_reader() const {
        pollfd master{.fd = pty_.master.get(), .events = 0, .revents = 0};
        return ::poll(&master, 1, 0) >= 0 && (master.revents & POLLHUP) == 0;
    }

    Pty pty_;
    std::string link_;
    std::optional<std::pair<dev_t, ino_t>> link_inode_;
    /// Whether its name could be printed.
    bool told_ = false;
};

class SerialTarget final : public ReplayTarget {
  public:
    explicit SerialTarget(std::unique_ptr<SerialPort> port) : port_(std::move(port)) {}
    ReplayOutcome send(const ReplayItem& item) override {
        switch (port_->write(item.burst->bytes)) {
            case WriteStatus::written:
                return ReplayOutcome::sent;
            case WriteStatus::lost:
                return ReplayOutcome::gone;
            case WriteStatus::busy:
            case WriteStatus::unavailable:
                break;
        }
        return ReplayOutcome::refused;
    }

  private:
    std::unique_ptr<SerialPort> port_;
};

class CanTarget final : public ReplayTarget {
  public:
    explicit CanTarget(std::unique_ptr<CanSocket> socket) : socket_(std::move(socket)) {}

    /// Waits until the frame before is sent, which takes a working bus only a moment.
    ReplayOutcome send(const ReplayItem& item) override {
        const Instant end = later(monotonic_now(), kPatience);
        WriteStatus status = WriteStatus::busy;
        do {
            const Instant now = monotonic_now();
            if (!gone_) {
                idle(now);
            }
            status =
                under_way() ? WriteStatus::busy : socket_->write(0, std::span(item.frame, 1), now);
            if (status == WriteStatus::busy) {
                ::nanosleep(&kPause, nullptr);
            }
        } while (status == WriteStatus::busy && monotonic_now() < end);
        if (status == WriteStatus::lost || gone_) {
            return ReplayOutcome::gone;
        }
        if (status != WriteStatus::written) {
            return ReplayOutcome::refused;
        }
        ++offered_;
        socket_->poll(monotonic_now());
        return ReplayOutcome::sent;
    }
    Instant idle(Instant now) override {
        ReadStatus status = ReadStatus::received;
        while (status == ReadStatus::received) {
            status = socket_->read(reception_, now, wall_time_now());
        }
        gone_ = gone_ || status == ReadStatus::lost;
        return socket_->poll(now);
    }

  private:
    static constexpr Duration kPatience = std::chrono::milliseconds(50);
    static constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 50'000};

    bool under_way() const {
        const CanCounts counts = socket_->status().counts;
        return counts.sent + counts.abandoned < offered_;
    }

    std::unique_ptr<CanSocket> socket_;
    CanReception reception_;
    std::uint64_t offered_ = 0;
    bool gone_ = false;
};

Opened open_can(const std::string& interface, const Recording& recording) {
    bool fd = false;
    for (const RecordedCanFrame& recorded : recording.can_frames) {
        fd = fd || recorded.frame.fd;
    }
    auto socket = CanSocket::open(interface, {.wanted = {},
                                              .sent = {{.id = 0, .mask = 0, .extended = false},
                                                       {.id = 0, .mask = 0, .extended = true}},
                                              .fd = fd});
    if (!socket) {
        return Refused(std::move(socket.error()));
    }
    return std::make_unique<CanTarget>(std::move(*socket));
}

}  // namespace

tl::expected<void, std::string> check_replay_place(const ReplayPlace& place,
                                                   const Recording& recording) {
    const bool can = recording.kind == RecordingKind::candump;
    const bool pty = place.to == kNewPty;
    if (can != (!pty && !is_device_path(place.to))) {
        return Refused(
            can ? fmt::format("this is a log of CAN frames, and {} is not a CAN interface",
                              place.to)
                : fmt::format("these are bytes of a serial line; --to takes \"pty\" or "
                              "the path of a device, {} is neither",
                              place.to));
    }
    if (pty || can) {
        return {};
    }
    const auto use = serial_use(place.protocol, place.baud);
    return use ? tl::expected<void, std::string>() : Refused(use.error());
}

Opened open_replay_target(const ReplayPlace& place, const Recording& recording) {
    if (auto checked = check_replay_place(place, recording); !checked) {
        return Refused(checked.error());
    }
    if (recording.kind == RecordingKind::candump) {
        return open_can(place.to, recording);
    }
    if (place.to == kNewPty) {
        return PtyTarget::open(place.link);
    }
    const auto use = serial_use(place.protocol, place.baud);
    if (!use) {
        return Refused(use.error());
    }
    auto port = SerialPort::open(place.to, use->line);
    if (!port) {
        return Refused(std::move(port.error()));
    }
    return std::make_unique<SerialTarget>(std::move(*port));
}

}  // namespace tribus
