#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

/// Any text is either refused with a place in it or safe to use.
namespace tribus::dbc_file_property_test {
namespace {

using test::Random;

constexpr std::string_view kValid = R"(VERSION "1"

NS_ :
	CM_
	BA_DEF_
	SG_MUL_VAL_

BS_:

BU_: Gateway Consumer

BO_ 768 Classic: 8 Gateway
 SG_ Crc : 0|8@1+ (1,0) [0|255] "" Consumer
 SG_ Ch01 : 16|12@1- (0.5,476) [476|2523] "us" Consumer,Other
 SG_ Big : 39|16@0+ (1E-3,-40) [0|0] "m/s" Vector__XXX

BO_ 2566844926 Multiplexed: 8 Gateway
 SG_ Outer M : 7|8@0+ (1,0) [0|255] "" Consumer
 SG_ Inner m3M : 15|8@0+ (1,0) [0|255] "" Consumer
 SG_ Deep m5 : 23|16@0+ (1,0) [0|0] "" Consumer

BO_ 773 Fd: 48 Gateway
 SG_ Single : 64|32@1- (1,0) [0|0] "" Consumer
 SG_ Wide : 110|64@1- (1,0) [0|0] "" Consumer

CM_ SG_ 768 Crc "says \"something\"; and more";
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";
BA_DEF_DEF_ "CANFD_BRS" "1";
BA_ "GenMsgCycleTime" BO_ 768 10;
BA_ "VFrameFormat" BO_ 773 14;
BA_ "RcE2eDataId" BO_ 768 21059;
BA_ "SystemMessageLongSymbol" BO_ 768 "ClassicLong";
BA_ "SystemSignalLongSymbol" SG_ 768 Crc "CrcLong";
VAL_ 768 Ch01 -1 "NotAvailable" 3 "Error" ;
SIG_VALTYPE_ 773 Single : 1;
SIG_VALTYPE_ 773 Wide : 2;
SG_MUL_VAL_ 2566844926 Inner Outer 3-3;
SG_MUL_VAL_ 2566844926 Deep Inner 5-5, 16-20;
)";

std::size_t lines_in(std::string_view text) {
    std::size_t lines = 1;
    for (const char byte : text) {
        lines += byte == '\n' ? 1U : 0U;
    }
    return lines;
}

void expect_usable(const DbcFile& file) {
    const std::vector<std::uint8_t> full(2048, 0xFF);
    for (const DbcMessage& message : file.messages) {
        const auto data = std::span(full).first(message.length);
        for (const DbcSignal& signal : message.signals) {
            const DbcLayout layout(signal);
            ASSERT_LE(layout.needed_bytes(), message.length) << signal.name;
            ASSERT_TRUE(!signal.selector || *signal.selector < message.signals.size());
            present(message, signal, data);
            layout.bits_from_physical(layout.physical(layout.raw_bits(data)));
        }
    }
}

void expect_refused_or_usable(std::string_view text) {
    const auto file = parse_dbc(text);
    if (file) {
        expect_usable(*file);
        for (const DbcMistake& warning : file->warnings) {
            ASSERT_GE(warning.line, 1U);
            ASSERT_LE(warning.line, lines_in(text));
            ASSERT_FALSE(warning.text.empty());
        }
        return;
    }
    ASSERT_GE(file.error().line, 1U);
    ASSERT_LE(file.error().line, lines_in(text));
    ASSERT_GE(file.error().column, 1U);
    ASSERT_FALSE(file.error().text.empty());
}

TEST(DbcFileProperty, TheTextThatIsDamagedBelowIsWhole) {
    const auto file = parse_dbc(kValid);
    ASSERT_TRUE(file) << file.error().line << ": " << file.error().text;
    EXPECT_EQ(file->messages.size(), 3U);
}

TEST(DbcFileProperty, TruncationsAreRefusedOrUsable) {
    for (std::size_t length = 0; length < kValid.size(); ++length) {
        SCOPED_TRACE(length);
        // A copy of its own lets the sanitizers see a read past the end.
        const std::vector<char> text(kValid.begin(),
                                     kValid.begin() + static_cast<std::ptrdiff_t>(length));
        expect_refused_or_usable({text.data(), text.size()});
    }
}

TEST(DbcFileProperty, MutationsAreRefusedOrUsable) {
    constexpr std::string_view kBytes = "0123456789\"\\:|@+-(),[];mM\n\t \xFF_eE.xA";
    Random random(1);
    for (unsigned round = 0; round < 20'000; ++round) {
        SCOPED_TRACE(round);
        std::string text(kValid);
        for (unsigned count = 1 + random.below(4); count > 0; --count) {
            const std::size_t at = random.below(static_cast<std::uint32_t>(text.size()));
            const char byte = kBytes[random.below(kBytes.size())];
            switch (random.below(4)) {
                case 0:
                    text[at] = byte;
                    break;
                case 1:
                    text.insert(at, 1, byte);
                    break;
                case 2:
                    text.erase(at, 1 + random.below(20));
                    break;
                default:
                    text[at] = static_cast<char>(random.byte());
            }
        }
        expect_refused_or_usable(text);
    }
}

TEST(DbcFileProperty, LinesInAnyOrderAreRefusedOrUsable) {
    std::vector<std::string> lines;
    for (std::string_view rest = kValid; !rest.empty();) {
        const std::size_t end = rest.find('\n') + 1;
        lines.emplace_back(rest.substr(0, end));
        rest.remove_prefix(end);
    }
    Random random(2);
    for (unsigned round = 0; round < 5'000; ++round) {
        SCOPED_TRACE(round);
        std::string text = "BO_ 1 First: 8 A\n";
        for (unsigned count = random.below(40); count > 0; --count) {
            text += lines[random.below(static_cast<std::uint32_t>(lines.size()))];
        }
        expect_refused_or_usable(text);
    }
}

TEST(DbcFileProperty, RandomTokensAreRefusedOrUsable) {
    constexpr std::array<std::string_view, 40> kTokens{"BO_",
                                                       "SG_",
                                                       "VAL_",
                                                       "BA_",
                                                       "BA_DEF_",
                                                       "BA_DEF_DEF_",
                                                       "NS_",
                                                       "BU_",
                                                       "SIG_VALTYPE_",
                                                       "SG_MUL_VAL_",
                                                       "CM_",
                                                       "VERSION",
                                                       "BS_",
                                                       ":",
                                                       ";",
                                                       "|",
                                                       "@",
                                                       "+",
                                                       "-",
                                                       "(",
                                                       ")",
                                                       "[",
                                                       "]",
                                                       ",",
                                                       "\"\"",
                                                       "\"a\"",
                                                       "\"",
                                                       "M",
                                                       "m1",
                                                       "m2M",
                                                       "S",
                                                       "1",
                                                       "8",
                                                       "64",
                                                       "-0.5",
                                                       "1E-3",
                                                       "\n",
                                                       "ENUM",
                                                       "\"VFrameFormat\"",
                                                       "\"GenMsgCycleTime\""};
    Random random(3);
    for (unsigned round = 0; round < 20'000; ++round) {
        SCOPED_TRACE(round);
        std::string text = "BO_ 1 M : 8 A\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" B\n";
        for (unsigned count = random.below(30); count > 0; --count) {
            text += kTokens[random.below(kTokens.size())];
            text += random.below(3) == 0 ? "" : " ";
        }
        expect_refused_or_usable(text);
    }
}

TEST(DbcFileProperty, RandomBytesAreRefusedOrUsable) {
    Random random(4);
    for (unsigned round = 0; round < 20'000; ++round) {
        SCOPED_TRACE(round);
        std::string text;
        for (unsigned count = random.below(200); count > 0; --count) {
            text.push_back(static_cast<char>(random.byte()));
        }
        expect_refused_or_usable(text);
    }
}

// Each signal selects the next one: the chain is refused before it takes quadratic time.
TEST(DbcFileProperty, AVeryLongChainOfSelectorsCannotBeUsed) {
    constexpr unsigned kSignals = 50'000;
    std::string text = "BO_ 1 M: 8 A\n";
    std::string selectors;
    for (unsigned at = 0; at < kSignals; ++at) {
        const std::string name = "S" + std::to_string(at);
        text += " SG_ " + name + " m1M : 0|8@1+ (1,0) [0|0] \"\" B\n";
        selectors += "SG_MUL_VAL_ 1 " + name + " S" +
                     std::to_string(at == 0 ? kSignals - 1 : at - 1) + " 1-1;\n";
    }
    const auto file = parse_dbc(text + selectors);
    ASSERT_TRUE(file);
    ASSERT_EQ(file->warnings.size(), kSignals);
    EXPECT_NE(file->warnings.front().text.find("more than 8 selectors"), std::string::npos);
    EXPECT_TRUE(file->messages.front().signals.empty());
}

TEST(DbcFileProperty, ManyBracketsAndQuotesAreRead) {
    expect_refused_or_usable(std::string(1'000'000, '('));
    expect_refused_or_usable("CM_ " + std::string(1'000'000, '('));
    expect_refused_or_usable("CM_ \"" + std::string(1'000'000, '\\'));
    expect_refused_or_usable("NS_ :" + std::string(1'000'000, '\n') + "BO_ 1 M: 8 A");
}

}  // namespace
}  // namespace tribus::dbc_file_property_test
