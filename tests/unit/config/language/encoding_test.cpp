#include "config/language/encoding.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::encoding_test {
namespace {

using Lines = std::vector<std::string>;

/// ASCII with `before` zeros before each letter and `behind` zeros behind it.
std::string widened(const std::string& text, std::size_t before, std::size_t behind) {
    std::string wide;
    for (const char letter : text) {
        wide += std::string(before, '\0') + letter + std::string(behind, '\0');
    }
    return wide;
}

std::string main_job() {
    return main_job_with(0, "");
}

std::string with_ends_of_line(std::string_view end) {
    std::string text;
    for (const char letter : main_job()) {
        text += letter == '\n' ? std::string(end) : std::string(1, letter);
    }
    return text;
}

struct Wide {
    std::string name;
    std::string bytes;
};

TEST(Encoding, WithSeveralBytesALetterIsNamedOnce) {
    const std::vector<Wide> files{
        {"UTF-16LE", widened(main_job(), 0, 1)},
        {"UTF-16LE", "\xFF\xFE" + widened(main_job(), 0, 1)},
        {"UTF-16LE", "\xFF\xFE"},
        {"UTF-16BE", widened(main_job(), 1, 0)},
        {"UTF-16BE", "\xFE\xFF" + widened(main_job(), 1, 0)},
        {"UTF-32LE", widened(main_job(), 0, 3)},
        {"UTF-32LE", std::string("\xFF\xFE\0\0", 4) + widened(main_job(), 0, 3)},
        {"UTF-32BE", widened(main_job(), 3, 0)},
        {"UTF-32BE", std::string("\0\0\xFE\xFF", 4) + widened(main_job(), 3, 0)},
    };
    for (const Wide& file : files) {
        EXPECT_EQ(mistakes_in(file.bytes),
                  Lines{"t.toml:1:1: the file is in " + file.name +
                        "; allowed: UTF-8. Save it in UTF-8, or convert it: iconv -f " + file.name +
                        " -t UTF-8"});
    }
}

TEST(Encoding, Utf16IsNamedAlsoIfTheTextHasSomeLettersBeyondAscii) {
    const std::string euro = "\xAC\x20";
    const std::string text =
        widened("# 5 ", 0, 1) + euro + widened(" a receiver\n" + main_job(), 0, 1);
    ASSERT_EQ(mistakes_in(text).size(), 1U);
    EXPECT_NE(mistakes_in(text)[0].find("UTF-16LE"), std::string::npos);
}

TEST(Encoding, ByteZeroIsNamedOnce) {
    EXPECT_EQ(mistakes_in(main_job() + std::string(3, '\0')),
              Lines{"t.toml:10:1: a byte 0, which no text has; allowed: a text file in UTF-8"});
}

TEST(Encoding, Windows1252IsNamedOnceAndRead) {
    const std::string text = "# Empf\xE4nger\n# f\xFCr\n" + main_job() + "colour = 1\n";
    const auto mistakes = mistakes_in(text);
    ASSERT_EQ(mistakes.size(), 2U);
    EXPECT_EQ(
        mistakes[0],
        "t.toml:1:7: byte 0xE4 is not UTF-8 (also in line 2); allowed: UTF-8. In Windows-1252 "
        "and ISO 8859-1 it is \u00e4: save the file in UTF-8, or convert it: iconv -f "
        "WINDOWS-1252 -t UTF-8");
    EXPECT_EQ(mistakes[1].substr(0, mistakes[1].find(';')),
              R"(t.toml:12:1: unknown key "colour" in [pipeline.main])");
}

TEST(Encoding, ANameBeyondAsciiIsNotMissingWhereItIsUsed) {
    const std::string text = "[input.empf\xE4nger]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n" +
                             main_job_with(8, "from = \"empf\xE4nger\"");
    for (const std::string& mistake : mistakes_in(text)) {
        EXPECT_EQ(mistake.find("no input is named"), std::string::npos) << mistake;
    }
}

TEST(Encoding, AByteOfNoEncodingIsNamed) {
    EXPECT_EQ(mistakes_in("# \x81\n" + main_job()),
              Lines{"t.toml:1:3: byte 0x81 is not UTF-8; allowed: a text file in UTF-8"});
}

TEST(Encoding, LinesMayEndWithLfOrCrLf) {
    EXPECT_EQ(mistakes_in(main_job()), Lines{});
    EXPECT_EQ(mistakes_in(with_ends_of_line("\r\n")), Lines{});
}

TEST(Encoding, CrAloneIsNamedOnceAndEndsALine) {
    const std::string text = with_ends_of_line("\r") + "colour = 1";
    const auto mistakes = mistakes_in(text);
    ASSERT_EQ(mistakes.size(), 2U);
    EXPECT_EQ(mistakes[0],
              "t.toml:1:17: the line ends with CR alone (also in lines 2, 3, 4, 5, 6 and 3 more); "
              "allowed: LF, or CR LF; save the file with Unix line ends, or convert it: tr '\\r' "
              "'\\n'");
    EXPECT_EQ(mistakes[1].substr(0, mistakes[1].find(';')),
              R"(t.toml:10:1: unknown key "colour" in [pipeline.main])");
}

TEST(Encoding, CrCrLfIsNamedOnceAndIsOneEndOfLine) {
    const auto mistakes = mistakes_in(with_ends_of_line("\r\r\n") + "colour = 1");
    ASSERT_EQ(mistakes.size(), 2U);
    EXPECT_TRUE(mistakes[0].starts_with("t.toml:1:17: the line ends with CR CR LF (also in lines "))
        << mistakes[0];
    EXPECT_TRUE(mistakes[1].starts_with("t.toml:10:1: unknown key \"colour\"")) << mistakes[1];
}

TEST(Encoding, AByteOrderMarkOfUtf8IsAllowed) {
    EXPECT_EQ(mistakes_in("\xEF\xBB\xBF" + main_job()), Lines{});
}

/// The text as UTF-8, and the mistakes as "line:column: text".
struct Decoded {
    explicit Decoded(const std::string& bytes) {
        Mistakes mistakes("f");
        std::string converted;
        const auto decoded = decoded_text(bytes, converted, mistakes);
        text = std::string(decoded.value_or("nothing"));
        is_copy = !converted.empty();
        for (const Mistake& mistake : mistakes.sorted()) {
            told.push_back(format_mistake(mistake).substr(2));
        }
    }
    std::string text;
    bool is_copy = false;
    Lines told;
};

TEST(DecodedText, IsTheTextItselfWhereItIsRight) {
    EXPECT_EQ(Decoded("a\n\u00e4\n").text, "a\n\u00e4\n");
    EXPECT_FALSE(Decoded("a\n\u00e4\n").is_copy);
    EXPECT_EQ(Decoded("").text, "");
    EXPECT_EQ(Decoded("\xEF\xBB\xBF x").text, " x");
    EXPECT_FALSE(Decoded("\xEF\xBB\xBF x").is_copy);
    EXPECT_EQ(Decoded("a\r\nb\r\n").text, "a\r\nb\r\n");
    EXPECT_EQ(Decoded("a\r\nb\r\n").told, Lines{});
}

TEST(DecodedText, HasOneEndForEachLine) {
    const Decoded decoded("a\r\rb\r\nc\r\r\nd\r");
    EXPECT_EQ(decoded.text, "a\n\nb\r\nc\r\nd\n");
    EXPECT_EQ(decoded.told,
              (Lines{"1:2: the line ends with CR alone (also in line 5); allowed: LF, or CR LF; "
                     "save the file with Unix line ends, or convert it: tr '\\r' '\\n'",
                     "4:2: the line ends with CR CR LF; allowed: LF, or CR LF; save the file with "
                     "Unix line ends"}));
}

TEST(DecodedText, HasALetterForEachByteThatIsNotUtf8) {
    const Decoded decoded("\u00e4\xE4\n \xF6\x80\n");
    EXPECT_EQ(decoded.text, "\u00e4\u00e4\n \u00f6\u20ac\n");
    EXPECT_EQ(decoded.told,
              Lines{"1:2: byte 0xE4 is not UTF-8 (also in line 2); allowed: UTF-8. In Windows-1252 "
                    "and ISO 8859-1 it is \u00e4: save the file in UTF-8, or convert it: iconv -f "
                    "WINDOWS-1252 -t UTF-8"});
}

TEST(DecodedText, IsNoneWithAByteZero) {
    const Decoded decoded(std::string("ab\nc\0d\0", 7));
    EXPECT_EQ(decoded.text, "nothing");
    EXPECT_EQ(decoded.told,
              Lines{"2:2: a byte 0, which no text has; allowed: a text file in UTF-8"});
}

std::string encoding_of(const std::string& bytes) {
    const auto told = Decoded(bytes).told;
    const std::string begin = "1:1: the file is in ";
    return told.size() == 1 && told[0].starts_with(begin)
               ? told[0].substr(begin.size(), told[0].find(';') - begin.size())
               : "";
}

TEST(DecodedText, IsNoneInAnEncodingWithSeveralBytesALetter) {
    EXPECT_EQ(Decoded("\xFE\xFF").text, "nothing");
    EXPECT_EQ(encoding_of("\xFE\xFF"), "UTF-16BE");
    EXPECT_EQ(encoding_of("\xFF\xFE"), "UTF-16LE");
    EXPECT_EQ(encoding_of(std::string("\xFF\xFE\0\0", 4)), "UTF-32LE");
    EXPECT_EQ(encoding_of(std::string("\0\0\xFE\xFF", 4)), "UTF-32BE");
}

/// 16 bytes, of which so many are not as in UTF-16LE with ASCII letters.
std::string sixteen_bytes(std::size_t others) {
    std::string bytes = widened("abcdefgh", 0, 1);
    for (std::size_t i = 0; i < others; ++i) {
        bytes[2 * i + 1] = ' ';
    }
    return bytes;
}

TEST(DecodedText, MayHaveAnEighthOfOtherLettersInSuchAnEncoding) {
    EXPECT_EQ(encoding_of(sixteen_bytes(2)), "UTF-16LE");
    EXPECT_EQ(encoding_of(sixteen_bytes(3)), "");
    EXPECT_EQ(encoding_of(sixteen_bytes(2) + "a"), "UTF-16LE") << "half a letter more";
    EXPECT_EQ(encoding_of("a" + std::string(1, '\0')), "UTF-16LE");
}

TEST(DecodedText, IsJudgedByItsBegin) {
    EXPECT_EQ(encoding_of(widened(std::string(128, 'a'), 0, 1) + std::string(300, 'a')),
              "UTF-16LE");
    EXPECT_EQ(encoding_of(std::string(256, 'a') + widened(std::string(300, 'a'), 0, 1)), "");
}

}  // namespace
}  // namespace tribus::test::encoding_test
