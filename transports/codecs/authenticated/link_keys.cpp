#include "transports/codecs/authenticated/link_keys.h"

#include <nettle/hmac.h>

#include <bit>
#include <cstring>

namespace tribus::authenticated {
namespace {

Mac mac_for(const SecretKey& secret, Purpose purpose, std::string_view link) {
    const LinkKey key = link_key(secret, purpose, link);
    Mac mac(key);
    // The first one brings the library's code into memory, before frames flow.
    static_cast<void>(mac.of(key));
    return mac;
}

/// Words are compared without a branch, so every wrong MAC takes the same time.
bool same_mac(std::span<const std::uint8_t> told, const MacBytes& right) {
    using Words = std::array<std::uint64_t, 2>;
    static_assert(sizeof(Words) == sizeof(MacBytes));
    if (told.size() != right.size()) {
        return false;
    }
    Words told_words{};
    std::memcpy(told_words.data(), told.data(), sizeof told_words);
    const auto right_words = std::bit_cast<Words>(right);
    return ((told_words[0] ^ right_words[0]) | (told_words[1] ^ right_words[1])) == 0;
}

}  // namespace

Mac::Mac(std::span<const std::uint8_t, kMacBytes> key) {
    cmac_aes128_set_key(&context_, key.data());
}

Mac::~Mac() {
    ::explicit_bzero(&context_, sizeof context_);
}

MacBytes Mac::of(std::span<const std::uint8_t> first, std::span<const std::uint8_t> second) {
    MacBytes mac{};
    write(mac, first, second);
    return mac;
}

void Mac::write(std::span<std::uint8_t, kMacBytes> mac, std::span<const std::uint8_t> first,
                std::span<const std::uint8_t> second) {
    cmac_aes128_update(&context_, first.size(), first.data());
    cmac_aes128_update(&context_, second.size(), second.data());
    // Begins anew, too.
    cmac_aes128_digest(&context_, mac.size(), mac.data());
}

bool Mac::is_right(std::span<const std::uint8_t> told, std::span<const std::uint8_t> first,
                   std::span<const std::uint8_t> second) {
    return same_mac(told, of(first, second));
}

LinkKey link_key(const SecretKey& secret, Purpose purpose, std::string_view link) {
    constexpr std::string_view kProtocol = "tribus authenticated link 1";
    const auto add = [](hmac_sha256_ctx& hash, std::string_view text) {
        hmac_sha256_update(&hash, text.size(), reinterpret_cast<const std::uint8_t*>(text.data()));
    };
    hmac_sha256_ctx hash;
    hmac_sha256_set_key(&hash, secret.size(), secret.data());
    add(hash, kProtocol);
    const auto letter = static_cast<std::uint8_t>(purpose);
    hmac_sha256_update(&hash, 1, &letter);
    add(hash, link);
    LinkKey key;
    hmac_sha256_digest(&hash, key.size(), key.data());
    ::explicit_bzero(&hash, sizeof hash);
    return key;
}

LinkMacs::LinkMacs(const SecretKey& secret, std::string_view link)
    : snapshot_keys(mac_for(secret, Purpose::snapshot, link)),
      challenge(mac_for(secret, Purpose::challenge, link)),
      hello(mac_for(secret, Purpose::hello, link)) {
    static_cast<void>(SnapshotMac(snapshot_keys, {}).of(0, {}));
}

SnapshotMac::SnapshotMac(Mac& keys, std::span<const std::uint8_t> answered) {
    std::array<std::uint8_t, POLY1305_AES_KEY_SIZE> key{};
    static_assert(key.size() == 2 * kMacBytes);
    const std::span<std::uint8_t, POLY1305_AES_KEY_SIZE> bytes(key);
    constexpr std::array<std::uint8_t, 1> kFirstHalf{'K'};
    constexpr std::array<std::uint8_t, 1> kSecondHalf{'R'};
    keys.write(bytes.first<kMacBytes>(), kFirstHalf, answered);
    keys.write(bytes.last<kMacBytes>(), kSecondHalf, answered);
    poly1305_aes_set_key(&context_, key.data());
    ::explicit_bzero(key.data(), key.size());
}

SnapshotMac::~SnapshotMac() {
    ::explicit_bzero(&context_, sizeof context_);
}

MacBytes SnapshotMac::of(std::uint16_t counter, std::span<const std::uint8_t> message) {
    const std::array<std::uint8_t, POLY1305_AES_NONCE_SIZE> number{
        static_cast<std::uint8_t>(counter), static_cast<std::uint8_t>(counter >> 8U)};
    poly1305_aes_set_nonce(&context_, number.data());
    poly1305_aes_update(&context_, message.size(), message.data());
    MacBytes mac{};
    poly1305_aes_digest(&context_, mac.size(), mac.data());
    return mac;
}

bool SnapshotMac::is_right(std::span<const std::uint8_t> told, std::uint16_t counter,
                           std::span<const std::uint8_t> message) {
    return same_mac(told, of(counter, message));
}

}  // namespace tribus::authenticated
