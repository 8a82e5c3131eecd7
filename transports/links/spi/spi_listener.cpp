#include "transports/links/spi/spi_listener.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include "transports/links/spi/spi_port.h"

namespace tribus {
namespace {

constexpr std::uint64_t kWord = 1;
/// Longer than a machine delays a thread that it does not starve.
constexpr Duration kStandsAfter = std::chrono::seconds(1);
/// When the samples of a block were taken is known that well, unless the thread was held up.
constexpr Duration kHeldUp = std::chrono::milliseconds(1);

}  // namespace

SpiListener::SpiListener(SpiPace pace, const LineSettings& line, const WorkerSettings& worker)
    : pace_(std::move(pace)),
      line_(line),
      worker_(worker),
      bit_(line.bits_time(1)),
      plan_(kMostWaveformBytes * bit_) {}

std::string SpiListener::start() {
    arrived_ = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    end_ = UniqueFd(::eventfd(0, EFD_CLOEXEC));
    if (!arrived_.valid() || !end_.valid()) {
        return std::strerror(errno);
    }
    note_progress();
    try {
        thread_ = std::thread([this] { run(); });
    } catch (const std::system_error& error) {
        return std::string("cannot start a thread: ") + error.what();
    }
    return {};
}

SpiListener::~SpiListener() {
    if (thread_.joinable()) {
        ends_.store(true);
        [[maybe_unused]] const auto woken = ::write(end_.get(), &kWord, sizeof kWord);
        thread_.join();
    }
}

ReadStatus SpiListener::read(Reception& reception) {
    reception.count = 0;
    reception.damaged.reset();
    std::uint64_t count = 0;
    [[maybe_unused]] const auto cleared = ::read(arrived_.get(), &count, sizeof count);
    const std::size_t added = added_.load(std::memory_order_acquire);
    std::size_t next = taken_.load(std::memory_order_relaxed);
    for (bool goes_on = true; goes_on && next != added && reception.count < kBytesPerRead; ++next) {
        const HeardByte& byte = heard_[next % kMostUnread];
        reception.damaged[reception.count] = byte.damaged;
        reception.bytes[reception.count++] = byte.value;
        reception.at = byte.end;
        goes_on = !byte.ends_burst;
    }
    taken_.store(next, std::memory_order_release);
    reception.full = next != added || lost_.load();
    return reception.count > 0 ? ReadStatus::received
           : lost_.load()      ? ReadStatus::lost
                               : ReadStatus::nothing;
}

bool SpiListener::stands(Instant now) const {
    const Instant progress{Duration(progress_ns_.load())};
    return !lost_.load() && !in_kernel_.load() && now - progress > kStandsAfter;
}

void SpiListener::announce() {
    [[maybe_unused]] const auto told = ::write(arrived_.get(), &kWord, sizeof kWord);
}

/// A port that refuses a transfer is asked again some time later.
void SpiListener::wait_for_the_port() {
    constexpr int kPauseMilliseconds = 20;
    pollfd end{.fd = end_.get(), .events = POLLIN, .revents = 0};
    ::poll(&end, 1, kPauseMilliseconds);
}

Instant SpiListener::time_of(Instant begin, std::size_t sample) const {
    return begin + static_cast<std::int64_t>(sample) * bit_ / static_cast<int>(kSamplesPerBit);
}

/// A pair of bytes by chance is no frame.
void SpiListener::tell_plan(std::span<const SampledByte> burst, Instant begin, bool cut) {
    constexpr std::size_t kLeastBytes = 5;
    const bool good =
        burst.size() >= kLeastBytes && std::ranges::none_of(burst, &SampledByte::damaged);
    if (good) {
        plan_.found({.begin = time_of(begin, burst.front().begin),
                     .end = time_of(begin, burst.back().begin) + line_.bytes_time(1),
                     .cut = cut});
    }
}

/// Half of a burst would go on with another one: where the owner has left no room for all of it,
/// nobody is told.
void SpiListener::add(std::span<const SampledByte> burst, Instant begin, Instant at_the_latest) {
    const std::size_t added = added_.load(std::memory_order_relaxed);
    if (added - taken_.load(std::memory_order_acquire) + burst.size() > kMostUnread) {
        return;
    }
    for (std::size_t i = 0; i < burst.size(); ++i) {
        heard_[(added + i) % kMostUnread] = {
            .end = std::min(time_of(begin, burst[i].begin) + line_.bytes_time(1), at_the_latest),
            .value = burst[i].value,
            .damaged = burst[i].damaged,
            .ends_burst = i + 1 == burst.size()};
    }
    added_.store(added + burst.size(), std::memory_order_release);
}

/// `begin` is the earliest time at which the block began, so ages are never too low.
void SpiListener::hand_over(Instant begin, Instant end, bool in_time) {
    const std::size_t pause = 2 * line_.bits_per_byte() * kSamplesPerBit;
    const std::span<const SampledByte> bytes = block_.view();
    std::size_t first = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const bool last = i + 1 == bytes.size();
        if (!last && bytes[i + 1].begin - bytes[i].begin <= pause) {
            continue;
        }
        const auto burst = bytes.subspan(first, i + 1 - first);
        first = i + 1;
        add(burst, begin, end);
        if (in_time) {
            tell_plan(burst, begin, last && block_.cut);
        }
    }
    if (in_time) {
        plan_.ended(end);
    }
    if (!bytes.empty()) {
        announce();
    }
}

/// The samples of a block are of use only if it took the time that they need.
void SpiListener::take_block() {
    note_progress();
    const Instant begin = worker_.now();
    const auto wanted = static_cast<std::size_t>(plan_.next(begin) / bit_);
    const std::size_t bytes = std::clamp<std::size_t>(wanted, 1, samples_.size());
    in_kernel_.store(true);
    const ssize_t count = ::read(pace_.file(), samples_.data(), bytes);
    const int error = count < 0 ? errno : EIO;
    in_kernel_.store(false);
    const Duration took = worker_.now() - begin;
    if (count != static_cast<ssize_t>(bytes)) {
        refused(error);
        return;
    }
    const Duration length = static_cast<std::int64_t>(bytes) * bit_;
    if (took > length / 2) {
        sample_uart(std::span(samples_).first(bytes), line_, block_);
        hand_over(begin, begin + took, took - length < kHeldUp);
    } else {
        wait_for_the_port();
    }
    note_progress();
    if (!pace_.transferred(bytes, took, plan_.pause(worker_.now()))) {
        lose();
    }
}

void SpiListener::refused(int error) {
    if (is_spi_port_gone(error)) {
        lose();
        return;
    }
    pace_.refused(error);
    wait_for_the_port();
}

void SpiListener::lose() {
    lost_.store(true);
    announce();
}

void SpiListener::note_progress() {
    progress_ns_.store(worker_.now().time_since_epoch().count());
}

void SpiListener::run() {
    ask_for_realtime(worker_);
    while (!ends_.load() && !lost_.load()) {
        take_block();
    }
}

}  // namespace tribus
