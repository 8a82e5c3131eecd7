#include "tests/support/far_end.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <stdexcept>
#include <system_error>

namespace tribus::test {

FarEnd::FarEnd(const std::filesystem::path& path) : path_(path) {
    plug_in();
}

void FarEnd::plug_in() {
    master_ = UniqueFd(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    std::array<char, 64> name{};
    if (!master_.valid() || ::grantpt(master_.get()) != 0 || ::unlockpt(master_.get()) != 0 ||
        ::ptsname_r(master_.get(), name.data(), name.size()) != 0) {
        throw std::runtime_error("cannot open a pseudo-terminal");
    }
    std::filesystem::create_symlink(name.data(), path_);
}

void FarEnd::pull() {
    // The name goes first: another test's pty may get the freed number at once.
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    master_ = UniqueFd();
}

bool FarEnd::send(std::span<const std::uint8_t> bytes) {
    const ssize_t taken = ::write(master_.get(), bytes.data(), bytes.size());
    return taken == static_cast<ssize_t>(bytes.size());
}

Bytes FarEnd::receive() {
    Bytes all;
    std::array<std::uint8_t, 4096> buffer{};
    ssize_t count = 0;
    while (master_.valid() && (count = ::read(master_.get(), buffer.data(), buffer.size())) > 0) {
        all.insert(all.end(), buffer.begin(), buffer.begin() + count);
    }
    return all;
}

}  // namespace tribus::test
