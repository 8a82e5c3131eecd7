#pragma once

#include <linux/rtnetlink.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <string_view>
#include <vector>

/// Messages about network interfaces as the kernel makes them (rtnetlink).
namespace tribus::test::netlink {

using Bytes = std::vector<std::byte>;

template <typename T>
Bytes bytes_of(const T& value) {
    Bytes bytes(sizeof value);
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

/// The text with a zero behind it.
inline Bytes bytes_of(const char* text) {
    Bytes bytes;
    for (const char letter : std::string_view(text)) {
        bytes.push_back(static_cast<std::byte>(letter));
    }
    bytes.push_back(std::byte{0});
    return bytes;
}

inline Bytes joined(std::initializer_list<Bytes> parts) {
    Bytes all;
    for (const Bytes& part : parts) {
        std::ranges::copy(part, std::back_inserter(all));
    }
    return all;
}

inline Bytes padded(Bytes bytes) {
    bytes.resize((bytes.size() + 3) / 4 * 4);
    return bytes;
}

inline Bytes attribute(unsigned type, const Bytes& payload) {
    rtattr head{};
    head.rta_type = static_cast<unsigned short>(type);
    head.rta_len = static_cast<unsigned short>(sizeof head + payload.size());
    return padded(joined({bytes_of(head), payload}));
}

inline Bytes message(std::uint16_t type, const Bytes& payload, std::uint16_t flags = 0) {
    nlmsghdr head{};
    head.nlmsg_type = type;
    head.nlmsg_flags = flags;
    head.nlmsg_len = static_cast<std::uint32_t>(sizeof head + payload.size());
    return joined({bytes_of(head), payload});
}

}  // namespace tribus::test::netlink
