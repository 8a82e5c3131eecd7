#include "app/journal/terminal_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/far_end.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/unique_fd.h"

namespace tribus::test::terminal_stream_test {
namespace {

/// Sets a variable, or unsets it, and restores it at the end.
class Variable {
  public:
    Variable(const char* name, const char* value) : name_(name) {
        const char* const before = std::getenv(name);
        was_set_ = before != nullptr;
        before_ = was_set_ ? before : "";
        value == nullptr ? ::unsetenv(name) : ::setenv(name, value, 1);
    }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;
    ~Variable() { was_set_ ? ::setenv(name_, before_.c_str(), 1) : ::unsetenv(name_); }

  private:
    const char* name_;
    bool was_set_ = false;
    std::string before_;
};

class TerminalStream : public testing::Test {
  protected:
    TemporaryFolder folder_;
    FarEnd far_end_{folder_ / "terminal"};
    UniqueFd terminal_{::open(far_end_.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
    UniqueFd file_{::open((folder_ / "file").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)};
    Variable term_{"TERM", "xterm"};
    Variable no_color_{"NO_COLOR", nullptr};
};

TEST_F(TerminalStream, ShowsColourOnATerminalOnly) {
    EXPECT_TRUE(shows_colour(terminal_.get()));
    EXPECT_FALSE(shows_colour(file_.get()));
    EXPECT_FALSE(is_screen(file_.get()));
}

/// https://no-color.org: "when present and not an empty string (regardless of its value)".
TEST_F(TerminalStream, ShowsNoColourWithNoColorWhateverItsValue) {
    for (const char* value : {"1", "0", "false"}) {
        const Variable set("NO_COLOR", value);
        EXPECT_FALSE(shows_colour(terminal_.get())) << value;
        EXPECT_TRUE(is_screen(terminal_.get())) << value;
    }
    const Variable empty("NO_COLOR", "");
    EXPECT_TRUE(shows_colour(terminal_.get()));
}

TEST_F(TerminalStream, IsNoScreenWhereTheTerminalObeysNoSequences) {
    for (const char* value : {static_cast<const char*>(nullptr), "", "dumb"}) {
        const Variable term("TERM", value);
        EXPECT_FALSE(is_screen(terminal_.get()));
        EXPECT_FALSE(shows_colour(terminal_.get()));
    }
}

}  // namespace
}  // namespace tribus::test::terminal_stream_test
