#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include "app/cli/complain.h"
#include "tests/support/far_end.h"
#include "tests/support/temporary_folder.h"
#include "transports/links/unique_fd.h"

/// What `tell_person` and `complain` write into a terminal.
namespace tribus::test::text_for_a_person_test {
namespace {

/// A stream that is standard error as long as this lives.
class StandardError {
  public:
    explicit StandardError(int stream) : before_(::dup(STDERR_FILENO)) {
        std::fflush(stderr);
        ::dup2(stream, STDERR_FILENO);
    }
    StandardError(const StandardError&) = delete;
    StandardError& operator=(const StandardError&) = delete;
    ~StandardError() {
        std::fflush(stderr);
        ::dup2(before_.get(), STDERR_FILENO);
    }

  private:
    UniqueFd before_;
};

class TextForAPerson : public testing::Test {
  protected:
    int terminal_of(unsigned short columns) {
        winsize size{};
        size.ws_col = columns;
        size.ws_row = 20;
        EXPECT_EQ(::ioctl(far_end_.descriptor(), TIOCSWINSZ, &size), 0);
        return terminal_.get();
    }
    std::string shown() {
        const Bytes bytes = far_end_.receive();
        std::string text(bytes.begin(), bytes.end());
        std::erase(text, '\r');
        return text;
    }

    TemporaryFolder folder_;
    FarEnd far_end_{folder_ / "terminal"};
    UniqueFd terminal_{::open(far_end_.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
    UniqueFd file_{::open((folder_ / "file").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)};
};

TEST_F(TextForAPerson, IsAsWideAsTheTerminalButNotTooWideToRead) {
    EXPECT_EQ(text_columns(terminal_of(60)), 60U);
    EXPECT_EQ(text_columns(terminal_of(200)), 100U);
    EXPECT_EQ(text_columns(file_.get()), 80U);
}

TEST_F(TextForAPerson, BreaksAtWordsAndIndents) {
    {
        const StandardError error(terminal_of(20));
        tell_person("Switch the transmitter off.", "3/4  ");
    }
    EXPECT_EQ(shown(), "3/4  Switch the\n     transmitter\n     off.\n");
}

TEST_F(TextForAPerson, BreaksAFailureAtWordsInATerminalAndIsOneLineElsewhere) {
    {
        const StandardError error(terminal_of(20));
        EXPECT_EQ(complain("/dev/ttyUSB0: there is no such device", 1), 1);
    }
    const std::string program = ::program_invocation_short_name;
    EXPECT_EQ(shown(), program + ":\n/dev/ttyUSB0: there\nis no such device\n");
    {
        const StandardError error(file_.get());
        complain("/dev/ttyUSB0: there is no such device; plug it in and say so once more, please",
                 1);
    }
    std::string line(200, '\0');
    line.resize(static_cast<std::size_t>(::pread(file_.get(), line.data(), line.size(), 0)));
    EXPECT_EQ(line, program +
                        ": /dev/ttyUSB0: there is no such device; plug it in and say so once more, "
                        "please\n");
}

}  // namespace
}  // namespace tribus::test::text_for_a_person_test
