#include "config/language/key_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>

#include "config/language/read_file.h"
#include "core/quotes.h"

namespace tribus {
namespace {

constexpr std::size_t kSecretBytes = kSecretKeyBytes;
constexpr std::size_t kSecretDigits = 2 * kSecretBytes;
/// More than a key file has, its end of line included.
constexpr std::size_t kMostKeyFileBytes = kSecretDigits + 3;

std::optional<SecretKey> secret_of_digits(std::string_view digits) {
    SecretKey secret{};
    for (std::size_t i = 0; i < kSecretBytes; ++i) {
        const char* const from = digits.data() + 2 * i;
        // A sign is no digit, but would be read.
        const auto read = std::from_chars(from, from + 2, secret[i], 16);
        if (*from == '-' || read.ptr != from + 2) {
            return std::nullopt;
        }
    }
    return secret;
}

/// Nothing if it is neither 32 bytes nor 64 hexadecimal digits.
std::optional<SecretKey> secret_of(std::string_view content) {
    if (content.size() == kSecretBytes) {
        SecretKey secret{};
        std::ranges::copy(content, secret.begin());
        return secret;
    }
    for (const std::string_view end_of_line : {"\n", "\r"}) {
        if (content.ends_with(end_of_line)) {
            content.remove_suffix(1);
        }
    }
    return content.size() == kSecretDigits ? secret_of_digits(content) : std::nullopt;
}

std::string wrong_content(const std::string& content) {
    const std::string bytes = content.size() == kMostKeyFileBytes
                                  ? fmt::format("more than {} bytes", content.size() - 1)
                                  : fmt::format("{} bytes", content.size());
    return fmt::format("it has {} that are no key", bytes);
}

bool secrets_forbidden = false;

/// Stands for the secret of a file that is not read: another one for each file.
SecretKey stand_in(const std::filesystem::path& path) {
    SecretKey secret{};
    secret.front() = 1;
    std::size_t at = 0;
    for (const char c : path.lexically_normal().string()) {
        constexpr unsigned kFactor = 31;
        std::uint8_t& byte = secret[1 + at++ % (secret.size() - 1)];
        byte = static_cast<std::uint8_t>(byte * kFactor + static_cast<unsigned char>(c));
    }
    return secret;
}

/// Why a key file cannot be used.
struct Fault {
    std::string reason;
    bool out_of_reach = false;  ///< another time, or another user, may read it
};

/// A copy of a secret in memory that was given back could be in a core dump.
class Clearing {
  public:
    explicit Clearing(std::string& text) : text_(text) {}
    Clearing(const Clearing&) = delete;
    Clearing& operator=(const Clearing&) = delete;
    ~Clearing() { ::explicit_bzero(text_.data(), text_.size()); }

  private:
    std::string& text_;
};

tl::expected<SecretKey, Fault> secret_in(const std::filesystem::path& path) {
    auto content = read_file(path, kMostKeyFileBytes, FileKinds::secret);
    if (!content) {
        return tl::unexpected(Fault{content.error(), true});
    }
    const Clearing clears(*content);
    const auto secret = secret_of(*content);
    if (!secret) {
        return tl::unexpected(Fault{wrong_content(*content), false});
    }
    if (*secret == SecretKey{}) {
        return tl::unexpected(
            Fault{"a key of zeros switches signing off at other programs", false});
    }
    return *secret;
}

}  // namespace

tl::expected<SecretKey, std::string> read_secret(const std::filesystem::path& path) {
    return secret_in(path).map_error([](const Fault& fault) { return fault.reason; });
}

void forbid_secrets(bool forbidden) {
    secrets_forbidden = forbidden;
}

bool are_secrets_forbidden() {
    return secrets_forbidden;
}

std::optional<KeyFile> read_key_file(std::string_view key, const Value& value, Mistakes& mistakes) {
    const auto sentence = [&](std::string_view reason) {
        return fmt::format("{} is {}: {}; allowed: {}", in_quotes(key), describe(value), reason,
                           kAllowedKeyFile);
    };
    const auto* name = value.as<std::string>();
    if (name == nullptr || name->empty()) {
        mistakes.add(value.where, sentence("not the path of a file"));
        return std::nullopt;
    }
    const auto path = std::filesystem::path(mistakes.file()).parent_path() / *name;
    if (secrets_forbidden) {
        return KeyFile{*name, stand_in(path)};
    }
    const auto secret = secret_in(path);
    if (!secret && secret.error().out_of_reach) {
        mistakes.add_out_of_reach(value.where, sentence(secret.error().reason));
    } else if (!secret) {
        mistakes.add(value.where, sentence(secret.error().reason));
    }
    return secret ? std::optional(KeyFile{*name, *secret}) : std::nullopt;
}

}  // namespace tribus
