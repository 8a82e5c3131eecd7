#include "core/utf8.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

namespace tribus::utf8_test {
namespace {

TEST(Utf8, CharactersAreWrittenAndReadBack) {
    for (const char32_t character : {U'a', U'\u00e4', U'\u20ac', U'\U0001F600'}) {
        std::string text;
        append_utf8(text, character);
        EXPECT_EQ(utf8_length(text), text.size());
        EXPECT_EQ(utf8_character(text + "x"), character);
    }
}

TEST(Utf8, BytesThatAreNoCharacterHaveNoLength) {
    for (const std::string_view bytes :
         {"\x80", "\xC0\x80", "\xE4", "\xE2\x82", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
        EXPECT_EQ(utf8_length(bytes), 0U);
        EXPECT_FALSE(is_utf8(bytes));
    }
    EXPECT_TRUE(is_utf8("\u00e4 \u20ac"));
}

TEST(Utf8, BytesOfWindows1252HaveTheirCharacters) {
    EXPECT_EQ(windows_1252_character('a'), U'a');
    EXPECT_EQ(windows_1252_character('\xE4'), U'\u00e4');
    EXPECT_EQ(windows_1252_character('\x93'), U'\u201c');
    EXPECT_EQ(windows_1252_character('\x81'), kReplacementCharacter);
}

}  // namespace
}  // namespace tribus::utf8_test
