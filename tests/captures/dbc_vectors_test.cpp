
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

/// Frames that cantools decoded, and the DBC texts that describe them (dbc_vectors.json).
namespace tribus::dbc_vectors_test {
namespace {

using nlohmann::json;
using test::Bytes;
using test::from_hex;

class DbcVectors : public testing::Test {
  protected:
    void SetUp() override { vectors_ = test::vectors("dbc_vectors.json"); }

    DbcFile parsed(const char* name) const {
        auto file = parse_dbc(vectors_.at(name).get<std::string>());
        EXPECT_TRUE(file) << file.error().line << ": " << file.error().text;
        return file ? std::move(*file) : DbcFile{};
    }

    json vectors_;
};

/// Reads a number. Floats without a JSON number are strings: "nan", "inf", "-inf".
double number(const json& value) {
    return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
}

/// Compares two values. They may differ by what one more rounding, in another order, may cost.
void expect_same(double ours, double theirs, double magnitude, std::string_view name) {
    if (std::isnan(theirs)) {
        EXPECT_TRUE(std::isnan(ours)) << name;
    } else {
        EXPECT_NEAR(ours, theirs, 4e-16 * magnitude) << name;
    }
}

void expect_raw(const DbcSignal& signal, std::uint64_t bits, const json& expected) {
    if (signal.kind == DbcValueKind::integer) {
        EXPECT_EQ(DbcLayout(signal).raw_value(bits), expected.get<std::int64_t>()) << signal.name;
        return;
    }
    const double raw = signal.kind == DbcValueKind::float32
                           ? double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))}
                           : std::bit_cast<double>(bits);
    expect_same(raw, number(expected), 0, signal.name);
}

/// Checks that exactly the listed signals are in the frame, with the listed values.
void expect_decoded(const DbcMessage& message, const Bytes& data, const json& vector) {
    const json& physical = vector.at("phys");
    std::size_t found = 0;
    for (const DbcSignal& signal : message.signals) {
        ASSERT_EQ(present(message, signal, data), physical.contains(signal.name)) << signal.name;
        if (!physical.contains(signal.name)) {
            continue;
        }
        ++found;
        const DbcLayout layout(signal);
        const std::uint64_t bits = layout.raw_bits(data);
        const double expected = number(physical.at(signal.name));
        expect_same(layout.physical(bits), expected, std::abs(expected) + std::abs(signal.offset),
                    signal.name);
        if (vector.contains("raw")) {
            expect_raw(signal, bits, vector.at("raw").at(signal.name));
        }
    }
    EXPECT_EQ(found, physical.size());
}

/// Checks that writing the decoded values into an empty and a full frame restores the same bits.
void expect_encoded(const DbcMessage& message, const Bytes& data) {
    Bytes empty(data.size(), 0x00);
    Bytes full(data.size(), 0xFF);
    for (const DbcSignal& signal : message.signals) {
        const DbcLayout layout(signal);
        const std::uint64_t bits = layout.raw_bits(data);
        const double physical = layout.physical(bits);
        if (!present(message, signal, data) || std::isnan(physical)) {
            continue;
        }
        // A double cannot hold every integer above 2^53.
        if (signal.kind != DbcValueKind::integer || signal.bit_length <= 53) {
            EXPECT_EQ(layout.bits_from_physical(physical), bits) << signal.name;
        }
        layout.set_raw_bits(empty, bits);
        layout.set_raw_bits(full, bits);
        EXPECT_EQ(layout.raw_bits(empty), bits) << signal.name;
        EXPECT_EQ(layout.raw_bits(full), bits) << signal.name;
    }
    for (std::size_t at = 0; at < data.size(); ++at) {
        EXPECT_EQ(empty[at] & ~data[at], 0) << "byte " << at;
        EXPECT_EQ(data[at] & ~full[at], 0) << "byte " << at;
    }
}

void expect_all(const DbcFile& file, const json& vectors, std::size_t count) {
    ASSERT_EQ(vectors.size(), count);
    for (const json& vector : vectors) {
        const Bytes data = from_hex(vector.at("data").get<std::string>());
        SCOPED_TRACE(vector.at("message").get<std::string>() + " " +
                     vector.at("data").get<std::string>());
        const DbcMessage* const message = file.find(vector.at("message").get<std::string>());
        ASSERT_NE(message, nullptr);
        EXPECT_EQ(message->id, vector.at("frame_id").get<std::uint32_t>());
        EXPECT_EQ(message->extended, vector.value("extended", false));
        EXPECT_EQ(message->fd, vector.value("fd", false));
        EXPECT_EQ(message->length, data.size());
        if (vector.contains("cycle_time_ms")) {
            EXPECT_EQ(message->cycle_time,
                      std::chrono::milliseconds(vector.at("cycle_time_ms").get<int>()));
        }
        expect_decoded(*message, data, vector);
        expect_encoded(*message, data);
    }
}

TEST_F(DbcVectors, RandomMessages) {
    expect_all(parsed("random_dbc"), vectors_.at("random_vectors"), 150);
}

TEST_F(DbcVectors, MultiplexedMessages) {
    expect_all(parsed("mux_dbc"), vectors_.at("mux_vectors"), 24);
}

TEST_F(DbcVectors, NativeMessages) {
    expect_all(parsed("native_dbc"), vectors_.at("native_vectors"), 36);
}

TEST_F(DbcVectors, NativeMessagesHaveTheirDataIdsAndSwitchTheBitRateInFdFrames) {
    const DbcFile file = parsed("native_dbc");
    for (const json& vector : vectors_.at("native_vectors")) {
        const DbcMessage* const message = file.find(vector.at("message").get<std::string>());
        ASSERT_NE(message, nullptr);
        EXPECT_EQ(message->e2e_data_id, vector.at("data_id").get<std::uint32_t>());
        EXPECT_EQ(message->bit_rate_switch, message->fd) << message->name;
    }
}

TEST_F(DbcVectors, NativeValueTexts) {
    const DbcFile file = parsed("native_dbc");
    const DbcMessage* const message = file.find("RcE");
    ASSERT_NE(message, nullptr);
    ASSERT_NE(message->find("RcE_Source"), nullptr);
    EXPECT_EQ(message->find("RcE_Source")->value_texts.size(), 7U);
    EXPECT_EQ(message->find("RcE_Age")->value_texts,
              (std::vector<DbcValueText>{{255, "NotAvailable"}}));
}

}  // namespace
}  // namespace tribus::dbc_vectors_test
