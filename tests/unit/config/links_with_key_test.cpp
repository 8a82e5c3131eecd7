#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/config/main_job.h"

/// `key` of `can` and `network` in a configuration.
namespace tribus::test::links_with_key_test {
namespace {

using Lines = std::vector<std::string>;

class LinksWithKey : public ::testing::Test {
  protected:
    LinksWithKey() {
        for (const auto& [name, digit] :
             {std::pair("a.key", '7'), {"b.key", '8'}, {"c.key", '9'}, {"d.key", '6'}}) {
            std::filesystem::permissions(folder_.write(name, std::string(64, digit)),
                                         std::filesystem::perms::owner_read);
        }
    }
    /// An input and an output on it, and i.Bus and SBUS at their other ends.
    static std::string both(const std::string& input, const std::string& output) {
        return "[input.in]\n" + input + "[output.out]\n" + output +
               "[input.radio]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
               "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
               "[pipeline.to]\nfrom = \"radio\"\nto = \"out\"\n"
               "[pipeline.from]\nfrom = \"in\"\nto = \"servos\"\n";
    }
    static std::string network(const std::string& address, const std::string& lines) {
        return "protocol = \"network\"\naddress = \"" + address + "\"\n" + lines;
    }
    static std::string can(const std::string& lines) {
        return "protocol = \"can\"\ninterface = \"can0\"\n" + lines;
    }
    /// Their places begin with "t.toml".
    Lines mistakes(const std::string& text) const {
        Lines lines = mistakes_in(text, folder_ / "t.toml");
        for (std::string& line : lines) {
            line.erase(0, folder_.path().string().size() + 1);
        }
        return lines;
    }

    TemporaryFolder folder_;
    static inline const std::string kKey = "key = \"a.key\"\n";
};

TEST_F(LinksWithKey, MayLeaveTheMachineWithoutBeingPublic) {
    EXPECT_EQ(mistakes(both(network("[::]:5700", kKey + "link = \"from\"\n"),
                            network("192.0.2.7:5700", kKey + "link = \"to\"\n"))),
              Lines{});
}

TEST_F(LinksWithKey, ANetworkLinkWithoutOneStaysOnTheMachine) {
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", ""), network("127.0.0.1:5701", ""))),
              Lines{});
    EXPECT_EQ(
        mistakes(both(network("0.0.0.0:5700", "public = true\n"), network("127.0.0.1:5701", ""))),
        Lines{R"(t.toml:3:11: "address" is "0.0.0.0:5700", outside of this machine; allowed: )"
              R"(a loopback address, such as "127.0.0.1:5501", or add a "key" )"
              R"((`tribus key new` makes one))"});
}

TEST_F(LinksWithKey, AKeyFileThatIsMissingIsTheOnlyMistake) {
    const Lines found = mistakes(
        both(network("0.0.0.0:5700", "key = \"none.key\"\n"), network("127.0.0.1:5701", "")));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found.front().rfind("t.toml:4:7: \"key\" is \"none.key\"", 0), 0U);
}

TEST_F(LinksWithKey, TwoOfOneKeyNeedDifferentNames) {
    const std::string expected =
        R"(t.toml:5:9: [output.out] has the key and the name of the link of [input.in] in line 1, )"
        R"(so that frames of one could be brought to the other; allowed: another "link" for each, )"
        R"(the same at both ends of one)";
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", kKey), network("127.0.0.1:5701", kKey))),
              Lines{expected});
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", kKey),
                            network("127.0.0.1:5701", "key = \"b.key\"\n"))),
              Lines{});
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", kKey),
                            network("127.0.0.1:5701", kKey + "link = \"back\"\n"))),
              Lines{});
}

TEST_F(LinksWithKey, AnOldKeyIsAKeyToo) {
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", "key = \"b.key\"\nold_key = \"a.key\"\n"),
                            network("127.0.0.1:5701", kKey)))
                  .size(),
              1U);
}

TEST_F(LinksWithKey, TwoOfOneOldKeyNeedDifferentNames) {
    const auto with = [&](const std::string& old) {
        return mistakes("[input.a]\n" + network("127.0.0.1:5700", kKey + "old_key = \"c.key\"\n") +
                        "[input.b]\n" + network("127.0.0.1:5701", "key = \"b.key\"\n" + old) +
                        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                        "[pipeline.main]\nfrom = [\"a\", \"b\"]\nto = \"servos\"\n")
            .size();
    };
    EXPECT_EQ(with("old_key = \"c.key\"\n"), 1U);
    EXPECT_EQ(with("old_key = \"d.key\"\n"), 0U);
    EXPECT_EQ(with(""), 0U);
}

TEST_F(LinksWithKey, AreComparedInTheOrderOfTheFile) {
    const std::string rest =
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
        "[pipeline.main]\nfrom = [\"a\", \"b\"]\nto = [\"servos\", \"out\"]\n";
    const Lines found = mistakes("[output.out]\n" + network("127.0.0.1:5701", kKey) +
                                 "[input.a]\n" + network("127.0.0.1:5702", "key = \"b.key\"\n") +
                                 "[input.b]\n" + network("127.0.0.1:5703", kKey) + rest);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].rfind("t.toml:9:8: [input.b] has the key and the name of the link of "
                             "[output.out] in line 1, ",
                             0),
              0U)
        << found[0];
}

TEST_F(LinksWithKey, WhatOnlyAKeyGivesAMeaningNeedsOne) {
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", "old_key = \"a.key\"\n"),
                            network("127.0.0.1:5701", "link = \"back\"\n"))),
              (Lines{R"(t.toml:4:11: "old_key" has no effect without "key"; add key, or leave it )"
                     R"(out)",
                     R"(t.toml:8:8: "link" has no effect without "key"; add key, or leave it )"
                     R"(out)"}));
}

TEST_F(LinksWithKey, AnEpochIsTheWholePathOfAFileAndNeedsAKey) {
    const auto on = [&](const std::string& lines) {
        return mistakes(both(network("127.0.0.1:5700", lines), network("127.0.0.1:5701", "")));
    };
    EXPECT_EQ(on(kKey + "epoch = \"/var/lib/tribus/boat.epoch\"\n"), Lines{});
    EXPECT_EQ(
        on("epoch = \"/var/lib/tribus/boat.epoch\"\n"),
        Lines{R"(t.toml:4:9: "epoch" has no effect without "key"; add key, or leave it out)"});
    for (const std::string path : {"boat.epoch", "/var/lib/tribus/"}) {
        EXPECT_EQ(on(kKey + "epoch = \"" + path + "\"\n"),
                  Lines{R"(t.toml:5:9: "epoch" is ")" + path +
                        R"("; allowed: the whole path of a file, such as )"
                        R"("/var/lib/tribus/boat.epoch")"});
    }
}

TEST_F(LinksWithKey, TwoEndsNeedTwoEpochFiles) {
    const auto with = [&](const std::string& first, const std::string& second) {
        return mistakes(
            both(network("127.0.0.1:5700", kKey + "epoch = \"" + first + "\"\nlink = \"a\"\n"),
                 network("127.0.0.1:5701", kKey + "epoch = \"" + second + "\"\nlink = \"b\"\n")));
    };
    EXPECT_EQ(with("/a/boat.epoch", "/a/shore.epoch"), Lines{});
    EXPECT_EQ(mistakes(both(network("127.0.0.1:5700", kKey + "epoch = \"/a\"\nlink = \"a\"\n"),
                            network("127.0.0.1:5701", kKey + "link = \"b\"\n"))),
              Lines{});
    EXPECT_EQ(with("/a/boat.epoch", "/a/./boat.epoch"),
              Lines{"t.toml:7:9: [output.out] has the epoch file of [input.in] in line 1; allowed: "
                    "another file for each, because one would use up the numbers of the other"});
}

TEST_F(LinksWithKey, WithAnEpochNeitherAnswerNorHearAnswers) {
    const std::string text =
        both(can("fd = true\n" + kKey + "epoch = \"/a\"\n"),
             network("127.0.0.1:5701", kKey + "link = \"x\"\nepoch = \"/b\"\n"));
    const auto configuration = load_configuration(text, folder_ / "t.toml");
    ASSERT_TRUE(configuration);
    for (const PortPlan& plan : plan_ports(*configuration)) {
        EXPECT_FALSE(plan.wiring.answers);
        EXPECT_EQ(plan.wiring.stations.size(), 1U);
    }
}

TEST_F(LinksWithKey, OnCanMayBeFdOrClassic) {
    for (const std::string fd : {"", "fd = true\n"}) {
        EXPECT_EQ(mistakes(both(can(fd + kKey), can(fd + "id = 0x400\n" + kKey))), Lines{});
    }
}

TEST_F(LinksWithKey, OnClassicCanHaveFifteenIds) {
    const Lines found = mistakes(both(can(kKey), can("id = 0x30E\n")));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found.front().find("the id 0x30E"), std::string::npos) << found.front();
    EXPECT_EQ(mistakes(both(can(kKey), can("id = 0x30F\n"))), Lines{});
    EXPECT_EQ(
        mistakes(both(can("id = 0x7F2\n" + kKey), can(""))),
        Lines{"t.toml:4:6: 2034 is too high for ids of 11 bits; allowed is 0 to 2033 (0x7F1), "
              "or more with extended = true"});
}

TEST_F(LinksWithKey, OnClassicCanHaveNeitherACrcNorFewerChannels) {
    EXPECT_EQ(
        mistakes(both(can("crc = \"p01\"\nchannels = 16\n" + kKey), can("id = 0x400\n"))),
        (Lines{R"(t.toml:4:7: "p01" is for frames without a key, which proves more than a CRC: )"
               "leave out crc, or key",
               "t.toml:5:12: 16 is for frames without a key; a link with a key always has 18 "
               "channels: leave out channels, or key"}));
}

TEST_F(LinksWithKey, OnCanTakeTheIdOfTheirAnswersToo) {
    const Lines found = mistakes(both(can("fd = true\n" + kKey), can("id = 0x2FF\n")));
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found.front().find("the id 0x300"), std::string::npos) << found.front();
}

TEST_F(LinksWithKey, OnCanAnswerWithAnIdThatNoOtherInputHears) {
    EXPECT_EQ(mistakes("[input.in]\n" + can("fd = true\n" + kKey) + "[input.other]\n" +
                       can("id = 0x2FF\n") +
                       "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                       "[pipeline.main]\nfrom = [\"in\", \"other\"]\nto = \"servos\"\n"),
              Lines{"t.toml:8:13: on \"can0\" the id 0x300 of [input.other] is also used by "
                    "[input.in] in line 3; allowed: ids that only one output sends and no input of "
                    "the same file receives"});
}

TEST_F(LinksWithKey, AnswerAndHearOnTheirPorts) {
    const std::string text =
        both(can("fd = true\n" + kKey), network("127.0.0.1:5701", kKey + "link = \"x\"\n"));
    const auto configuration = load_configuration(text, folder_ / "t.toml");
    ASSERT_TRUE(configuration);
    const auto plans = plan_ports(*configuration);
    const auto engine = build_engine(*configuration);
    const Stations stations(*engine, nullptr);
    EXPECT_TRUE(plans[0].wiring.answers);
    EXPECT_EQ(plans[0].wiring.stations,
              (std::vector<Station>{{StationKind::input, 0}, {StationKind::answers, 0}}));
    const LinkUse use = link_use(stations, plans[0]);
    EXPECT_TRUE(use.fd);
    EXPECT_EQ(use.wanted, std::vector{CanIdMatch{.id = 0x305}});
    EXPECT_EQ(use.sent, std::vector{CanIdMatch{.id = 0x300}});
    const auto output = std::ranges::find_if(
        plans, [](const PortPlan& plan) { return plan.config.device == "127.0.0.1:5701"; });
    ASSERT_NE(output, plans.end());
    EXPECT_EQ(output->wiring.stations,
              (std::vector<Station>{{StationKind::output, 0}, {StationKind::replies, 0}}));
    EXPECT_FALSE(output->wiring.answers);
}

/// As keys are changed: the new one beside the old one, then alone.
TEST_F(LinksWithKey, GoOnAtAReloadThatLeavesThemAKey) {
    const std::string old_alone = "key = \"a.key\"\n";
    const std::string both_keys = "key = \"b.key\"\nold_key = \"a.key\"\n";
    const std::string new_alone = "key = \"b.key\"\n";
    const auto carry = [&](const std::string& before, const std::string& after) {
        const auto with = [&](const std::string& lines) {
            return *load_configuration(
                both(network("127.0.0.1:5700", lines), network("127.0.0.1:5701", "")),
                folder_ / "t.toml");
        };
        return plan_carry_over(with(before), with(after)).engine.inputs.front();
    };
    for (const auto& [before, after] :
         {std::pair(old_alone, both_keys), {both_keys, new_alone}, {both_keys, old_alone}}) {
        EXPECT_EQ(carry(before, after).from, 0U) << before << after;
        EXPECT_TRUE(carry(before, after).new_keys);
    }
    EXPECT_EQ(carry(both_keys, both_keys).from, 0U);
    EXPECT_FALSE(carry(both_keys, both_keys).new_keys);
    const std::string plain;
    for (const auto& [before, after] : {std::pair(old_alone, new_alone),
                                        {old_alone, plain},
                                        {plain, old_alone},
                                        {old_alone, both_keys + "link = \"other\"\n"}}) {
        EXPECT_EQ(carry(before, after).from, std::nullopt) << before << after;
    }
}

}  // namespace
}  // namespace tribus::test::links_with_key_test
