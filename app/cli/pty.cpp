#include "app/cli/pty.h"

#include <fcntl.h>
#include <stdlib.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace tribus {

tl::expected<Pty, std::string> Pty::open() {
    Pty pty;
    pty.master = UniqueFd(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    std::array<char, 64> path{};
    if (!pty.master.valid() || ::grantpt(pty.master.get()) != 0 ||
        ::unlockpt(pty.master.get()) != 0 ||
        ::ptsname_r(pty.master.get(), path.data(), path.size()) != 0) {
        return tl::unexpected(std::string("cannot make a pseudo-terminal: ") +
                              std::strerror(errno));
    }
    pty.path = path.data();
    return pty;
}

}  // namespace tribus
