#include "config/language/protocol_words.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/keys/keys.h"

namespace tribus::test::protocol_words_test {
namespace {

using Names = std::vector<std::string_view>;

TEST(ProtocolWords, NameProtocolsOfTheRegistry) {
    const Names all = protocol_names();
    // Without a choice of what is allowed, every protocol of a word must be known.
    for (const ProtocolWord& row : protocol_words()) {
        for (const std::string_view name : row.protocols) {
            EXPECT_TRUE(name.empty() || std::ranges::count(all, name) == 1)
                << row.word << ": " << name;
        }
        EXPECT_FALSE(row.protocols.front().empty()) << row.word;
    }
}

TEST(ProtocolWords, AreFoundWhateverTheirLettersAndPunctuation) {
    const Names allowed = protocol_names(SettingScope::input);
    for (const std::string_view word : {"elrs", "ELRS", "Express-LRS", "crossfire", "Tracer"}) {
        EXPECT_EQ(protocols_meant(word, allowed), Names{"crsf"}) << word;
    }
    EXPECT_EQ(protocols_meant("fs-i6x", allowed), Names{"ibus"});
    EXPECT_EQ(protocols_meant("Graupner HoTT", allowed), Names{"sumd"});
    EXPECT_EQ(protocols_meant("DSMX", allowed), Names{"dsm"});
    EXPECT_EQ(protocols_meant("carrier pigeon", allowed), Names{});
}

TEST(ProtocolWords, AreNotPreferredToTheNameOfAProtocol) {
    // "pwm" of an input means ppm, but an output has it.
    EXPECT_EQ(protocols_meant("PWM", protocol_names(SettingScope::output)), Names{"pwm"});
    EXPECT_EQ(protocols_meant("PWM", protocol_names(SettingScope::input)), Names{"ppm"});
}

TEST(ProtocolWords, GiveTheNearestNameForOthers) {
    const Names allowed{"ibus", "sbus"};
    EXPECT_EQ(protocol_suggestion("sbsu", allowed),
              R"(did you mean "sbus"? Allowed: "ibus", "sbus")");
    EXPECT_EQ(protocol_suggestion("elrs", allowed), R"(allowed: "ibus", "sbus")");
}

TEST(ProtocolWords, LeadToOneOrMoreProtocols) {
    const Names allowed{"sbus", "fport", "fbus", "ibus", "ibus2"};
    const std::string all = R"(? Allowed: "sbus", "fport", "fbus", "ibus", "ibus2")";
    EXPECT_EQ(protocol_suggestion("futaba", allowed), R"(did you mean "sbus")" + all);
    EXPECT_EQ(protocol_suggestion("flysky", allowed), R"(did you mean "ibus" or "ibus2")" + all);
    EXPECT_EQ(protocol_suggestion("frsky", allowed),
              R"(did you mean "sbus", "fport" or "fbus")" + all);
}

TEST(ProtocolWords, AreComparedBySmallLettersAndDigits) {
    EXPECT_EQ(small_letters_and_digits("FS-iA6B! (\xE4) z9"), "fsia6bz9");
    EXPECT_EQ(small_letters_and_digits("-"), "");
    EXPECT_EQ(protocols_meant("i.Bus", Names{"sbus", "ibus"}), Names{"ibus"});
}

}  // namespace
}  // namespace tribus::test::protocol_words_test
