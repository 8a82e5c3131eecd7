#include "transports/links/link_worker.h"

#include <poll.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

constexpr std::uint64_t kOnce = 1;
/// Many times longer than a transfer on I2C, and shorter than the time after which a receiver that
/// fell silent is failsafe.
constexpr itimerspec kMostOfAPart{.it_interval = {},
                                  .it_value = {.tv_sec = 0, .tv_nsec = 200'000'000}};

}  // namespace

LinkWorker::~LinkWorker() {
    if (thread_.joinable()) {
        ends_.store(true);
        [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
        thread_.join();
    }
}

std::string LinkWorker::start(std::function<WriteStatus()> work) {
    wake_up_ = UniqueFd(::eventfd(0, EFD_CLOEXEC));
    patience_ = UniqueFd(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC));
    if (!wake_up_.valid() || !patience_.valid()) {
        return std::strerror(errno);
    }
    work_ = std::move(work);
    try {
        thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& error) {
        return std::string("cannot start a thread: ") + error.what();
    }
    return {};
}

WriteStatus LinkWorker::wake() {
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
    const WriteStatus status = status_.load();
    return status == WriteStatus::written && hangs() ? WriteStatus::unavailable : status;
}

void LinkWorker::part_done(WriteStatus outcome) {
    if (outcome != WriteStatus::written) {
        status_.store(outcome);
    }
    watch_next_part();
}

void LinkWorker::watch_next_part() {
    ::timerfd_settime(patience_.get(), 0, &kMostOfAPart, nullptr);
}

bool LinkWorker::hangs() const {
    pollfd patience{.fd = patience_.get(), .events = POLLIN, .revents = 0};
    return works_.load() && ::poll(&patience, 1, 0) > 0;
}

void LinkWorker::run() {
    // Before everything that is not real time; refused without the right to it.
    const sched_param priority{.sched_priority = 1};
    ::sched_setscheduler(0, SCHED_FIFO, &priority);
    std::uint64_t count = 0;
    while (!ends_.load()) {
        if (::read(wake_up_.get(), &count, sizeof count) == sizeof count && !ends_.load()) {
            watch_next_part();
            works_.store(true);
            status_.store(work_());
            works_.store(false);
        }
    }
}

}  // namespace tribus
