#include "transports/links/link_worker.h"

#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

constexpr std::uint64_t kOnce = 1;
/// Many times longer than a transfer on I2C, and shorter than the time after which a receiver that
/// fell silent is failsafe.
constexpr Duration kMostOfAPart = std::chrono::milliseconds(200);
/// Twice the life of a frame is less than a busy machine may delay a thread, where frames are
/// short.
constexpr Duration kLeastPatience = std::chrono::milliseconds(20);
/// Longer than a machine delays a thread that it does not starve.
constexpr Duration kLongestDelay = std::chrono::seconds(1);

std::int64_t as_number(Instant instant) {
    return instant.time_since_epoch().count();
}

}  // namespace

void ask_for_realtime(const WorkerSettings& settings) {
    if (settings.realtime) {
        const sched_param priority{.sched_priority = 1};
        ::sched_setscheduler(0, SCHED_FIFO, &priority);
    }
}

LinkWorker::~LinkWorker() {
    if (thread_.joinable()) {
        ends_.store(true);
        [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
        thread_.join();
    }
}

std::string LinkWorker::start(const WorkerSettings& settings, std::function<WriteStatus()> work) {
    wake_up_ = UniqueFd(::eventfd(0, EFD_CLOEXEC));
    if (!wake_up_.valid()) {
        return std::strerror(errno);
    }
    settings_ = settings;
    work_ = std::move(work);
    try {
        thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& error) {
        return std::string("cannot start a thread: ") + error.what();
    }
    return {};
}

WriteStatus LinkWorker::wake(FrameLife life) {
    if (asked_.load() == taken_.load()) {
        waits_since_ = life.made;
    }
    valid_until_ns_.store(as_number(later(life.made, life.valid_for)));
    asked_.fetch_add(1);
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
    const WriteStatus status = status_.load();
    return status == WriteStatus::written && makes_no_progress(life) ? WriteStatus::unavailable
                                                                     : status;
}

FrameLife LinkWorker::life_from_now() const {
    return {.made = settings_.now(), .valid_for = kMostOfAPart};
}

bool LinkWorker::makes_no_progress(FrameLife life) const {
    const Duration silence = life.made - progress();
    if (works_.load() && silence > kMostOfAPart) {
        return true;
    }
    const Duration waits = life.made - waits_since_;
    return std::min(silence, waits) > std::max(2 * life.valid_for, kLeastPatience);
}

bool LinkWorker::stands(Instant now) const {
    return asked_.load() != taken_.load() && !works_.load() &&
           now - std::max(waits_since_, progress()) > kLongestDelay;
}

void LinkWorker::part_done(WriteStatus outcome) {
    if (outcome != WriteStatus::written) {
        status_.store(outcome);
    }
    note_progress();
}

void LinkWorker::note_progress() {
    progress_ns_.store(as_number(settings_.now()));
}

void LinkWorker::run() {
    ask_for_realtime(settings_);
    std::uint64_t count = 0;
    while (!ends_.load()) {
        if (::read(wake_up_.get(), &count, sizeof count) == sizeof count && !ends_.load()) {
            note_progress();
            works_.store(true);
            taken_.store(asked_.load());
            status_.store(work_());
            works_.store(false);
        }
    }
}

}  // namespace tribus
