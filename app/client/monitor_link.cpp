#include "app/client/monitor_link.h"

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>

#include <fmt/format.h>

#include "app/client/control_socket.h"

namespace tribus {
namespace {

constexpr Duration kTryPeriod = std::chrono::milliseconds(500);
/// Upper limit of one object; no daemon sends a larger one.
constexpr std::size_t kLongestObject = std::size_t{4} << 20U;
constexpr std::size_t kReadsAtOnce = 64;

}  // namespace

void MonitorLink::lose(std::string why) {
    descriptor_.reset();
    received_.clear();
    problem_ = std::move(why);
}

void MonitorLink::reconnect(Instant now) {
    if (connected() || now < next_try_) {
        return;
    }
    next_try_ = later(now, kTryPeriod);
    auto socket = connect_local(path_);
    if (!socket) {
        problem_ = fmt::format("no daemon answers at {}: {}", path_, std::strerror(socket.error()));
        return;
    }
    descriptor_ = std::move(*socket);
    problem_.clear();
    send(fmt::format("watch {}us",
                     std::chrono::duration_cast<std::chrono::microseconds>(period_).count()));
}

void MonitorLink::send(const std::string& request) {
    const std::string text = request + "\n";
    if (connected() &&
        ::send(descriptor_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0) {
        lose("the daemon at " + path_ + " is gone");
    }
}

std::vector<std::string> MonitorLink::read() {
    constexpr std::size_t kBytesAtOnce = 16384;
    std::array<char, kBytesAtOnce> bytes;
    bool gone = false;
    for (std::size_t i = 0; i < kReadsAtOnce && connected(); ++i) {
        const ssize_t count = ::recv(descriptor_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count > 0) {
            received_.append(bytes.data(), static_cast<std::size_t>(count));
        } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
            gone = true;
            break;
        } else {
            break;
        }
    }
    std::vector<std::string> lines;
    std::size_t begin = 0;
    for (std::size_t end = received_.find('\n'); end != std::string::npos;
         end = received_.find('\n', begin)) {
        lines.push_back(received_.substr(begin, end - begin));
        begin = end + 1;
    }
    received_.erase(0, begin);
    if (gone) {
        lose("the daemon at " + path_ + " is gone; waiting for it");
    } else if (received_.size() > kLongestObject) {
        lose("what answers at " + path_ + " is no tribus");
    }
    return lines;
}

}  // namespace tribus
