#include <algorithm>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "app/epoch/epoch_file.h"

/// The epoch files of this process: those in use, and those that are being closed.
namespace tribus {

/// It is never destroyed: the thread of a file whose disk hangs may need it until the process ends.
struct EpochFile::Registry {
    struct Entry {
        std::unique_ptr<EpochFile> file;
        std::weak_ptr<EpochFile> users;
    };
    std::mutex mutex;
    std::condition_variable closed;
    std::map<std::string, Entry> files;
};

EpochFile::Registry& EpochFile::registry() {
    static auto* const only = new Registry;
    static const struct End {
        End() = default;
        End(const End&) = delete;
        End& operator=(const End&) = delete;
        ~End() { wait_until_closed(kLongestEnd); }
    } end;
    return *only;
}

std::shared_ptr<EpochFile> EpochFile::of(const std::string& path) {
    Registry& all = registry();
    const std::lock_guard guard(all.mutex);
    Registry::Entry& entry = all.files[path];
    if (auto used = entry.users.lock()) {
        return used;
    }
    if (entry.file) {
        entry.file->take_up_again();
    } else {
        entry.file.reset(new EpochFile(path));
    }
    std::shared_ptr<EpochFile> users(entry.file.get(), [path](EpochFile*) { let_go(path); });
    entry.users = users;
    return users;
}

/// The last user has gone, but another one may have come.
void EpochFile::let_go(const std::string& path) {
    Registry& all = registry();
    const std::lock_guard guard(all.mutex);
    const auto entry = all.files.find(path);
    // One who came and went meanwhile may have taken it away already.
    if (entry == all.files.end() || !entry->second.users.expired()) {
        return;
    }
    if (entry->second.file->has_thread_) {
        entry->second.file->ends_ = true;
        entry->second.file->signal();
    } else {
        all.files.erase(entry);
    }
}

/// Its thread may be about to store the number that is next now: none may be used before a later
/// one is stored.
void EpochFile::take_up_again() {
    if (!has_thread_) {
        return;
    }
    ends_ = false;
    reserved_.store(next(), std::memory_order_release);
    take_up_keys_again();
    want(next() + block_);
}

/// Its thread calls it once nobody uses the file. Returns false if somebody does again; else the
/// object is gone.
bool EpochFile::close() {
    // If that fails, the file still has a number that is high enough.
    static_cast<void>(store(next(), true));
    Registry& all = registry();
    const std::lock_guard guard(all.mutex);
    if (!ends_) {
        return false;
    }
    all.files.erase(all.files.find(path_));
    all.closed.notify_all();
    return true;
}

bool EpochFile::wait_until_closed(Duration longest) {
    Registry& all = registry();
    std::unique_lock guard(all.mutex);
    return all.closed.wait_for(guard, longest, [&] {
        return std::ranges::none_of(all.files,
                                    [](const auto& file) { return file.second.users.expired(); });
    });
}

}  // namespace tribus
