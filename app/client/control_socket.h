#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

/// The sockets of daemons on this machine: the control socket, and one that only tells.
namespace tribus {

/// The directories in which sockets can be.
struct SocketDirectories {
    std::string runtime_directory;  ///< of the systemd service; may be empty
    std::string user_directory;     ///< XDG_RUNTIME_DIR; may be empty
    std::string system_directory = "/run";
    bool root = false;

    /// The directories of this process, from its environment.
    static SocketDirectories of_this_process();
};

/// Path of the socket for the configuration file `config`: `control` in the service's own
/// directory, else `tribus/NAME.sock` in the directory of the system or the user; NAME is the file
/// name without extension. Nothing if there is no such directory. Pure.
std::optional<std::string> default_socket(const SocketDirectories& directories,
                                          const std::string& config);

/// Path of the socket of the same daemon that only tells, for who may look but not change:
/// `tribus-look/NAME.look` beside the folder `tribus` if a service has its control socket in
/// `tribus/NAME/control`, because that folder is for other users; else beside the control socket,
/// `look` or `NAME.look`. Pure.
std::string look_socket(const std::string& control);

/// The file from which the daemon with that socket reads a draft: in a folder of its own beside the
/// socket. Pure.
std::string draft_file(const std::string& socket);

/// A listening local socket that only its user and group may use. Its destructor removes the file,
/// unless another socket has replaced it.
class LocalListener {
  public:
    /// Creates the directory, too. Replaces a socket on which nobody answers any more. The error is
    /// a sentence.
    static tl::expected<LocalListener, std::string> open(const std::string& path);
    LocalListener(LocalListener&& other) noexcept
        : descriptor_(std::move(other.descriptor_)),
          path_(std::exchange(other.path_, {})),
          inode_(other.inode_) {}
    LocalListener& operator=(LocalListener&& other) noexcept = delete;
    LocalListener(const LocalListener&) = delete;
    LocalListener& operator=(const LocalListener&) = delete;
    ~LocalListener();

    /// To be moved from by the server, which closes it.
    UniqueFd& descriptor() { return descriptor_; }
    const std::string& path() const { return path_; }

  private:
    LocalListener(UniqueFd descriptor, std::string path)
        : descriptor_(std::move(descriptor)), path_(std::move(path)) {}

    UniqueFd descriptor_;
    std::string path_;
    std::uint64_t inode_ = 0;
};

/// Connects without blocking. The error is an errno value.
tl::expected<UniqueFd, int> connect_local(const std::string& path);

/// A socket on which a daemon answers.
struct FoundSocket {
    std::string name;  ///< of the daemon, as in `default_socket`
    std::string path;
};
/// The control sockets of all daemons in the default places that this user may use, ordered by
/// name.
std::vector<FoundSocket> find_sockets(const SocketDirectories& directories);
/// The same to look only: the sockets that only tell, and the control sockets of daemons that have
/// no such socket.
std::vector<FoundSocket> find_telling_sockets(const SocketDirectories& directories);

}  // namespace tribus
