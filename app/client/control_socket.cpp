#include "app/client/control_socket.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>

#include <fmt/format.h>

namespace tribus {
namespace {

namespace fs = std::filesystem;
using Refused = tl::unexpected<std::string>;

constexpr std::string_view kFolder = "tribus";
constexpr std::string_view kEnding = ".sock";
/// In the service's own directory, which systemd makes.
constexpr std::string_view kOwnName = "control";
constexpr std::string_view kLookFolder = "tribus-look";
/// Names of one of the two kinds of sockets.
struct SocketNames {
    std::string_view own;     ///< in the service's own directory
    std::string_view ending;  ///< behind the name of the daemon
};
constexpr SocketNames kControlNames{kOwnName, kEnding};
constexpr SocketNames kLookNames{"look", ".look"};
constexpr mode_t kUserAndGroup = 0660;
constexpr int kBacklog = 16;

std::string variable(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
}

std::optional<sockaddr_un> address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof address.sun_path) {
        return std::nullopt;
    }
    std::memcpy(address.sun_path, path.data(), path.size());
    return address;
}

UniqueFd local_socket() {
    return UniqueFd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

std::uint64_t inode_of(const std::string& path) {
    struct stat file {};
    return ::lstat(path.c_str(), &file) == 0 ? file.st_ino : 0;
}

/// Succeeds if nothing is at `path`, or only the socket of a daemon that ended.
tl::expected<void, std::string> must_be_free(const std::string& path) {
    struct stat file {};
    if (::lstat(path.c_str(), &file) != 0) {
        return {};
    }
    if (!S_ISSOCK(file.st_mode)) {
        return Refused(fmt::format("{} exists and is not a socket; choose another --socket", path));
    }
    const auto answers = connect_local(path);
    if (!answers && answers.error() != ECONNREFUSED) {
        return Refused(fmt::format("cannot find out whether {} is in use: {}", path,
                                   std::strerror(answers.error())));
    }
    if (answers) {
        return Refused(
            fmt::format("another program answers on {}: a second daemon of that name? Give this "
                        "one another path with --socket",
                        path));
    }
    return {};
}

}  // namespace

SocketDirectories SocketDirectories::of_this_process() {
    SocketDirectories directories;
    directories.runtime_directory = variable("RUNTIME_DIRECTORY");
    // If the unit has several directories, the first one is its own.
    directories.runtime_directory.resize(
        std::min(directories.runtime_directory.find(':'), directories.runtime_directory.size()));
    directories.user_directory = variable("XDG_RUNTIME_DIR");
    directories.root = ::geteuid() == 0;
    return directories;
}

std::optional<std::string> default_socket(const SocketDirectories& directories,
                                          const std::string& config) {
    if (!directories.runtime_directory.empty()) {
        return fmt::format("{}/{}", directories.runtime_directory, kOwnName);
    }
    const std::string& directory =
        directories.root ? directories.system_directory : directories.user_directory;
    if (directory.empty()) {
        return std::nullopt;
    }
    return fmt::format("{}/{}/{}{}", directory, kFolder, fs::path(config).stem().string(), kEnding);
}

std::string look_socket(const std::string& control) {
    const fs::path path(control);
    const fs::path folder = path.parent_path();
    if (path.filename() != kOwnName) {
        const bool usual = path.extension() == kEnding;
        return (folder / (usual ? path.stem() : path.filename())).string() +
               std::string(kLookNames.ending);
    }
    const bool of_service = folder.parent_path().filename() == kFolder;
    return of_service ? folder.parent_path().parent_path() / kLookFolder /
                            (folder.filename().string() + std::string(kLookNames.ending))
                      : folder / kLookNames.own;
}

std::string draft_file(const std::string& socket) {
    const fs::path path(socket);
    const std::string folder =
        path.filename() == kOwnName ? "draft" : path.stem().string() + ".draft";
    return path.parent_path() / folder / "draft.toml";
}

tl::expected<LocalListener, std::string> LocalListener::open(const std::string& path) {
    // The socket listens before it is renamed to its path, so that clients never find one that does
    // not.
    const std::string unnamed = fmt::format("{}.{}", path, ::getpid());
    const auto address = address_of(unnamed);
    if (!address) {
        return Refused(fmt::format("{} is too long for a socket; at most about 95 bytes", path));
    }
    std::error_code error;
    const fs::path folder = fs::path(path).parent_path();
    if (!folder.empty()) {
        fs::create_directories(folder, error);
    }
    if (auto is_free = must_be_free(path); !is_free) {
        return Refused(is_free.error());
    }
    UniqueFd socket = local_socket();
    ::unlink(unnamed.c_str());
    const bool made =
        socket.valid() &&
        ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) == 0 &&
        ::fchmodat(AT_FDCWD, unnamed.c_str(), kUserAndGroup, AT_SYMLINK_NOFOLLOW) == 0 &&
        ::listen(socket.get(), kBacklog) == 0 && ::rename(unnamed.c_str(), path.c_str()) == 0;
    if (!made) {
        const int why = errno;
        ::unlink(unnamed.c_str());
        return Refused(fmt::format("cannot create a socket at {}: {}", path, std::strerror(why)));
    }
    LocalListener listener(std::move(socket), path);
    listener.inode_ = inode_of(path);
    return listener;
}

LocalListener::~LocalListener() {
    if (!path_.empty() && inode_of(path_) == inode_) {
        ::unlink(path_.c_str());
    }
}

tl::expected<UniqueFd, int> connect_local(const std::string& path) {
    const auto address = address_of(path);
    if (!address) {
        return tl::unexpected(ENAMETOOLONG);
    }
    UniqueFd socket = local_socket();
    if (!socket.valid() || ::connect(socket.get(), reinterpret_cast<const sockaddr*>(&*address),
                                     sizeof *address) != 0) {
        return tl::unexpected(errno);
    }
    return socket;
}

namespace {

void add_answering(std::vector<FoundSocket>& found, std::string name, const std::string& path) {
    const bool known =
        std::ranges::any_of(found, [&](const FoundSocket& other) { return other.path == path; });
    if (!known && inode_of(path) != 0 && connect_local(path)) {
        found.push_back({std::move(name), path});
    }
}

/// Adds those that end with the usual ending in that folder.
void add_named(std::vector<FoundSocket>& found, const fs::path& folder, const SocketNames& names) {
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() == names.ending) {
            add_answering(found, at->path().stem().string(), at->path().string());
        }
    }
}

/// Adds `tribus/NAME.sock`, and of services `tribus/control`, `tribus/NAME/control` and
/// `tribus-NAME/control`; or those that tell.
void add_from(std::vector<FoundSocket>& found, const fs::path& directory,
              const SocketNames& names) {
    const std::string prefix = std::string(kFolder) + "-";
    std::error_code error;
    add_named(found, directory / kFolder, names);
    for (fs::directory_iterator at(directory / kFolder, error), end; !error && at != end;
         at.increment(error)) {
        add_answering(found, at->path().filename().string(), (at->path() / names.own).string());
    }
    add_answering(found, std::string(kFolder), (directory / kFolder / names.own).string());
    for (fs::directory_iterator at(directory, error), end; !error && at != end;
         at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (name.starts_with(prefix)) {
            add_answering(found, name.substr(prefix.size()), (at->path() / names.own).string());
        }
    }
}

std::vector<FoundSocket> find_named(const SocketDirectories& directories,
                                    const SocketNames& names) {
    std::vector<FoundSocket> found;
    if (!directories.runtime_directory.empty()) {
        add_answering(found, fs::path(directories.runtime_directory).filename().string(),
                      fmt::format("{}/{}", directories.runtime_directory, names.own));
    }
    for (const std::string& directory :
         {directories.system_directory, directories.user_directory}) {
        if (!directory.empty()) {
            add_from(found, directory, names);
        }
    }
    return found;
}

}  // namespace

std::vector<FoundSocket> find_sockets(const SocketDirectories& directories) {
    std::vector<FoundSocket> found = find_named(directories, kControlNames);
    std::ranges::sort(found, {}, &FoundSocket::name);
    return found;
}

std::vector<FoundSocket> find_telling_sockets(const SocketDirectories& directories) {
    std::vector<FoundSocket> found = find_named(directories, kLookNames);
    for (const std::string& directory :
         {directories.system_directory, directories.user_directory}) {
        if (!directory.empty()) {
            add_named(found, fs::path(directory) / kLookFolder, kLookNames);
        }
    }
    for (FoundSocket& control : find_named(directories, kControlNames)) {
        const bool tells = std::ranges::any_of(found, [&](const FoundSocket& other) {
            return other.path == look_socket(control.path);
        });
        if (!tells) {
            found.push_back(std::move(control));
        }
    }
    std::ranges::sort(found, {}, &FoundSocket::name);
    return found;
}

}  // namespace tribus
