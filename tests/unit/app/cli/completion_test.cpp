#include "app/cli/completion.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::completion_test {
namespace {

using Words = std::vector<std::string>;

/// What a program offers behind `typed`, whose last word is at the cursor.
Completion completion(const std::vector<std::string_view>& typed) {
    static std::string text;
    static std::vector<std::string> texts;
    static bool flag = false;
    const Program program{
        .name = "boat",
        .help = "Steer",
        .commands = {
            {.name = "steer",
             .help = "Steer the boat",
             .options =
                 {{.name = "NAME",
                   .value = &text,
                   .help = "Which boat",
                   .offers =
                       [] {
                           return Words{"arrow", "birch"};
                       }},
                  {.name = "FILE", .value = &text, .help = "Course"},
                  {.name = "--format", .value = &text, .help = "Form", .choices = {"text", "json"}},
                  {.name = "--from",
                   .value = &texts,
                   .help = "From where",
                   .value_name = "PLACE",
                   .offers = [] { return Words{"harbour"}; }},
                  {.name = "--state", .value = &text, .help = "", .value_name = "FOLDER"},
                  {.name = "--seconds", .value = &text, .help = "", .value_name = "SECONDS"},
                  {.name = "--pair",
                   .value = &texts,
                   .help = "",
                   .value_name = "IN OUT",
                   .count = 2,
                   .offers =
                       [] {
                           return Words{"first", "second"};
                       }},
                  {.name = "--throttle",
                   .value = &text,
                   .help = "",
                   .choices = {"zero based", "centred"}},
                  {.name = "--once", .value = &flag, .help = "Once"}},
             .selected = SelectedOptions{.by = "--format",
                                         .of =
                                             [](std::string_view value) {
                                                 const bool json = value == "json";
                                                 return std::vector<CommandOption>{
                                                     {.name = json ? "--indent" : "--indent-or-not",
                                                      .value = &text,
                                                      .help = "",
                                                      .value_name = "NUMBER"}};
                                             },
                                         .knows = [](std::string_view) { return true; }}},
            {.name = "stop", .help = "Stop"}}};
    return complete(program, typed);
}

Words offered(const std::vector<std::string_view>& typed) {
    Words words;
    for (const OfferedWord& offered : completion(typed).words) {
        words.push_back(offered.word);
    }
    return words;
}

TEST(Completion, OffersTheCommandsThatBeginSo) {
    EXPECT_EQ(offered({""}), (Words{"steer", "stop"}));
    EXPECT_EQ(offered({}), (Words{"steer", "stop"}));
    EXPECT_EQ(offered({"sto"}), Words{"stop"});
    EXPECT_EQ(offered({"-"}), (Words{"--help", "--version"}));
    EXPECT_EQ(offered({"sail", ""}), Words{});
}

TEST(Completion, OffersTheOptionsOfTheCommandWithTheirMeanings) {
    EXPECT_EQ(offered({"steer", "--f"}), (Words{"--format", "--from"}));
    EXPECT_EQ(completion({"steer", "--fo"}).words.front().meaning, "Form");
    EXPECT_EQ(offered({"stop", "--"}), Words{"--help"});
}

TEST(Completion, OffersAnOptionOnceUnlessItMayBeRepeated) {
    EXPECT_EQ(offered({"steer", "--format", "json", "--f"}), Words{"--from"});
    EXPECT_EQ(offered({"steer", "--from=a", "--from", "b", "--fr"}), Words{"--from"});
}

TEST(Completion, OffersTheOptionsThatAnotherOptionSelects) {
    EXPECT_EQ(offered({"steer", "--format=json", "--in"}), Words{"--indent"});
    EXPECT_EQ(offered({"steer", "--in"}), Words{"--indent-or-not"});
}

TEST(Completion, OffersChoicesBehindTheOptionAndBehindTheEqualsSign) {
    EXPECT_EQ(offered({"steer", "--format", ""}), (Words{"text", "json"}));
    EXPECT_EQ(offered({"steer", "--format", "j"}), Words{"json"});
    EXPECT_EQ(offered({"steer", "--format="}), (Words{"text", "json"}));
    EXPECT_EQ(offered({"steer", "--format=t"}), Words{"text"});
    EXPECT_EQ(offered({"steer", "--foramt=t"}), Words{});
}

TEST(Completion, QuotesAChoiceOfSeveralWords) {
    EXPECT_EQ(offered({"steer", "--throttle", ""}), (Words{"\"zero based\"", "centred"}));
    EXPECT_EQ(offered({"steer", "--throttle=z"}), Words{"\"zero based\""});
    EXPECT_EQ(offered({"steer", "--throttle=\"z"}), Words{"\"zero based\""});
}

TEST(Completion, CountsTheValuesOfAnOption) {
    EXPECT_EQ(offered({"steer", "--pair", "first", "s"}), Words{"second"});
    EXPECT_EQ(offered({"steer", "--pair", "first", "second", "a"}), Words{"arrow"});
    EXPECT_EQ(offered({"steer", "--once", "a"}), Words{"arrow"});
}

TEST(Completion, OffersWhatAnArgumentMayBe) {
    EXPECT_EQ(offered({"steer", ""}), (Words{"arrow", "birch"}));
    EXPECT_EQ(completion({"steer", ""}).paths, OfferedPaths::none);
    EXPECT_EQ(completion({"steer", "birch", ""}).paths, OfferedPaths::files);
    EXPECT_EQ(offered({"steer", "birch", ""}), Words{});
    EXPECT_EQ(completion({"steer", "birch", "c.txt", ""}).paths, OfferedPaths::none);
    EXPECT_EQ(completion({"steer", "--", "birch", "-"}).paths, OfferedPaths::files);
}

TEST(Completion, AsksForPathsWhereTheValueIsOne) {
    EXPECT_EQ(completion({"steer", "--from", ""}).paths, OfferedPaths::files);
    EXPECT_EQ(offered({"steer", "--from", ""}), Words{"harbour"});
    EXPECT_EQ(completion({"steer", "--state="}).paths, OfferedPaths::folders);
    EXPECT_EQ(completion({"steer", "--seconds", ""}).paths, OfferedPaths::none);
    EXPECT_EQ(completion({"steer", "--format", ""}).paths, OfferedPaths::none);
}

TEST(Completion, IsTextOfOneLineForEachWord) {
    EXPECT_EQ(completion_text({.words = {{"a", "first"}, {"b"}}, .paths = OfferedPaths::files}),
              "a\tfirst\nb\n:files\n");
    EXPECT_EQ(completion_text({.words = {}, .paths = OfferedPaths::folders}), ":folders\n");
    EXPECT_EQ(completion_text({}), "");
}

}  // namespace
}  // namespace tribus::completion_test
