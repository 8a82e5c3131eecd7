#include "app/init/next_commands.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tribus::init::test::next_commands_test {
namespace {

using Lines = std::vector<std::string>;

TEST(InitNext, WordsAreQuotedForTheShellWhereTheyNeedIt) {
    EXPECT_EQ(shell_word("/etc/tribus/a-b_1.toml"), "/etc/tribus/a-b_1.toml");
    EXPECT_EQ(shell_word("my rover.toml"), "'my rover.toml'");
    EXPECT_EQ(shell_word("it's; rm"), "'it'\\''s; rm'");
    EXPECT_EQ(shell_word(""), "''");
}

TEST(InitNext, CommentsNameOnlyFilesThatTheyCanHold) {
    EXPECT_EQ(name_in_comments("servos.toml"), "servos.toml");
    EXPECT_EQ(name_in_comments("-"), "FILE");
    EXPECT_EQ(name_in_comments("a\nb.toml"), "FILE");
    EXPECT_EQ(name_in_comments("f\xc3\xbc.toml"), "FILE");
}

TEST(InitNext, CommandsCheckAndLearnBeforeTheyRun) {
    EXPECT_EQ(next_commands("servos.toml", "receiver"),
              (Lines{"tribus check servos.toml", "tribus learn servos.toml:receiver",
                     "tribus run servos.toml"}));
}

TEST(InitNext, ServiceRunsTheFileByItsName) {
    EXPECT_EQ(service_commands("servos.toml"),
              (Lines{"sudo cp servos.toml /etc/tribus/ && "
                     "sudo systemctl enable --now tribus@servos"}));
}

TEST(InitNext, AFileThatIsInItsPlaceIsNotCopied) {
    EXPECT_EQ(service_commands("/etc/tribus/servos.toml"),
              (Lines{"sudo systemctl enable --now tribus@servos"}));
}

TEST(InitNext, NamesThatNoServiceCanHaveGetAnother) {
    EXPECT_EQ(service_commands("/tmp/my rover.toml"),
              (Lines{"sudo cp '/tmp/my rover.toml' /etc/tribus/rc.toml && "
                     "sudo systemctl enable --now tribus@rc"}));
    EXPECT_EQ(service_commands("servos.conf"),
              (Lines{"sudo cp servos.conf /etc/tribus/servos.toml && "
                     "sudo systemctl enable --now tribus@servos"}));
}

}  // namespace
}  // namespace tribus::init::test::next_commands_test
