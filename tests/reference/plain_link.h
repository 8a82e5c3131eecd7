#pragma once

#include <openssl/core_names.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

/// The MACs of a link with a key, written from docs/protocols/authenticated.md ("Messages", "Keys")
/// alone, with OpenSSL: the program has nettle. Plain: it allocates, and does not mind time.
namespace tribus::reference {

using LinkBytes = std::vector<std::uint8_t>;

inline LinkBytes joined(std::initializer_list<LinkBytes> parts) {
    LinkBytes all;
    for (const LinkBytes& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

inline LinkBytes letter(char name) {
    return {static_cast<std::uint8_t>(name)};
}

/// A MAC of 16 bytes by OpenSSL's "CMAC" (with a cipher) or "POLY1305".
inline LinkBytes openssl_mac(const char* name, const LinkBytes& key, const LinkBytes& message,
                             const char* cipher = nullptr) {
    EVP_MAC* const kind = EVP_MAC_fetch(nullptr, name, nullptr);
    EVP_MAC_CTX* const context = EVP_MAC_CTX_new(kind);
    std::array<char, 16> text{};
    std::string_view(cipher != nullptr ? cipher : "").copy(text.data(), text.size() - 1);
    const std::array parameters{
        cipher != nullptr ? OSSL_PARAM_construct_utf8_string(OSSL_MAC_PARAM_CIPHER, text.data(), 0)
                          : OSSL_PARAM_construct_end(),
        OSSL_PARAM_construct_end()};
    LinkBytes mac(16);
    std::size_t length = 0;
    EVP_MAC_init(context, key.data(), key.size(), parameters.data());
    EVP_MAC_update(context, message.data(), message.size());
    EVP_MAC_final(context, mac.data(), &length, mac.size());
    EVP_MAC_CTX_free(context);
    EVP_MAC_free(kind);
    return length == mac.size() ? mac : LinkBytes{};
}

inline LinkBytes aes_cmac(const LinkBytes& key, const LinkBytes& message) {
    return openssl_mac("CMAC", key, message, "AES-128-CBC");
}

inline LinkBytes aes_block(const LinkBytes& key, const LinkBytes& block) {
    EVP_CIPHER_CTX* const context = EVP_CIPHER_CTX_new();
    LinkBytes out(32);
    int length = 0;
    EVP_EncryptInit_ex(context, EVP_aes_128_ecb(), nullptr, key.data(), nullptr);
    EVP_EncryptUpdate(context, out.data(), &length, block.data(), static_cast<int>(block.size()));
    EVP_CIPHER_CTX_free(context);
    out.resize(16);
    return out;
}

/// Poly1305-AES by the key (k, r), as cr.yp.to/mac.html has it.
inline LinkBytes poly1305_aes(const LinkBytes& k, const LinkBytes& r, LinkBytes nonce,
                              const LinkBytes& message) {
    nonce.resize(16);
    return openssl_mac("POLY1305", joined({r, aes_block(k, nonce)}), message);
}

/// The keys of one link.
class PlainLink {
  public:
    PlainLink(LinkBytes key_file, std::string_view name)
        : key_file_(std::move(key_file)), name_(name.begin(), name.end()) {}

    /// Of a hello's bytes 0 to 7.
    LinkBytes hello_mac(const LinkBytes& body) const { return aes_cmac(key('H'), body); }
    /// Of a challenge's bytes 0 to 15. `session`: 3 bytes.
    LinkBytes challenge_mac(const LinkBytes& session, const LinkBytes& body) const {
        return aes_cmac(key('C'), joined({session, body}));
    }
    /// Of a snapshot's bytes 0 to 47.
    LinkBytes snapshot_mac(const LinkBytes& nonce, const LinkBytes& session,
                           const LinkBytes& body) const {
        return of_snapshot('S', joined({nonce, session}), {body[10], body[11]}, body);
    }
    /// Of a snapshot to receivers that do not answer, bytes 0 to 47.
    LinkBytes broadcast_mac(const LinkBytes& body) const { return aes_cmac(key('E'), body); }

  private:
    LinkBytes key(char purpose) const {
        constexpr std::string_view kText = "tribus authenticated link 1";
        const LinkBytes text = joined({{kText.begin(), kText.end()}, letter(purpose), name_});
        LinkBytes whole(32);
        HMAC(EVP_sha256(), key_file_.data(), static_cast<int>(key_file_.size()), text.data(),
             text.size(), whole.data(), nullptr);
        whole.resize(16);
        return whole;
    }
    LinkBytes of_snapshot(char purpose, const LinkBytes& keyed_by, const LinkBytes& nonce,
                          const LinkBytes& body) const {
        const LinkBytes by = key(purpose);
        return poly1305_aes(aes_cmac(by, joined({letter('K'), keyed_by})),
                            aes_cmac(by, joined({letter('R'), keyed_by})), nonce, body);
    }

    LinkBytes key_file_;
    LinkBytes name_;
};

}  // namespace tribus::reference
