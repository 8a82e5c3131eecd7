#include "app/epoch/epoch_file.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/cli/memory_filesystem.h"
#include "app/cli/new_file.h"
#include "app/cli/replace_file.h"
#include "app/journal/log.h"
#include "config/language/read_file.h"
#include "core/quotes.h"
#include "pipelines/realtime/clock.h"
#include "transports/codecs/authenticated/broadcast.h"
#include "transports/links/start_thread.h"

namespace tribus {
namespace {

constexpr std::string_view kFirstLine = "tribus epoch 1\n";
constexpr std::string_view kSecondLine = "next ";
constexpr std::string_view kKeyLine = "key ";
constexpr std::string_view kThirdLine = "clock ";
constexpr std::size_t kMostBytes = 512;
constexpr mode_t kOwnerOnly = 0600;
/// A stack of the usual 8 MB would count as locked memory.
constexpr std::size_t kEpochStackBytes = std::size_t{128} * 1024;
constexpr Duration kPauseAfterFailure = std::chrono::seconds(1);
/// Below it a new file of a sender begins. No sender reaches the highest number there is.
constexpr std::uint64_t kMostFirst = std::uint64_t{1} << 62U;

const NumberBlocks& blocks_of(SettingScope way) {
    return way == SettingScope::output ? authenticated::BroadcastSender::kNumbers
                                       : authenticated::BroadcastReceiver::kNumbers;
}

/// Removes `word` and the number behind it, which a blank or the end of the line ends.
std::optional<std::uint64_t> take_number(std::string_view& text, std::string_view word,
                                         int base = 10) {
    if (!text.starts_with(word)) {
        return std::nullopt;
    }
    text.remove_prefix(word.size());
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number, base);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (error != std::errc{} || text.empty() || (text.front() != '\n' && text.front() != ' ')) {
        return std::nullopt;
    }
    text.remove_prefix(1);
    return number;
}

/// A sender whose file was lost must not use its numbers again.
tl::expected<std::uint64_t, std::string> first_of_new_sender() {
    std::uint64_t number = 0;
    if (::getentropy(&number, sizeof number) != 0) {
        return tl::unexpected(std::string("the kernel gives no random numbers (getentropy)"));
    }
    return number % kMostFirst;
}

bool is_path_in_memory(const std::string& path) {
    struct statfs system {};
    return ::statfs(path.c_str(), &system) == 0 && is_in_memory(system);
}

}  // namespace

EpochFile::EpochFile(std::string path) : path_(std::move(path)), work_(::eventfd(0, EFD_CLOEXEC)) {}

EpochFile::~EpochFile() = default;

tl::expected<void, std::string> EpochFile::open(SettingScope way) {
    const std::lock_guard guard(opening_);
    if (lock_.valid()) {
        return {};
    }
    block_ = blocks_of(way).block;
    auto opened = lock();
    if (opened) {
        const auto stored = read(way);
        opened = stored ? tl::expected<void, std::string>{} : tl::unexpected(stored.error());
        if (stored) {
            begin_after(*stored, way);
            begin_keys(*stored);
            opened = store(next() + block_);
        }
    }
    if (opened) {
        opened = start_thread();
    }
    if (!opened) {
        lock_.reset();
    }
    is_in_memory_ = opened && is_path_in_memory(path_);
    return opened;
}

tl::expected<void, std::string> EpochFile::lock() {
    const std::string name = path_ + ".lock";
    // One that root makes is for the service too, which has the folder.
    lock_.reset(
        ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kOwnerOnly));
    if (lock_.valid()) {
        give_to_owner(folder_of(name).get(), lock_.get());
    } else if (errno == EEXIST) {
        lock_.reset(::open(name.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    }
    if (!lock_.valid()) {
        return tl::unexpected(fmt::format("cannot write {}: {}", name, std::strerror(errno)));
    }
    if (::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
        lock_.reset();
        return tl::unexpected(fmt::format(
            "{} is in use by another program; each end of a link needs its own", path_));
    }
    return {};
}

std::optional<EpochFile::Content> EpochFile::content_of(std::string_view text) {
    if (!text.starts_with(kFirstLine)) {
        return std::nullopt;
    }
    text.remove_prefix(kFirstLine.size());
    const auto number = take_number(text, kSecondLine);
    if (!number || *number > kEndOfNumbers) {
        return std::nullopt;
    }
    Content content{.next = *number};
    while (text.starts_with(kKeyLine)) {
        const auto id = take_number(text, kKeyLine, 16);
        const auto of_key = take_number(text, "");
        if (!id || *id > UINT32_MAX || !of_key || *of_key > kEndOfNumbers) {
            return std::nullopt;
        }
        content.keys.push_back({static_cast<std::uint32_t>(*id), *of_key});
    }
    if (text.starts_with(kThirdLine)) {
        text.remove_prefix(kThirdLine.size());
        content.run.name = text.substr(0, text.find(' '));
        text.remove_prefix(content.run.name.size());
        const auto asleep = take_number(text, " ");
        const auto zero = take_number(text, "");
        if (!asleep || !zero) {
            return std::nullopt;
        }
        content.run.asleep = Duration(static_cast<Duration::rep>(*asleep));
        content.zero = *zero;
    }
    return text.empty() ? std::optional(content) : std::nullopt;
}

tl::expected<EpochFile::Content, std::string> EpochFile::read(SettingScope way) const {
    std::error_code missing;
    if (!std::filesystem::exists(path_, missing) && !missing) {
        const auto first = way == SettingScope::output
                               ? first_of_new_sender()
                               : tl::expected<std::uint64_t, std::string>(0);
        return first.map([](std::uint64_t number) { return Content{.next = number}; });
    }
    const auto text = read_file(path_, kMostBytes);
    if (!text) {
        return tl::unexpected(fmt::format("cannot read {}: {}", path_, text.error()));
    }
    auto content = content_of(*text);
    if (!content) {
        return tl::unexpected(fmt::format(
            "{} is no epoch file: it has {} instead of {}; name another file", path_,
            in_quotes(*text, 20), in_quotes(fmt::format("{}next NUMBER\n", kFirstLine))));
    }
    return std::move(*content);
}

/// If the clock went on since the file was written, a run before this one may have used each number
/// up to now, and none after: outputs send far less often than once a step, so their numbers do not
/// get ahead of the clock. Otherwise it used the numbers that the file names, and a step ahead
/// shows receivers the new clock.
void EpochFile::begin_after(const Content& stored, SettingScope way) {
    if (way != SettingScope::output) {
        begin(stored.next);
        return;
    }
    const std::uint64_t step = authenticated::clock_step(monotonic_now());
    run_ = clock_run();
    const std::uint64_t now = stored.zero + step;
    // A file reserves at most a block ahead: a clock that is further behind went back.
    const bool goes_on = !run_->name.empty() && run_->is_same(stored.run) && now < kEndOfNumbers &&
                         now + blocks_of(way).block >= stored.next;
    const std::uint64_t first = goes_on ? now : stored.next + authenticated::kNewClockNumbers;
    begin(first);
    set_clock(first, step);
}

void EpochFile::set_clock(std::uint64_t number, std::uint64_t step) {
    zero_.store(number - step, std::memory_order_release);
}

std::string EpochFile::clock_line() {
    const std::lock_guard guard(mutex_);
    return !run_ ? ""
                 : fmt::format("{}{} {} {}\n", kThirdLine, run_->name, run_->asleep.count(),
                               zero_.load(std::memory_order_acquire));
}

/// Any thread, but one at a time. `ended`: nobody uses numbers any more.
tl::expected<void, std::string> EpochFile::store(std::uint64_t end, bool ended) {
    end = std::min(end, kEndOfNumbers);
    const std::vector<KeyNumber> keys = ends_of_keys(ended);
    std::string text = fmt::format("{}{}{}\n", kFirstLine, kSecondLine, end);
    for (const KeyNumber& key : keys) {
        text += fmt::format("{}{:08x} {}\n", kKeyLine, key.id, key.number);
    }
    auto stored = replace_file(path_, text + clock_line(), kOwnerOnly);
    if (!stored) {
        return tl::unexpected("cannot write " + stored.error());
    }
    reserved_.store(end, std::memory_order_release);
    const std::lock_guard guard(mutex_);
    for (const KeyNumber& key : keys) {
        std::ranges::find(keys_, key.id, &OfKey::id)->stored(key.number);
    }
    return {};
}

tl::expected<void, std::string> EpochFile::start_thread() {
    pthread_t thread{};
    const int error = tribus::start_thread(thread, kEpochStackBytes, &EpochFile::main, this,
                                           ThreadKind::detached);
    if (error != 0) {
        return tl::unexpected(
            fmt::format("cannot start the thread that writes {}: {}", path_, std::strerror(error)));
    }
    has_thread_ = true;
    return {};
}

void EpochFile::signal() const {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t told = ::write(work_.get(), &one, sizeof one);
}

void EpochFile::wait_for_work(Duration longest) const {
    const auto most = std::chrono::ceil<std::chrono::milliseconds>(longest).count();
    pollfd work{.fd = work_.get(), .events = POLLIN, .revents = 0};
    std::uint64_t count = 0;
    if (::poll(&work, 1, static_cast<int>(most)) > 0) {
        [[maybe_unused]] const ssize_t taken = ::read(work_.get(), &count, sizeof count);
    }
}

/// The data thread calls it. It neither waits nor allocates.
void EpochFile::want(std::uint64_t end) {
    wanted_.store(std::max(end, wanted_.load(std::memory_order_relaxed)),
                  std::memory_order_relaxed);
    ask_to_store();
}

void EpochFile::ask_to_store() {
    if (!storing_.exchange(true)) {
        signal();
    }
}

void EpochFile::store_wanted() {
    const auto stored = store(std::max(wanted_.load(std::memory_order_relaxed), reserved()));
    {
        const std::lock_guard guard(mutex_);
        error_ = stored ? "" : stored.error();
    }
    if (!stored) {
        // Only the end interrupts it: nobody else signals while `storing_` is true.
        wait_for_work(kPauseAfterFailure);
    }
    storing_.store(false);
}

void EpochFile::store_until_closed() {
    constexpr Duration kUntilThereIsWork = std::chrono::hours(1);
    for (;;) {
        if (ends_) {
            if (close()) {
                return;
            }
        } else if (storing_) {
            store_wanted();
        } else {
            wait_for_work(kUntilThereIsWork);
        }
    }
}

void* EpochFile::main(void* self) {
    ::pthread_setname_np(::pthread_self(), "tribus-epoch");
    static_cast<EpochFile*>(self)->store_until_closed();
    return nullptr;
}

void EpochFile::look(const ClockRun& run) {
    const std::lock_guard guard(mutex_);
    if (run_ && !run_->is_same(run)) {
        run_ = run;
        set_clock(reserved() + authenticated::kNewClockNumbers,
                  authenticated::clock_step(monotonic_now()));
    }
    if (is_in_memory_.exchange(false)) {
        log_warning(
            "epoch file {} is in memory: after a start of this machine, frames that somebody "
            "recorded count again; name a file on a disk",
            path_);
    }
    const bool fails = !error_.empty();
    if (fails && !told_failure_) {
        log_error("epoch: {}; its link falls silent when the stored numbers are used up", error_);
    } else if (!fails && told_failure_) {
        log_info("epoch: {} is written again", path_);
    }
    told_failure_ = fails;
}

}  // namespace tribus
