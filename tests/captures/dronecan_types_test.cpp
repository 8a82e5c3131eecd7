#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types.h"

/// Payloads that three independent implementations agree on (dronecan_vectors.json).
namespace tribus::dronecan::dronecan_types_test {
namespace {

using nlohmann::json;
using test::Bytes;
using test::from_hex;

/// Reads the values of the file, which has the names of the type descriptions.
class FromJson {
  public:
    template <class T>
    static void structure(const json& from, T& value) {
        if constexpr (Union<T>) {
            for_each_alternative<T>([&]<class Element>(const Alternative<Element>& one, auto at) {
                if (from.contains(one.name)) {
                    element(Element{}, from.at(std::string(one.name)),
                            value.held.template emplace<at()>());
                }
            });
        } else {
            std::size_t named = 0;
            for_each_field<T>([&]<class Item>(const Item& item, bool) {
                if constexpr (requires { item.name; }) {
                    ++named;
                    element(typename Item::Element{}, from.at(std::string(item.name)),
                            value.*item.member);
                }
            });
            EXPECT_EQ(named, from.size()) << from;
        }
    }

  private:
    /// Integers too large for some JSON readers are texts: "0xDEADBEEF".
    template <unsigned kBits, Cast kCast, class Value>
    static void element(Unsigned<kBits, kCast>, const json& from, Value& value) {
        value =
            static_cast<Value>(from.is_string() ? std::stoull(from.get<std::string>(), nullptr, 0)
                                                : from.get<std::uint64_t>());
    }
    template <class Element, class Value>
    static void element(Element, const json& from, Value& value) {
        value = from.get<Value>();
    }
    template <class T>
    static void element(Nested, const json& from, T& value) {
        structure(from, value);
    }
    template <std::size_t kMost>
    static void element(ArrayOf<Unsigned<8>>, const json& from, BoundedText<kMost>& text) {
        text = BoundedText<kMost>(from.get<std::string>());
    }
    template <std::size_t kMost>
    static void element(ArrayOf<Unsigned<8>>, const json& from,
                        BoundedArray<std::uint8_t, kMost>& bytes) {
        for (const std::uint8_t byte : from_hex(from.get<std::string>())) {
            bytes.push_back(byte);
        }
    }
    static void element(ArrayOf<Unsigned<8>>, const json& from, UniqueId& id) {
        const Bytes bytes = from_hex(from.get<std::string>());
        ASSERT_EQ(bytes.size(), id.size());
        std::copy(bytes.begin(), bytes.end(), id.begin());
    }
    template <class Element, class Value, std::size_t kMost>
    static void element(ArrayOf<Element>, const json& from, BoundedArray<Value, kMost>& items) {
        for (const json& item : from) {
            Value value{};
            element(Element{}, item, value);
            items.push_back(value);
        }
    }
};

TransferKind kind_of(const json& transfer) {
    const std::string kind = transfer.at("transfer_kind");
    return kind == "request"    ? TransferKind::request
           : kind == "response" ? TransferKind::response
                                : TransferKind::message;
}

class DroneCanTypeVectors : public testing::Test {
  protected:
    void SetUp() override { vectors_ = test::vectors("dronecan_vectors.json"); }

    template <class T>
    void check() {
        constexpr DataType kType = data_type_of<T>();
        for (const json& transfer : vectors_.at("transfers")) {
            if (transfer.at("data_type") != kType.name || kind_of(transfer) != kType.kind) {
                continue;
            }
            SCOPED_TRACE(transfer.at("name").get<std::string>());
            checked_.insert(transfer.at("name"));
            EXPECT_EQ(transfer.at("data_type_id"), kType.id);
            EXPECT_EQ(std::stoull(transfer.at("signature").get<std::string>(), nullptr, 16),
                      kType.signature);
            T expected;
            FromJson::structure(transfer.at("fields"), expected);
            const Bytes payload = from_hex(transfer.at("payload_hex").get<std::string>());
            const bool fd = transfer.at("can_fd");
            EXPECT_EQ(read<T>(payload, fd), expected);
            const auto written = write(expected, fd);
            EXPECT_EQ(Bytes(written.begin(), written.end()), payload);
        }
    }

    json vectors_;
    std::set<std::string> checked_;
};

TEST_F(DroneCanTypeVectors, EveryPayloadIsReadAsItsFieldsAndTheseAreWrittenAsThePayload) {
    for_each_payload_type([&]<class T>() { check<T>(); });
    EXPECT_EQ(checked_.size(), vectors_.at("transfers").size());
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_types_test
