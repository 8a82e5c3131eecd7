#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dronecan/float16.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types.h"

/// Every data type with random values in all its fields, and with random bytes.
namespace tribus::dronecan::dronecan_types_property_test {
namespace {

using test::Bytes;
using test::Random;

constexpr int kRounds = 200;

/// Random values that the wire can hold, with extremes, and arrays of any length.
class RandomValues {
  public:
    explicit RandomValues(Random& random) : random_(random) {}

    template <class T>
    void structure(T& value) {
        if constexpr (Union<T>) {
            const std::size_t chosen = random_() % kAlternativeCount<T>;
            for_each_alternative<T>([&]<class Element>(const Alternative<Element>&, auto at) {
                if (at() == chosen) {
                    element(Element{}, value.held.template emplace<at()>());
                }
            });
        } else {
            for_each_field<T>([&]<class Item>(const Item& item, bool) {
                if constexpr (requires { item.member; }) {
                    element(typename Item::Element{}, value.*item.member);
                }
            });
        }
    }

  private:
    std::uint64_t bits(unsigned count) {
        const std::uint64_t value = (std::uint64_t{random_()} << 32U) | random_();
        const std::uint64_t all = ~std::uint64_t{0} >> (64 - count);
        const std::array<std::uint64_t, 4> extremes{0, all, all >> 1U, (all >> 1U) + 1};
        const bool extreme = random_() % 8 == 0;
        return (extreme ? extremes[random_() % extremes.size()] : value) & all;
    }

    template <unsigned kBits, Cast kCast, class Value>
    void element(Unsigned<kBits, kCast>, Value& value) {
        value = static_cast<Value>(bits(kBits));
    }
    template <unsigned kBits, class Value>
    void element(Signed<kBits>, Value& value) {
        value = static_cast<Value>(static_cast<std::int64_t>(bits(kBits) << (64 - kBits)) >>
                                   (64 - kBits));
    }
    void element(Boolean, bool& value) { value = bits(1) != 0; }
    void element(Float16, float& value) {
        value = known(float_from_float16(static_cast<std::uint16_t>(bits(16))));
    }
    void element(Float32, float& value) {
        value = known(std::bit_cast<float>(static_cast<std::uint32_t>(bits(32))));
    }
    /// Replaces NaN, which equals nothing.
    static float known(float value) { return std::isnan(value) ? 0.5F : value; }
    template <class T>
    void element(Nested, T& value) {
        structure(value);
    }
    template <class Element, class Value, std::size_t kSize>
    void element(ArrayOf<Element>, std::array<Value, kSize>& items) {
        for (Value& item : items) {
            element(Element{}, item);
        }
    }
    template <class Element, class Value, std::size_t kMost>
    void element(ArrayOf<Element>, BoundedArray<Value, kMost>& items) {
        items.resize(random_() % (kMost + 1));
        for (Value& item : items) {
            element(Element{}, item);
        }
    }

    Random& random_;
};

template <class T>
Bytes written(const T& value, bool fd) {
    const auto payload = write(value, fd);
    return {payload.begin(), payload.end()};
}

/// Reads from a heap block of the exact size, so that a sanitizer sees reads past the end.
template <class T>
std::optional<T> read_exactly(const Bytes& bytes, bool fd) {
    const auto copy = std::make_unique<std::uint8_t[]>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), copy.get());
    return read<T>(std::span<const std::uint8_t>(copy.get(), bytes.size()), fd);
}

TEST(DroneCanTypesProperty, WhatIsWrittenIsReadAsItWasOnClassicCanAndOnFd) {
    Random random(1);
    for_each_payload_type([&]<class T>() {
        for (int round = 0; round < kRounds; ++round) {
            T value;
            RandomValues(random).structure(value);
            for (const bool fd : {false, true}) {
                Bytes payload = written(value, fd);
                ASSERT_LE(payload.size(), kMostBytes<T>);
                ASSERT_EQ(read_exactly<T>(payload, fd), value)
                    << data_type_of<T>().name << (fd ? " on FD" : " on classic CAN");
                if (fd) {
                    payload.resize(payload.size() + random() % 17);
                    ASSERT_EQ(read_exactly<T>(payload, fd), value) << "a payload followed by zeros";
                }
            }
        }
    });
}

TEST(DroneCanTypesProperty, APayloadWithoutItsLastByteIsNotWhatItWas) {
    Random random(2);
    for_each_payload_type([&]<class T>() {
        for (int round = 0; round < kRounds; ++round) {
            T value;
            RandomValues(random).structure(value);
            for (const bool fd : {false, true}) {
                Bytes payload = written(value, fd);
                if (payload.empty()) {
                    continue;
                }
                payload.pop_back();
                const auto shorter = read_exactly<T>(payload, fd);
                ASSERT_TRUE(!shorter || (!fd && *shorter != value)) << data_type_of<T>().name;
            }
        }
    });
}

/// Any bytes are refused, or read as a value. That value is written as a payload of the same
/// length, which no further reading and writing changes. So only padding and the encoding of NaN
/// are lost.
TEST(DroneCanTypesProperty, AnyBytesAreRefusedOrAreAValueThatStays) {
    Random random(3);
    for_each_payload_type([&]<class T>() {
        for (int round = 0; round < kRounds; ++round) {
            Bytes payload(random() % (kMostBytes<T> + 4));
            std::generate(payload.begin(), payload.end(),
                          [&] { return static_cast<std::uint8_t>(random()); });
            for (const bool fd : {false, true}) {
                const auto value = read_exactly<T>(payload, fd);
                if (!value) {
                    continue;
                }
                const Bytes once = written(*value, fd);
                ASSERT_LE(once.size(), payload.size());
                if (!fd) {
                    ASSERT_EQ(once.size(), payload.size()) << data_type_of<T>().name;
                }
                const auto again = read_exactly<T>(once, fd);
                ASSERT_TRUE(again) << data_type_of<T>().name;
                ASSERT_EQ(written(*again, fd), once) << data_type_of<T>().name;
            }
        }
    });
}

/// For types without floats and padding fields, where every bit counts.
template <class T>
void expect_same_bytes(Random& random) {
    std::size_t accepted = 0;
    for (std::size_t size = 0; size <= kMostBytes<T>; ++size) {
        Bytes payload(size);
        std::generate(payload.begin(), payload.end(),
                      [&] { return static_cast<std::uint8_t>(random()); });
        const auto value = read_exactly<T>(payload, false);
        if (!value) {
            continue;
        }
        ++accepted;
        const Bytes once = written(*value, false);
        ASSERT_EQ(once.size(), size);
        ASSERT_TRUE(std::equal(once.begin(), once.end() - (size == 0 ? 0 : 1), payload.begin()))
            << data_type_of<T>().name << " except for the bits after its end";
    }
    EXPECT_GT(accepted, 0U);
}

TEST(DroneCanTypesProperty, BytesThatAreAcceptedAreWrittenAsTheyWere) {
    Random random(4);
    for (int round = 0; round < kRounds; ++round) {
        expect_same_bytes<RcInput>(random);
        expect_same_bytes<EscRawCommand>(random);
        expect_same_bytes<NodeStatus>(random);
        expect_same_bytes<Allocation>(random);
        expect_same_bytes<LogMessage>(random);
        expect_same_bytes<GetTransportStats::Response>(random);
        expect_same_bytes<ParamExecuteOpcode::Request>(random);
    }
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_types_property_test
