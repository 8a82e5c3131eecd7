#include "app/daemon/service_notify.h"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "app/journal/log.h"
#include "app/status/status.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Upper limit of a wait: a service manager that hangs must not hang this program.
constexpr timeval kLongestWait{.tv_sec = 1, .tv_usec = 0};

/// Socket address of `name`; nothing if the name is neither a path nor abstract, or too long.
std::optional<std::pair<sockaddr_un, socklen_t>> address_of(std::string_view name) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const bool known = name.starts_with('/') || name.starts_with('@');
    if (!known || name.size() >= sizeof address.sun_path) {
        return std::nullopt;
    }
    std::memcpy(address.sun_path, name.data(), name.size());
    if (name.front() == '@') {
        address.sun_path[0] = '\0';
    }
    // An abstract name has no zero byte at its end; behind a path the kernel adds it.
    const std::size_t length = offsetof(sockaddr_un, sun_path) + name.size();
    return std::pair(address, static_cast<socklen_t>(length));
}

std::optional<std::uint64_t> number_in(const char* variable) {
    const char* const text = std::getenv(variable);
    std::uint64_t number = 0;
    if (text == nullptr) {
        return std::nullopt;
    }
    const char* const end = text + std::strlen(text);
    const auto parsed = std::from_chars(text, end, number);
    return parsed.ec == std::errc() && parsed.ptr == end ? std::optional(number) : std::nullopt;
}

/// Reads the environment as sd_watchdog_enabled(3) does.
std::optional<Duration> watchdog_limit() {
    const auto usec = number_in("WATCHDOG_USEC");
    constexpr std::uint64_t kLongest = std::chrono::microseconds(std::chrono::hours(24)).count();
    const bool ours = std::getenv("WATCHDOG_PID") == nullptr ||
                      number_in("WATCHDOG_PID") == static_cast<std::uint64_t>(::getpid());
    return usec && *usec > 0 && *usec <= kLongest && ours
               ? std::optional<Duration>(std::chrono::microseconds(*usec))
               : std::nullopt;
}

Standing standing_part(const Appliance& appliance, Instant now) {
    const StandingPort port = appliance.standing_port();
    if (port.fault != StandingPort::Fault::none) {
        return {port.fault == StandingPort::Fault::unheard ? Standing::Part::port_unheard
                                                           : Standing::Part::link_thread,
                port.port};
    }
    return {appliance.gpio_thread_stands(now) ? Standing::Part::gpio_thread : Standing::Part::none};
}

std::string text_of(const Standing& standing, const Appliance& appliance) {
    if (standing.part == Standing::Part::gpio_thread) {
        return "the thread of the GPIO lines stands still";
    }
    const std::string& device = appliance.ports()[standing.port].config.device;
    return standing.part == Standing::Part::link_thread
               ? "the thread of " + device + " stands still"
               : "the kernel does not report what comes at " + device;
}

}  // namespace

NotifySocket NotifySocket::from_environment() {
    NotifySocket made;
    const char* const name = std::getenv("NOTIFY_SOCKET");
    if (name == nullptr) {
        return made;
    }
    const auto address = address_of(name);
    UniqueFd socket(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!address || !socket.valid() ||
        ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &kLongestWait, sizeof kLongestWait) !=
            0 ||
        ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address->first),
                  address->second) != 0) {
        log_warning("cannot notify the service manager at {}: {}", name,
                    address ? std::strerror(errno)
                            : "neither a path nor an abstract name of at most 107 bytes");
        return made;
    }
    made.socket_ = std::move(socket);
    return made;
}

bool NotifySocket::send(std::string_view lines) const {
    return socket_.valid() && ::send(socket_.get(), lines.data(), lines.size(), MSG_NOSIGNAL) ==
                                  static_cast<ssize_t>(lines.size());
}

ServiceNotify::ServiceNotify() : socket_(NotifySocket::from_environment()) {
    const auto limit = socket_.connected() ? watchdog_limit() : std::nullopt;
    if (limit) {
        watchdog_.emplace(*limit);
    }
}

void ServiceNotify::started(Instant now) {
    if (watchdog_) {
        watchdog_->restart();
    }
    sent_status_.clear();
    next_status_ = now;
    socket_.send("READY=1");
}

void ServiceNotify::reloading() {
    const auto usec = std::chrono::duration_cast<std::chrono::microseconds>(awake_time_now());
    socket_.send(fmt::format(
        "RELOADING=1\nMONOTONIC_USEC={}\nSTATUS=reading the configuration again", usec.count()));
}

void ServiceNotify::stopping() {
    socket_.send("STOPPING=1\nSTATUS=outputs send their last frames as their failsafe demands");
}

void ServiceNotify::look_at_outputs(const Appliance& appliance, Instant now) {
    std::vector<OutputProgress> outputs;
    for (std::size_t i = 0; i < appliance.configuration().outputs.size(); ++i) {
        const OutputStatus status = appliance.output_status(i);
        outputs.push_back({status.due, status.period, status.overruns});
    }
    if (watchdog_->look(now, appliance.figures_at(), outputs, standing_part(appliance, now))) {
        socket_.send("WATCHDOG=1");
    }
    const Punctuality found = watchdog_->punctuality();
    if (found == Punctuality::on_time) {
        reported_.take_as_known(found);
        return;
    }
    const auto swallowed = reported_.look(found, limit_, now);
    if (!swallowed) {
        return;
    }
    if (found == Punctuality::data_thread_stands) {
        log_error(
            "the data thread stands still; if it does not go on soon, the service manager restarts "
            "the program{}",
            swallowed_note(*swallowed));
    } else if (found == Punctuality::part_stands) {
        log_error("{}; if that does not end soon, the service manager restarts the program{}",
                  text_of(watchdog_->standing(), appliance), swallowed_note(*swallowed));
    } else {
        log_warning(
            "output {}: half of its frames are late or missed; the machine is too slow or "
            "too busy. If this goes on, the service manager restarts the program{}",
            appliance.configuration().outputs[watchdog_->late_output()].name,
            swallowed_note(*swallowed));
    }
}

void ServiceNotify::tell_status(const Appliance& appliance, Instant now) {
    constexpr Duration kPeriod = std::chrono::seconds(1);
    if (now < next_status_) {
        return;
    }
    next_status_ = now + kPeriod;
    std::string text = status_line(appliance, now);
    if (text != sent_status_ && socket_.send("STATUS=" + text)) {
        sent_status_ = std::move(text);
    }
}

void ServiceNotify::look(const Appliance& appliance, Instant now) {
    if (!socket_.connected()) {
        return;
    }
    if (watchdog_) {
        look_at_outputs(appliance, now);
    }
    tell_status(appliance, now);
}

}  // namespace tribus
