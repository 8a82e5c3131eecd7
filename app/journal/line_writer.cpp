#include "app/journal/line_writer.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <string>

#include <fmt/format.h>

#include "core/counted.h"

namespace tribus {
namespace {

/// O_NONBLOCK belongs to the open file, which other processes use too, so the writer opens its own.
/// Only a pipe and a terminal can be opened twice without a change of what is written where.
UniqueFd opened_again(int descriptor) {
    struct stat told {};
    const bool waits =
        ::fstat(descriptor, &told) == 0 && (S_ISFIFO(told.st_mode) || ::isatty(descriptor) == 1);
    return waits ? UniqueFd(::open(fmt::format("/proc/self/fd/{}", descriptor).c_str(),
                                   O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC))
                 : UniqueFd();
}

/// So many bytes fit into a pipe that has room at all.
constexpr std::size_t kMostAtOnce = PIPE_BUF;

}  // namespace

LineWriter::LineWriter(int descriptor) : descriptor_(descriptor), own_(opened_again(descriptor)) {}

std::ptrdiff_t LineWriter::put_some(std::string_view text) const {
    if (own_.valid()) {
        return ::write(own_.get(), text.data(), text.size());
    }
    const ssize_t sent = ::send(descriptor_, text.data(), text.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0 || errno != ENOTSOCK) {
        return sent;
    }
    pollfd stream{.fd = descriptor_, .events = POLLOUT, .revents = 0};
    const bool room = ::poll(&stream, 1, 0) == 1 && (stream.revents & POLLOUT) != 0;
    return room ? ::write(descriptor_, text.data(), text.size()) : -1;
}

bool LineWriter::put(std::string_view text) {
    while (!text.empty()) {
        errno = 0;
        const std::ptrdiff_t count = put_some(text.substr(0, kMostAtOnce));
        if (count <= 0 && errno != EINTR) {
            return false;
        }
        torn_ = torn_ || count > 0;
        text.remove_prefix(static_cast<std::size_t>(std::max<std::ptrdiff_t>(count, 0)));
    }
    return true;
}

bool LineWriter::put_line(std::string_view line) {
    std::string text = torn_ ? "\n" : "";
    text.append(line).append("\n");
    const bool whole = put(text);
    torn_ = torn_ && !whole;
    return whole;
}

void LineWriter::write(std::string_view line) {
    // A stream may have room for the few words, but none for the line.
    if (lost_ > 0 &&
        put_line(fmt::format("({} lost here: there was no room)", counted(lost_, "line")))) {
        lost_ = 0;
    }
    lost_ += lost_ == 0 && put_line(line) ? 0U : 1U;
}

}  // namespace tribus
