#include "app/cli/main_wait.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <vector>

#include "pipelines/realtime/clock.h"

namespace tribus {

tl::expected<MainWait, std::string> MainWait::for_signals(std::initializer_list<int> signals) {
    sigset_t set;
    ::sigemptyset(&set);
    for (const int signal : signals) {
        ::sigaddset(&set, signal);
    }
    ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
    UniqueFd descriptor(::signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC));
    if (!descriptor.valid()) {
        return tl::unexpected(std::string("cannot wait for signals: ") + std::strerror(errno));
    }
    return MainWait(std::move(descriptor));
}

std::optional<int> MainWait::until(Instant deadline, std::span<const int> others) {
    std::vector<pollfd> watched;
    watched.reserve(others.size() + 1);
    watched.push_back({.fd = signals_.get(), .events = POLLIN, .revents = 0});
    for (const int descriptor : others) {
        watched.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
    }
    constexpr Duration kLongestWait = std::chrono::hours(1);
    const Duration left = std::clamp(deadline - monotonic_now(), Duration::zero(), kLongestWait);
    // Rounded up: a wait that ends too early would be followed by a wait of 0 ms.
    const auto wait = std::chrono::ceil<std::chrono::milliseconds>(left);
    const int readable = ::poll(watched.data(), watched.size(), static_cast<int>(wait.count()));
    const bool signalled = readable > 0 && watched.front().revents != 0;
    other_readable_ = readable > (signalled ? 1 : 0);
    if (!signalled) {
        return std::nullopt;
    }
    std::array<signalfd_siginfo, 8> came{};
    const ssize_t size = ::read(signals_.get(), came.data(), sizeof came);
    std::optional<int> signal;
    for (std::size_t i = 0; size > 0 && i < static_cast<std::size_t>(size) / sizeof came[0]; ++i) {
        signal = std::max(signal, std::optional(static_cast<int>(came[i].ssi_signo)));
    }
    return signal;
}

}  // namespace tribus
