#include "tests/support/vectors.h"
#include "transports/codecs/native_can/channels_dbc.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace tribus::can_channels_dbc_test {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Returns the lines that begin with one of these words, in order.
std::vector<std::string> lines_with(const std::string& text, const std::set<std::string>& words) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        std::istringstream parts(line);
        std::string word;
        parts >> word;
        if (words.contains(word)) {
            lines.push_back(line);
        }
    }
    return lines;
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
        text.replace(at, from.size(), to);
    }
}

TEST(NativeDbc, TheShippedFileIsWhatTheCodecSays) {
    EXPECT_EQ(content_of(fs::path(TRIBUS_SOURCE_DIR) / "deploy/can/native.dbc"), native_dbc())
        << "write the output of native_dbc() to deploy/can/native.dbc";
}

class ProposedDbc : public testing::Test {
  protected:
    void SetUp() override { proposed_ = content_of(test::vector_file("native.dbc")); }

    std::string proposed_;
};

TEST_F(ProposedDbc, HasTheSameMessagesAndSignals) {
    // The proposal is for profile 1, whose counter stops at 14. Our file is for profile 22.
    replace_all(proposed_, "8|4@1+ (1,0) [0|14]", "8|4@1+ (1,0) [0|15]");
    EXPECT_EQ(lines_with(native_dbc(), {"BO_", "SG_"}), lines_with(proposed_, {"BO_", "SG_"}));
}

TEST_F(ProposedDbc, HasTheSameAttributes) {
    const std::set<std::string> words{"BA_DEF_", "BA_DEF_DEF_", "BA_"};
    EXPECT_EQ(lines_with(native_dbc(), words), lines_with(proposed_, words));
}

TEST_F(ProposedDbc, NamesAllTheValuesThatItNames) {
    const auto ours = lines_with(native_dbc(), {"VAL_"});
    const std::set<std::string> named(ours.begin(), ours.end());
    const auto theirs = lines_with(proposed_, {"VAL_"});
    EXPECT_FALSE(theirs.empty());
    for (const std::string& line : theirs) {
        EXPECT_TRUE(named.contains(line)) << line;
    }
}

TEST(NativeDbc, SaysWhichCrcAndCounterItIs) {
    const std::string text = native_dbc();
    EXPECT_NE(text.find("CM_ SG_ 768 RcA_Crc \"CRC-8 of E2E profile 22"), std::string::npos);
    EXPECT_NE(text.find("CM_ SG_ 773 RcFd_Crc \"CRC-16 0x1021 of E2E profile 5"),
              std::string::npos);
    EXPECT_NE(text.find("16 x (RcE2eDataId - 21059) + counter"), std::string::npos);
}

// docs/protocols/can.md, "DBC files": bit 31 marks 29-bit ids; VFrameFormat 1 is extended, 15
// extended FD.
TEST(NativeDbc, FollowsTheIds) {
    const std::string text = native_dbc({.base_id = 0x12345, .extended = true});
    EXPECT_NE(text.find("BO_ 2147558213 RcA: 8 "), std::string::npos);
    EXPECT_NE(text.find("BO_ 2147558218 RcFd: 48 "), std::string::npos);
    EXPECT_NE(text.find("BA_ \"VFrameFormat\" BO_ 2147558213 1;"), std::string::npos);
    EXPECT_NE(text.find("BA_ \"VFrameFormat\" BO_ 2147558218 15;"), std::string::npos);
}

}  // namespace
}  // namespace tribus::can_channels_dbc_test
