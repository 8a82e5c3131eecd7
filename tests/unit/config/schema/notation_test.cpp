#include "config/schema/notation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tribus::test::notation_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

TEST(FormatDuration, UsesTheLargestUnitThatNeedsNoFraction) {
    EXPECT_EQ(format_duration(seconds(2)), "2s");
    EXPECT_EQ(format_duration(milliseconds(14)), "14ms");
    EXPECT_EQ(format_duration(milliseconds(1500)), "1500ms");
    EXPECT_EQ(format_duration(microseconds(1500)), "1500us");
    EXPECT_EQ(format_duration(nanoseconds(1500)), "1.5us");
    EXPECT_EQ(format_duration(nanoseconds(0)), "0s");
}

RC_GTEST_PROP(FormatDuration, ParsesBackToTheSame, ()) {
    const Duration duration(*rc::gen::inRange<std::int64_t>(0, 60'000'000'000));
    RC_ASSERT(parse_duration(format_duration(duration)) == duration);
}

TEST(ParseSlew, TakesMicrosecondsASecondOnly) {
    EXPECT_EQ(parse_slew("2000us/s"), 2000.0);
    EXPECT_EQ(parse_slew("0.5us/s"), 0.5);
    EXPECT_EQ(parse_slew("2000us"), std::nullopt);
    EXPECT_EQ(parse_slew("2000 us/s"), std::nullopt);
    EXPECT_EQ(parse_slew("2ms/s"), std::nullopt);
    EXPECT_EQ(parse_slew(format_slew(1234.5)), 1234.5);
}

TEST(WrittenValue, StandsAsInAFile) {
    using enum SettingType;
    EXPECT_EQ(written(boolean, SettingValue(true)), "true");
    EXPECT_EQ(written(integer, SettingValue(std::int64_t{-5})), "-5");
    EXPECT_EQ(written(number, SettingValue(0.5)), "0.5");
    EXPECT_EQ(written(pulse, SettingValue(1500.0)), "1500");
    EXPECT_EQ(written(slew, SettingValue(2000.0)), "\"2000us/s\"");
    EXPECT_EQ(written(text, SettingValue(std::string("a\"b"))), R"("a\"b")");
    EXPECT_EQ(written(duration, SettingValue(Duration(milliseconds(14)))), "\"14ms\"");
    EXPECT_EQ(written(pulses, SettingValue(NumberRange{800, 2200.5})), "[800, 2200.5]");
    EXPECT_EQ(written(scale, SettingValue(TwoPoints{})), "");
    EXPECT_EQ(written(file, SettingValue(SettingFile{"a", "b"})), "");
}

SettingValue fallback(SettingType type, std::string_view text) {
    return default_of(Setting{.key = "k", .type = type, .fallback = text});
}

TEST(DefaultOfASetting, IsReadAsItsTypeSays) {
    using enum SettingType;
    EXPECT_EQ(fallback(boolean, "true"), SettingValue(true));
    EXPECT_EQ(fallback(boolean, "false"), SettingValue(false));
    EXPECT_EQ(fallback(integer, "-15"), SettingValue(std::int64_t{-15}));
    EXPECT_EQ(fallback(number, "2.5"), SettingValue(2.5));
    EXPECT_EQ(fallback(pulse, "1500"), SettingValue(1500.0));
    EXPECT_EQ(fallback(pulses, "[800.5, 2200]"), SettingValue(NumberRange{800.5, 2200}));
    EXPECT_EQ(fallback(slew, "\"2000us/s\""), SettingValue(2000.0));
    EXPECT_EQ(fallback(duration, "\"14ms\""), SettingValue(Duration(milliseconds(14))));
    for (const SettingType type : {text, choice, scale, file, key_file, tree}) {
        EXPECT_EQ(fallback(type, "\"abc\""), SettingValue(std::string("abc")));
    }
}

TEST(DefaultOfASetting, LosesQuotesAtBothEndsOnly) {
    const auto text = [](std::string_view content) { return fallback(SettingType::text, content); };
    EXPECT_EQ(text("\"\""), SettingValue(std::string()));
    EXPECT_EQ(text("\"a"), SettingValue(std::string("\"a")));
    EXPECT_EQ(text("a\""), SettingValue(std::string("a\"")));
    EXPECT_EQ(text("\""), SettingValue(std::string("\"")));
    EXPECT_EQ(text(""), SettingValue(std::string()));
}

TEST(DefaultOfASetting, IsZeroWhereItCannotBeRead) {
    EXPECT_EQ(fallback(SettingType::integer, "x"), SettingValue(std::int64_t{0}));
    EXPECT_EQ(fallback(SettingType::number, "x"), SettingValue(0.0));
    EXPECT_EQ(fallback(SettingType::slew, "x"), SettingValue(0.0));
    EXPECT_EQ(fallback(SettingType::duration, "x"), SettingValue(Duration{}));
}

TEST(InterfaceNameInTheNotation, HasOneToFifteenCharactersOfSome) {
    EXPECT_TRUE(is_interface_name("a"));
    EXPECT_TRUE(is_interface_name("123456789012345"));
    EXPECT_TRUE(is_interface_name("..."));
    EXPECT_FALSE(is_interface_name("1234567890123456"));
    for (const std::string_view wrong : {"", ".", "..", "/", "a/", "a:b", "a b", "a\t", "a\x7f"}) {
        EXPECT_FALSE(is_interface_name(wrong)) << wrong;
    }
}

TEST(SecondsOfADuration, HaveAFraction) {
    EXPECT_EQ(seconds_of(milliseconds(1500)), 1.5);
    EXPECT_EQ(seconds_of(nanoseconds(1)), 1e-9);
}

}  // namespace
}  // namespace tribus::test::notation_test
