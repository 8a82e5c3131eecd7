#include "app/web/pairing/pairing.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/file_error.h"
#include "app/cli/new_file.h"
#include "app/cli/replace_file.h"
#include "config/language/read_file.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;
using PairingJson = nlohmann::json;
using Refused = tl::unexpected<std::string>;

/// Base 32 without signs that look alike.
constexpr std::string_view kSigns = "23456789ABCDEFGHJKLMNPQRSTUVWXYZ";
constexpr std::size_t kCodeSigns = 8;
constexpr std::size_t kMostFileBytes = std::size_t{64} * 1024;
constexpr std::size_t kLongestName = 40;
constexpr mode_t kUserAndGroup = 0660;
constexpr std::string_view kCodeFile = "code.json";

/// The code as it was typed, in capitals, without blanks and dashes.
std::string plain(std::string_view typed) {
    std::string code;
    for (const char c : typed.substr(0, 4 * kCodeSigns)) {
        const auto sign = static_cast<unsigned char>(c);
        if (std::isspace(sign) == 0 && c != '-') {
            code.push_back(static_cast<char>(std::toupper(sign)));
        }
    }
    return code;
}

/// As a name in one line: without control characters, not longer than a line of a list.
std::string plain_name(std::string_view name) {
    std::string plain;
    for (const char c : name.substr(0, kLongestName)) {
        plain.push_back(c >= ' ' && c <= '~' ? c : '?');
    }
    return plain.empty() ? "browser" : plain;
}

/// Held while the files are read and written, which takes milliseconds. Whoever holds it for longer
/// hangs, or is not the page any more: nobody waits for them.
class FolderLock {
  public:
    static tl::expected<FolderLock, std::string> take(const fs::path& folder) {
        constexpr int kTries = 200;
        constexpr std::chrono::milliseconds kPause{10};
        FolderLock lock;
        lock.folder_ = UniqueFd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        for (int i = 0; lock.folder_.valid() && i < kTries; ++i) {
            if (::flock(lock.folder_.get(), LOCK_EX | LOCK_NB) == 0) {
                return lock;
            }
            if (errno != EWOULDBLOCK && errno != EINTR) {
                return file_error(folder, errno);
            }
            std::this_thread::sleep_for(kPause);
        }
        return lock.folder_.valid()
                   ? Refused(
                         fmt::format("{}: another program holds it; end that one, for example by "
                                     "systemctl stop tribus-web",
                                     folder.string()))
                   : file_error(folder, errno);
    }

  private:
    UniqueFd folder_;
};

/// The content of a file; null if it is absent, or nobody wrote it.
tl::expected<PairingJson, std::string> stored_in(const fs::path& file) {
    const auto text = read_file(file, kMostFileBytes);
    if (!text) {
        std::error_code ignored;
        return fs::exists(file, ignored) ? tl::expected<PairingJson, std::string>(Refused(
                                               fmt::format("{}: {}", file.string(), text.error())))
                                         : PairingJson();
    }
    return PairingJson::parse(*text, nullptr, false);
}

/// Nothing of another type is taken: somebody may have edited the file.
std::string word_in(const PairingJson& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}
std::int64_t number_in(const PairingJson& object, const char* key) {
    const auto found = object.is_object() ? object.find(key) : object.end();
    return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

std::vector<Session> sessions_in(const PairingJson& json) {
    std::vector<Session> sessions;
    for (const PairingJson& one : json.is_array() ? json : PairingJson::array()) {
        if (const auto role = role_of(word_in(one, "role"))) {
            sessions.push_back({word_in(one, "name"), *role, word_in(one, "hash"),
                                WallTime(number_in(one, "made"))});
        }
    }
    return sessions;
}

std::string text_of(const std::vector<Session>& sessions) {
    PairingJson json = PairingJson::array();
    for (const Session& session : sessions) {
        json.push_back({{"name", session.name},
                        {"role", word_of(session.role)},
                        {"hash", session.hash},
                        {"made", session.made.count()}});
    }
    return json.dump(1) + "\n";
}

/// Also if the clock was set back: no code lasts longer than from now.
bool is_valid(const PairingJson& code, WallTime now) {
    const WallTime until(number_in(code, "until"));
    return role_of(word_in(code, "role")) && now < until &&
           until - now <= PairingFolder::kCodeLasts;
}

}  // namespace

std::string_view word_of(Role role) {
    return role == Role::change ? "change" : "look";
}

std::optional<Role> role_of(std::string_view word) {
    return word == "change" ? std::optional(Role::change)
           : word == "look" ? std::optional(Role::look)
                            : std::nullopt;
}

/// The folder belongs to the page, and root writes here too.
tl::expected<void, std::string> PairingFolder::write(const fs::path& file,
                                                     const std::string& text) const {
    const std::string name = file.filename().string();
    const std::string fresh = name + ".new";
    const UniqueFd folder = folder_of(file);
    const UniqueFd out = folder.valid() ? new_file(folder.get(), fresh, kUserAndGroup) : UniqueFd();
    if (!out.valid() || !write_all(out.get(), text) || ::fsync(out.get()) != 0 ||
        ::renameat(folder.get(), fresh.c_str(), folder.get(), name.c_str()) != 0) {
        return file_error(file, errno);
    }
    return {};
}

tl::expected<std::string, std::string> PairingFolder::make_code(Role role, WallTime now,
                                                                const Step& then) {
    const auto lock = FolderLock::take(folder_);
    if (!lock) {
        return Refused(lock.error());
    }
    std::array<std::uint8_t, kCodeSigns> random{};
    if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
        return Refused("the kernel gives no random numbers");
    }
    std::string code;
    for (const std::uint8_t byte : random) {
        code.push_back(kSigns[byte % kSigns.size()]);
    }
    const PairingJson json{
        {"code", code}, {"role", word_of(role)}, {"until", (now + kCodeLasts).count()}};
    if (auto written = write(folder_ / kCodeFile, json.dump() + "\n"); !written) {
        return Refused(written.error());
    }
    if (const auto done = then ? then() : tl::expected<void, std::string>(); !done) {
        return Refused(done.error());
    }
    return code;
}

tl::expected<CodeTried, std::string> PairingFolder::try_code(
    std::string_view typed, WallTime now, const std::optional<JoiningBrowser>& joins) {
    const auto lock = FolderLock::take(folder_);
    if (!lock) {
        return Refused(lock.error());
    }
    const fs::path file = folder_ / kCodeFile;
    const auto json = stored_in(file);
    if (!json) {
        return Refused(json.error());
    }
    if (!is_valid(*json, now)) {
        std::error_code ignored;
        fs::remove(file, ignored);
        return CodeTried{};
    }
    if (plain(typed) != word_in(*json, "code")) {
        return CodeTried{std::nullopt, true};
    }
    const auto role = role_of(word_in(*json, "role"));
    if (joins) {
        if (const auto added = add(joins->name, *role, joins->hash, now); !added) {
            return Refused(added.error());
        }
    }
    std::error_code ignored;
    fs::remove(file, ignored);
    return CodeTried{role, false};
}

tl::expected<void, std::string> PairingFolder::add_session(std::string_view name, Role role,
                                                           std::string hash, WallTime now) {
    const auto lock = FolderLock::take(folder_);
    return lock ? add(name, role, std::move(hash), now) : Refused(lock.error());
}

/// Under the lock.
tl::expected<void, std::string> PairingFolder::add(std::string_view name, Role role,
                                                   std::string hash, WallTime now) {
    auto all = sessions();
    if (!all) {
        return Refused(all.error());
    }
    std::erase_if(*all, [now](const Session& one) { return now - one.made >= kSessionLasts; });
    if (all->size() >= kMostSessions) {
        all->erase(all->begin());
    }
    all->push_back({plain_name(name), role, std::move(hash), now});
    return write(sessions_file(), text_of(*all));
}

tl::expected<std::vector<Session>, std::string> PairingFolder::sessions() const {
    return stored_in(sessions_file()).map(sessions_in);
}

tl::expected<std::size_t, std::string> PairingFolder::revoke(std::string_view name) {
    const auto lock = FolderLock::take(folder_);
    auto all = sessions();
    if (!lock || !all) {
        return Refused(!lock ? lock.error() : all.error());
    }
    const std::size_t gone =
        std::erase_if(*all, [name](const Session& one) { return one.name == name; });
    if (gone != 0) {
        if (auto written = write(sessions_file(), text_of(*all)); !written) {
            return Refused(written.error());
        }
    }
    return gone;
}

bool PairingFolder::lets_change(WallTime now) const {
    const auto all = sessions();
    const auto code = stored_in(folder_ / kCodeFile);
    const auto may = [now](const Session& one) {
        return one.role == Role::change && now - one.made < kSessionLasts;
    };
    return (all && std::ranges::any_of(*all, may)) ||
           (code && role_of(word_in(*code, "role")) == Role::change && is_valid(*code, now));
}

tl::expected<void, std::string> PairingFolder::close_if_unused(WallTime now,
                                                               const Step& close) const {
    const auto lock = FolderLock::take(folder_);
    return lets_change(now) ? tl::expected<void, std::string>() : close();
}

tl::expected<void, std::string> PairingFolder::leave(std::string_view hash) {
    const auto lock = FolderLock::take(folder_);
    auto all = sessions();
    if (!lock || !all) {
        return Refused(!lock ? lock.error() : all.error());
    }
    std::erase_if(*all, [hash](const Session& one) { return one.hash == hash; });
    return write(sessions_file(), text_of(*all));
}

const std::vector<Session>& SessionsInMemory::of(const PairingFolder& folder) {
    struct stat file {};
    const bool there = ::stat(folder.sessions_file().c_str(), &file) == 0;
    const Version version = there ? Version{.inode = file.st_ino,
                                            .bytes = file.st_size,
                                            .changed_s = file.st_mtim.tv_sec,
                                            .changed_ns = file.st_mtim.tv_nsec}
                                  : Version{};
    if (version != version_) {
        version_ = version;
        sessions_ = folder.sessions().value_or(std::vector<Session>());
    }
    return sessions_;
}

const Session* find_session(const std::vector<Session>& sessions, std::string_view hash,
                            WallTime now) {
    const auto found = std::ranges::find_if(sessions, [&](const Session& one) {
        return !hash.empty() && one.hash == hash && now - one.made < PairingFolder::kSessionLasts;
    });
    return found == sessions.end() ? nullptr : &*found;
}

}  // namespace tribus::web
