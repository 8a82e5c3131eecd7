#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/shell.h"
#include "tests/support/streams.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

/// Compares our DBC reader with an independent one: canmatrix (Debian: python3-canmatrix) reads the
/// same random text and decodes the same random frames.
namespace tribus::canmatrix_test {
namespace {

using nlohmann::json;
using test::Bytes;
using test::Random;
using test::run_in_shell;
using test::TemporaryFolder;

// Debian's interpreter: another python3 earlier in PATH would not find Debian's packages.
constexpr std::string_view kPython = "/usr/bin/python3";
constexpr unsigned kMessages = 300;
constexpr unsigned kFramesPerMessage = 6;

/// A DBC text to which random messages are added.
class RandomDbc {
  public:
    explicit RandomDbc(std::uint32_t seed) : random_(seed) {}

    void add_message(unsigned index) {
        constexpr std::array<unsigned, 12> kLengths{1, 2, 4, 7, 8, 8, 8, 12, 20, 32, 48, 64};
        const bool extended = random_.below(2) == 0;
        // The index times an odd number, modulo the number of ids, gives different ids.
        id_ = extended ? 0x80000000U | ((index * 7919003U) & 0x1FFFFFFFU) : (index * 611U) & 0x7FFU;
        length_ = pick(kLengths);
        prefix_ = fmt::format("M{}", index);
        messages_ += fmt::format("\nBO_ {} {}: {} Sender\n", id_, prefix_, length_);
        const unsigned format = (extended ? 1U : 0U) + (length_ > 8 ? 14U : 0U);
        attributes_ += fmt::format("BA_ \"VFrameFormat\" BO_ {} {};\n", id_, format);
        if (random_.below(3) != 0) {
            attributes_ +=
                fmt::format("BA_ \"GenMsgCycleTime\" BO_ {} {};\n", id_, random_.below(1000));
        }
        switch (length_ < 4 ? 0 : random_.below(4)) {
            case 0:
                add_signals("", "", 1 + random_.below(8));
                add_float();
                break;
            case 1:
                add_simple_multiplexing();
                break;
            case 2:
                add_nested_multiplexing();
                break;
            default:
                add_signals("", "", 1 + random_.below(8));
        }
    }

    std::string text() const {
        return "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Sender Receiver\n" + messages_ +
               "\nBA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n"
               "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\","
               "\"J1939PG\",\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\","
               "\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\","
               "\"StandardCAN_FD\",\"ExtendedCAN_FD\";\n"
               "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;\nBA_DEF_DEF_ \"VFrameFormat\" "
               "\"StandardCAN\";\n" +
               attributes_;
    }

  private:
    template <class Values>
    typename Values::value_type pick(const Values& values) {
        return values[random_.below(static_cast<std::uint32_t>(std::size(values)))];
    }

    void add_signal(const std::string& name, const std::string& mark, unsigned bits) {
        const bool intel = random_.below(2) == 0;
        // Bits before the signal along the wire. Motorola numbers the bits of a byte downwards.
        const unsigned before = random_.below(length_ * 8 - bits + 1);
        const unsigned start = intel ? before : before / 8 * 8 + 7 - before % 8;
        add_line(name, mark, start, bits, intel);
    }

    void add_line(const std::string& name, const std::string& mark, unsigned start, unsigned bits,
                  bool intel) {
        constexpr std::array<const char*, 9> kFactors{"1",    "0.5",    "0.125", "-1", "10",
                                                      "1E-3", "0.3048", "0.01",  "0.1"};
        constexpr std::array<const char*, 6> kOffsets{"0", "0", "476", "-40", "-0.5", "1000"};
        const bool selector = mark.ends_with('M');
        messages_ += fmt::format(" SG_ {}_{} {}: {}|{}@{}{} ({},{}) [0|0] \"us\" Receiver\n",
                                 prefix_, name, mark.empty() ? "" : mark + " ", start, bits,
                                 intel ? 1 : 0, !selector && random_.below(2) == 0 ? "-" : "+",
                                 selector ? "1" : pick(kFactors), selector ? "0" : pick(kOffsets));
    }

    void add_signals(const std::string& group, const std::string& mark, unsigned count) {
        for (unsigned at = 0; at < count; ++at) {
            const unsigned longest = std::min(length_ * 8, kLongestDbcSignal);
            add_signal(fmt::format("{}S{}", group, at), mark, 1 + random_.below(longest));
        }
    }

    void add_float() {
        const unsigned bits = random_.below(2) == 0 ? 32 : 64;
        if (bits <= length_ * 8) {
            add_signal("Float", "", bits);
            attributes_ += fmt::format("SIG_VALTYPE_ {} {}_Float : {};\n", id_, prefix_, bits / 32);
        }
    }

    /// Adds selectors of two bits in the first byte, so that each page is selected often.
    void add_simple_multiplexing() {
        add_line("Page", "M", 0, 2, true);
        add_signals("Always", "", 2);
        for (unsigned page = 0; page < 3; ++page) {
            add_signals(fmt::format("P{}", page), fmt::format("m{}", page), 2);
        }
    }

    void add_nested_multiplexing() {
        add_line("Outer", "M", 1, 2, false);
        add_line("Inner", "m3M", 2, 2, true);
        add_signals("Out", "m1", 2);
        add_signals("In", "m0", 2);
        const auto depends = [&](const std::string& name, const char* selector,
                                 const char* ranges) {
            attributes_ += fmt::format("SG_MUL_VAL_ {} {}_{} {}_{} {};\n", id_, prefix_, name,
                                       prefix_, selector, ranges);
        };
        depends("InS0", "Inner", "0-1");
        depends("InS1", "Inner", "0-0, 2-3");
        depends("Inner", "Outer", "3-3");
        depends("OutS0", "Outer", "1-1");
        depends("OutS1", "Outer", "1-2");
    }

    Random random_;
    std::string messages_;
    std::string attributes_;
    std::string prefix_;
    std::uint32_t id_ = 0;
    unsigned length_ = 0;
};

Bytes random_data(Random& random, std::size_t length) {
    Bytes data(length);
    for (std::uint8_t& byte : data) {
        byte = random.byte();
    }
    return data;
}

double number(const json& value) {
    return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
}

void expect_same_number(double ours, double theirs, double tolerance) {
    if (std::isfinite(theirs)) {
        EXPECT_NEAR(ours, theirs, tolerance);
    } else {
        EXPECT_EQ(std::isnan(ours), std::isnan(theirs));
        EXPECT_TRUE(std::isnan(theirs) || ours == theirs) << ours << " " << theirs;
    }
}

void expect_same_signal(const DbcSignal& signal, const Bytes& data, const json& theirs) {
    SCOPED_TRACE(signal.name);
    const DbcLayout layout(signal);
    const std::uint64_t bits = layout.raw_bits(data);
    const json& raw = theirs.at("raw");
    if (signal.kind != DbcValueKind::integer) {
        const double value = signal.kind == DbcValueKind::float32
                                 ? double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))}
                                 : std::bit_cast<double>(bits);
        expect_same_number(value, number(raw), 0);
    } else if (signal.is_signed) {
        EXPECT_EQ(layout.raw_value(bits), raw.get<std::int64_t>());
    } else {
        EXPECT_EQ(bits, raw.get<std::uint64_t>());
    }
    // canmatrix computes in decimals; our value may differ by its two roundings.
    const double physical = number(theirs.at("physical"));
    expect_same_number(layout.physical(bits), physical,
                       4e-16 * (std::abs(physical) + std::abs(signal.offset)));
}

void expect_same_frame(const DbcMessage& message, const Bytes& data, const json& theirs) {
    SCOPED_TRACE(message.name + fmt::format(" {:02x}", fmt::join(data, "")));
    EXPECT_EQ(message.name, theirs.at("message").get<std::string>());
    EXPECT_EQ(message.length, theirs.at("length").get<unsigned>());
    EXPECT_EQ(message.fd, theirs.at("fd").get<bool>());
    EXPECT_EQ(message.cycle_time.value_or(Duration{}),
              std::chrono::milliseconds(theirs.at("cycle_time_ms").get<int>()));
    std::size_t found = 0;
    for (const DbcSignal& signal : message.signals) {
        const bool ours = present(message, signal, data);
        ASSERT_EQ(ours, theirs.at("signals").contains(signal.name)) << signal.name;
        if (ours) {
            ++found;
            expect_same_signal(signal, data, theirs.at("signals").at(signal.name));
        }
    }
    EXPECT_EQ(found, theirs.at("signals").size());
}

class Canmatrix : public testing::TestWithParam<std::uint32_t> {
  protected:
    void SetUp() override {
        const std::string answer =
            run_in_shell(fmt::format("{} -c 'import canmatrix; print(\"found\")'", kPython)).output;
        ASSERT_NE(answer.find("found"), std::string::npos)
            << "canmatrix is missing (Debian: python3-canmatrix): " << answer;
    }
};

TEST_P(Canmatrix, DecodesRandomFramesOfRandomTextsToTheSameValues) {
    RandomDbc dbc(GetParam());
    for (unsigned index = 0; index < kMessages; ++index) {
        dbc.add_message(index);
    }
    const auto file = parse_dbc(dbc.text());
    ASSERT_TRUE(file) << file.error().line << ": " << file.error().text;
    ASSERT_EQ(file->messages.size(), kMessages);

    Random random(GetParam() + 1000);
    std::vector<std::pair<const DbcMessage*, Bytes>> frames;
    std::string frame_lines;
    for (unsigned at = 0; at < kMessages * kFramesPerMessage; ++at) {
        const DbcMessage& message = file->messages[at % kMessages];
        frames.emplace_back(&message, random_data(random, message.length));
        frame_lines += fmt::format("{} {:02x}\n", message.id | (message.extended ? 1U << 31U : 0U),
                                   fmt::join(frames.back().second, ""));
    }
    const TemporaryFolder folder;
    const std::string output =
        run_in_shell(fmt::format("{} '{}/tests/oracle/canmatrix_decode.py' '{}' '{}'", kPython,
                                 TRIBUS_SOURCE_DIR, folder.write("network.dbc", dbc.text()),
                                 folder.write("frames.txt", frame_lines)))
            .output;
    std::istringstream lines(output);
    std::size_t read = 0;
    for (std::string line; std::getline(lines, line) && read < frames.size();) {
        if (!line.starts_with('{')) {
            continue;  // canmatrix reports formats whose library is missing
        }
        const json theirs = json::parse(line, nullptr, false);
        ASSERT_FALSE(theirs.is_discarded()) << line;
        expect_same_frame(*frames[read].first, frames[read].second, theirs);
        ASSERT_FALSE(HasFailure());
        ++read;
    }
    EXPECT_EQ(read, frames.size()) << output.substr(0, 2000);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Canmatrix, testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace tribus::canmatrix_test
