#pragma once

#include <nettle/cmac.h>
#include <nettle/poly1305.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "core/setting.h"

/// Authenticated links (docs/protocols/authenticated.md).
namespace tribus::authenticated {

inline constexpr std::size_t kMacBytes = 16;
using MacBytes = std::array<std::uint8_t, kMacBytes>;

/// AES-128-CMAC (RFC 4493), by nettle. Its memory is cleared at the end. No heap. Thread-bound.
class Mac {
  public:
    explicit Mac(std::span<const std::uint8_t, kMacBytes> key);
    Mac(const Mac&) = default;
    Mac& operator=(const Mac&) = default;
    ~Mac();

    /// MAC of both parts, one behind the other.
    MacBytes of(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second = {});
    /// The same where the MAC becomes a key: it leaves no copy.
    void write(std::span<std::uint8_t, kMacBytes> mac, std::span<const std::uint8_t> first,
               std::span<const std::uint8_t> second);
    /// Whether `told` is the whole MAC of both parts. A part of a MAC is wrong. Takes the same time
    /// for every wrong MAC.
    bool is_right(std::span<const std::uint8_t> told, std::span<const std::uint8_t> first,
                  std::span<const std::uint8_t> second = {});

  private:
    cmac_aes128_ctx context_{};
};

/// Random numbers of a seed: the MAC, by the seed, of a letter, a number and `more`.
template <std::size_t size>
std::array<std::uint8_t, size> random_bytes(Mac& seeded, std::uint8_t letter, std::uint32_t number,
                                            std::span<const std::uint8_t> more = {}) {
    const MacBytes all = seeded.of(
        std::array<std::uint8_t, 5>{
            letter, static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8U),
            static_cast<std::uint8_t>(number >> 16U), static_cast<std::uint8_t>(number >> 24U)},
        more);
    std::array<std::uint8_t, size> some{};
    std::copy_n(all.begin(), size, some.begin());
    return some;
}

/// The purposes of messages. Each has a key of its own, so that none can be taken for another, and
/// nothing that one end sends can be sent back to it.
enum class Purpose : std::uint8_t {
    snapshot = 'S',
    challenge = 'C',
    hello = 'H',
    broadcast = 'E',
};

/// A key that was made of a secret. Its memory is cleared at the end.
struct LinkKey : MacBytes {
    LinkKey() : MacBytes{} {}
    LinkKey(const LinkKey&) = default;
    LinkKey& operator=(const LinkKey&) = default;
    ~LinkKey() { ::explicit_bzero(data(), size()); }
};

/// The key of one purpose on one link: the first 128 bits of HMAC-SHA-256 by the secret, over
/// "tribus authenticated link 1", the purpose and the link's name. `link` names the link at both
/// ends, with its medium and its id there: two links with one secret have different keys.
LinkKey link_key(const SecretKey& secret, Purpose purpose, std::string_view link);

/// The MACs of one link, for either end.
struct LinkMacs {
    LinkMacs(const SecretKey& secret, std::string_view link);

    Mac snapshot_keys;  ///< see SnapshotMac
    Mac challenge;
    Mac hello;
};

/// MACs of the snapshots of one session that answer one challenge: Poly1305-AES (D. J. Bernstein,
/// "The Poly1305-AES message-authentication code", 2005), by nettle. On processors without AES
/// instructions it takes a third of the time of a CMAC. No two messages may have one number and one
/// key, or the key is lost: the number is the counter, and each challenge and session has a key of
/// its own. Its memory is cleared at the end. No heap. Thread-bound.
class SnapshotMac {
  public:
    /// `keys`: of the link. `answered`: nonce of the challenge, and the session.
    SnapshotMac(Mac& keys, std::span<const std::uint8_t> answered);
    SnapshotMac(const SnapshotMac&) = default;
    SnapshotMac& operator=(const SnapshotMac&) = default;
    ~SnapshotMac();

    /// MAC of the message with this counter. No two messages have the same one.
    MacBytes of(std::uint16_t counter, std::span<const std::uint8_t> message);
    /// See Mac::is_right.
    bool is_right(std::span<const std::uint8_t> told, std::uint16_t counter,
                  std::span<const std::uint8_t> message);

  private:
    poly1305_aes_ctx context_{};
};

}  // namespace tribus::authenticated
