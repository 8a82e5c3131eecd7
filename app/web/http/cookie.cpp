#include "app/web/http/cookie.h"

#include <openssl/evp.h>
#include <sys/random.h>

#include <array>
#include <cstdint>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tribus::web {
namespace {

constexpr std::size_t kCookieBytes = 32;

std::string in_hex(std::span<const std::uint8_t> bytes) {
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}

}  // namespace

tl::expected<std::string, std::string> new_cookie() {
    std::array<std::uint8_t, kCookieBytes> random{};
    if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
        return tl::unexpected(std::string("the kernel gives no random numbers"));
    }
    return in_hex(random);
}

std::string hash_of_cookie(std::string_view cookie) {
    std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
    unsigned length = 0;
    const bool hashed =
        cookie.size() == 2 * kCookieBytes && EVP_Digest(cookie.data(), cookie.size(), digest.data(),
                                                        &length, EVP_sha256(), nullptr) == 1;
    return hashed ? in_hex(std::span(digest).first(length)) : std::string();
}

}  // namespace tribus::web
