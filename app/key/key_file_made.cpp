#include "app/key/key_file_made.h"

#include <fcntl.h>
#include <grp.h>
#include <nettle/sha2.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>

#include <fmt/format.h>

#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

using Failed = tl::unexpected<std::string>;

constexpr mode_t kOwnerOnly = 0600;
constexpr mode_t kOwnerAndGroup = 0640;

std::string digits_of(std::span<const std::uint8_t> bytes) {
    std::string digits;
    for (const std::uint8_t byte : bytes) {
        digits += fmt::format("{:02x}", byte);
    }
    return digits;
}

/// Lets the service read the file, as far as this user may do that and the machine has the service.
bool give_to_service(int file) {
    const struct group* group = ::getgrnam(std::string(kKeyGroup).c_str());
    return ::geteuid() == 0 && group != nullptr &&
           ::fchown(file, static_cast<uid_t>(-1), group->gr_gid) == 0 &&
           ::fchmod(file, kOwnerAndGroup) == 0;
}

bool write_digits(int file, const SecretKey& secret) {
    std::string line = digits_of(secret) + "\n";
    const bool written =
        ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
        ::fsync(file) == 0;
    ::explicit_bzero(line.data(), line.size());
    return written;
}

std::string why_not_made(const std::filesystem::path& path, int error) {
    const std::string folder =
        path.has_parent_path() ? path.parent_path().string() : std::string(".");
    switch (error) {
        case EEXIST:
            return fmt::format("{}: is there already, and stays as it is; name another file",
                               path.string());
        case ENOENT:
            return fmt::format("{}: no folder is called {}; run: sudo install -d {}", path.string(),
                               folder, folder);
        case EACCES:
            return fmt::format("{}: this user may not write into {}; use sudo", path.string(),
                               folder);
        default:
            return fmt::format("{}: cannot be written: {}", path.string(), std::strerror(error));
    }
}

}  // namespace

std::string fingerprint(const SecretKey& secret) {
    constexpr std::string_view kPurpose = "tribus key fingerprint";
    constexpr std::size_t kShownBytes = 8;
    sha256_ctx hash;
    sha256_init(&hash);
    sha256_update(&hash, kPurpose.size(), reinterpret_cast<const std::uint8_t*>(kPurpose.data()));
    sha256_update(&hash, secret.size(), secret.data());
    std::array<std::uint8_t, kShownBytes> first{};
    sha256_digest(&hash, first.size(), first.data());
    ::explicit_bzero(&hash, sizeof hash);
    const std::string digits = digits_of(first);
    return fmt::format("{}-{}-{}-{}", digits.substr(0, 4), digits.substr(4, 4), digits.substr(8, 4),
                       digits.substr(12));
}

tl::expected<MadeKeyFile, std::string> make_key_file(const std::filesystem::path& path) {
    MadeKeyFile made;
    if (::getrandom(made.secret.data(), made.secret.size(), 0) !=
        static_cast<ssize_t>(made.secret.size())) {
        return Failed(fmt::format("the kernel gives no random bytes: {}", std::strerror(errno)));
    }
    const UniqueFd file(
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kOwnerOnly));
    if (!file.valid()) {
        return Failed(why_not_made(path, errno));
    }
    if (::fchmod(file.get(), kOwnerOnly) != 0 || !write_digits(file.get(), made.secret)) {
        const int error = errno;
        ::unlink(path.c_str());
        return Failed(why_not_made(path, error));
    }
    made.service_reads = give_to_service(file.get());
    return made;
}

}  // namespace tribus
