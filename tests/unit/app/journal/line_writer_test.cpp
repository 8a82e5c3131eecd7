#include "app/journal/line_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstddef>
#include <string>

#include <gtest/gtest.h>

#include "transports/links/unique_fd.h"

namespace tribus::line_writer_test {
namespace {

/// A pipe of which the writer knows one end.
class APipe : public testing::Test {
  protected:
    APipe() {
        std::signal(SIGPIPE, SIG_IGN);
        std::array<int, 2> ends{};
        EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
        out_ = UniqueFd(ends[0]);
        in_ = UniqueFd(ends[1]);
        ::fcntl(out_.get(), F_SETFL, O_NONBLOCK);
    }
    ~APipe() override { std::signal(SIGPIPE, SIG_DFL); }
    std::string read_all() const {
        std::string text;
        std::array<char, 4096> bytes{};
        for (ssize_t count = 1; count > 0;) {
            count = ::read(out_.get(), bytes.data(), bytes.size());
            text.append(bytes.data(), static_cast<std::size_t>(count > 0 ? count : 0));
        }
        return text;
    }

    UniqueFd out_;
    UniqueFd in_;
};

TEST_F(APipe, GetsEachLine) {
    LineWriter writer(in_.get());
    writer.write("started");
    writer.write("stopped");
    EXPECT_EQ(read_all(), "started\nstopped\n");
}

/// A pipe holds 64 KiB (pipe(7)).
TEST_F(APipe, ThatNobodyReadsLosesLinesAndSaysHowMany) {
    LineWriter writer(in_.get());
    const std::string line(999, 'x');
    for (int lines = 0; lines < 100; ++lines) {
        writer.write(line);
    }
    const std::string before = read_all();
    EXPECT_LE(before.size(), std::size_t{64} * 1024);
    writer.write("back");
    const std::string after = read_all();
    EXPECT_TRUE(after.ends_with(" lines lost here: there was no room)\nback\n")) << after;
}

TEST_F(APipe, WithoutAReaderIsLeftAlone) {
    LineWriter writer(in_.get());
    out_ = UniqueFd();
    writer.write("loss");
    writer.write("loss");
}

TEST(LineWriter, SurvivesADescriptorThatIsNotOpen) {
    LineWriter writer(-1);
    writer.write("loss");
}

TEST(LineWriter, SurvivesADeviceThatIsFull) {
    const UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    LineWriter writer(full.get());
    writer.write("loss");
}

}  // namespace
}  // namespace tribus::line_writer_test
