#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <numeric>
#include <utility>

#include <gtest/gtest.h>

#include "transports/codecs/authenticated/link_keys.h"
#include "transports/codecs/mavlink/signature.h"

/// Memory of what knows a key is cleared when it is given back.
namespace tribus::test::cleared_keys_test {
namespace {

SecretKey counted_secret() {
    SecretKey secret{};
    std::iota(secret.begin(), secret.end(), std::uint8_t{1});
    return secret;
}

/// How many bytes of a destroyed object are not zero.
template <class Object, class... Arguments>
std::size_t left_by(Arguments&&... arguments) {
    alignas(Object) static std::array<std::uint8_t, sizeof(Object)> memory{};
    auto* const object = new (memory.data()) Object(std::forward<Arguments>(arguments)...);
    EXPECT_NE(std::ranges::count(memory, 0), static_cast<std::ptrdiff_t>(memory.size()));
    std::destroy_at(object);
    // The compiler must not know what it holds.
    const volatile std::uint8_t* const bytes = memory.data();
    return static_cast<std::size_t>(
        std::count_if(bytes, bytes + memory.size(), [](std::uint8_t byte) { return byte != 0; }));
}

TEST(ClearedKeys, LeaveNothingInMemory) {
    const SecretKey secret = counted_secret();
    EXPECT_EQ(left_by<SecretKey>(secret), 0U);
    EXPECT_EQ(left_by<MavlinkHash>(secret), 0U);
    const authenticated::LinkKey key =
        authenticated::link_key(secret, authenticated::Purpose::hello, "boat");
    EXPECT_EQ(left_by<authenticated::LinkKey>(key), 0U);
    EXPECT_EQ(left_by<authenticated::Mac>(key), 0U);
    authenticated::Mac mac(key);
    EXPECT_EQ(left_by<authenticated::SnapshotMac>(mac, key), 0U);
}

}  // namespace
}  // namespace tribus::test::cleared_keys_test
