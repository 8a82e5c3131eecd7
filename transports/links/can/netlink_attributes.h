#pragma once

#include <linux/rtnetlink.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <span>

/// Parts of messages of rtnetlink. Pure and reentrant, no heap.
namespace tribus {

/// The value at the beginning; nothing if the bytes are too few.
template <typename T>
std::optional<T> take(std::span<const std::byte> bytes) {
    if (bytes.size() < sizeof(T)) {
        return std::nullopt;
    }
    T value{};
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

/// Calls `each(type, payload)` for every attribute up to the first damaged one.
template <typename Each>
void for_attributes(std::span<const std::byte> bytes, Each each) {
    // The other bits are flags of the attribute.
    constexpr unsigned kTypeBits = 0x3FFF;
    while (const auto head = take<rtattr>(bytes)) {
        if (head->rta_len < sizeof(rtattr) || head->rta_len > bytes.size()) {
            return;
        }
        const auto type = head->rta_type & kTypeBits;
        each(type, bytes.subspan(sizeof(rtattr), head->rta_len - sizeof(rtattr)));
        bytes = bytes.subspan(std::min<std::size_t>(bytes.size(), RTA_ALIGN(head->rta_len)));
    }
}

}  // namespace tribus
