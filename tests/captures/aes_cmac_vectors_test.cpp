#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/authenticated/link_keys.h"

/// The examples of RFC 4493 (tests/vectors/aes_cmac.json).
namespace tribus::aes_cmac_vectors_test {
namespace {

using nlohmann::json;

TEST(AesCmacVectors, HaveTheMacOfTheStandardHoweverTheyAreCutInTwo) {
    std::size_t vectors = 0;
    for (const json& vector : test::vectors("aes_cmac.json")) {
        if (vector.at("protocol") != "aes_cmac") {
            continue;
        }
        ++vectors;
        const auto bytes_of = [&](const char* name) {
            return test::from_hex(vector.at(name).get<std::string>());
        };
        const auto key = bytes_of("key_hex");
        const auto message = bytes_of("bytes_hex");
        const auto mac = bytes_of("mac_hex");
        ASSERT_EQ(key.size(), authenticated::kMacBytes);
        authenticated::Mac cmac(
            std::span<const std::uint8_t>(key).first<authenticated::kMacBytes>());
        for (std::size_t cut = 0; cut <= message.size(); ++cut) {
            const std::span<const std::uint8_t> whole(message);
            EXPECT_TRUE(std::ranges::equal(cmac.of(whole.first(cut), whole.subspan(cut)), mac));
            EXPECT_TRUE(cmac.is_right(mac, whole.first(cut), whole.subspan(cut)));
        }
        for (std::size_t length = 0; length < mac.size(); ++length) {
            EXPECT_FALSE(cmac.is_right(std::span(mac).first(length), message)) << "a part of it";
        }
    }
    EXPECT_EQ(vectors, 3U);
}

}  // namespace
}  // namespace tribus::aes_cmac_vectors_test
