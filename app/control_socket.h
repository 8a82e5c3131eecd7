#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// Where a running daemon is reached on this machine.
namespace tribus {

/// What tells where sockets belong.
struct SocketHomes {
    std::string runtime_directory;  ///< of a service of systemd; may be empty
    std::string user_directory;     ///< XDG_RUNTIME_DIR; may be empty
    std::string system_directory = "/run";
    bool root = false;

    static SocketHomes of_this_process();
};

/// `control` in the service's own directory, else `tribus/NAME.sock` in that of the system or the
/// user, where NAME is the configuration file's without its ending. Nothing where there is no such
/// place. Pure.
std::optional<std::string> default_socket(const SocketHomes& homes, const std::string& config);

/// A listening local socket that only its user and group may use. Its file goes with it, unless
/// somebody else has taken its place.
class LocalListener {
  public:
    /// Makes the directory too. Takes the place of a socket on which nobody answers any more. The
    /// error is a sentence.
    static tl::expected<LocalListener, std::string> open(const std::string& path);
    LocalListener(LocalListener&& other) noexcept
        : descriptor_(std::move(other.descriptor_)),
          path_(std::exchange(other.path_, {})),
          inode_(other.inode_) {}
    LocalListener& operator=(LocalListener&& other) noexcept = delete;
    LocalListener(const LocalListener&) = delete;
    LocalListener& operator=(const LocalListener&) = delete;
    ~LocalListener();

    /// To be moved from: who serves it closes it.
    UniqueFd& descriptor() { return descriptor_; }
    const std::string& path() const { return path_; }

  private:
    LocalListener(UniqueFd descriptor, std::string path)
        : descriptor_(std::move(descriptor)), path_(std::move(path)) {}

    UniqueFd descriptor_;
    std::string path_;
    std::uint64_t inode_ = 0;
};

/// Does not block. The error is an error number.
tl::expected<UniqueFd, int> connect_local(const std::string& path);

/// A socket on which somebody answers.
struct FoundSocket {
    std::string name;  ///< of the daemon, as `default_socket` gave it
    std::string path;
};
/// Of all daemons in the usual places that this user may talk to, in order of their names.
std::vector<FoundSocket> find_sockets(const SocketHomes& homes);

}  // namespace tribus
