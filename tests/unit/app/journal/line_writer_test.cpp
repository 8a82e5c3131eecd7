#include "app/journal/line_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstddef>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "transports/links/unique_fd.h"

namespace tribus::line_writer_test {
namespace {

/// A pipe of which the writer knows one end.
class APipe : public testing::Test {
  protected:
    APipe() {
        std::array<int, 2> ends{};
        EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
        out_ = UniqueFd(ends[0]);
        in_ = UniqueFd(ends[1]);
        ::fcntl(out_.get(), F_SETFL, O_NONBLOCK);
    }
    ~APipe() override { std::signal(SIGPIPE, before_); }
    void open_again() {
        const std::string name = fmt::format("/proc/self/fd/{}", in_.get());
        out_ = UniqueFd(::open(name.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    }
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

  private:
    void (*before_)(int) = std::signal(SIGPIPE, SIG_IGN);
};

TEST_F(APipe, GetsEachLine) {
    LineWriter writer(in_.get());
    writer.write("started");
    writer.write("stopped");
    EXPECT_EQ(read_all(), "started\nstopped\n");
}

/// A pipe holds 64 KiB (pipe(7)), of which these lines leave nothing.
TEST_F(APipe, ThatNobodyReadsLosesLinesAndSaysHowMany) {
    LineWriter writer(in_.get());
    const std::string line(1023, 'x');
    for (int lines = 0; lines < 100; ++lines) {
        writer.write(line);
    }
    const std::string before = read_all();
    const auto lost = 100 - std::ranges::count(before, '\n');
    EXPECT_GT(lost, 0);
    writer.write("back");
    EXPECT_EQ(read_all(), fmt::format("({} lines lost here: there was no room)\nback\n", lost));
}

/// What these lines leave has room for the words about those that were lost.
TEST_F(APipe, CountsEachLostLineOnceAlthoughItHasRoomForTheWords) {
    LineWriter writer(in_.get());
    const std::string line(999, 'x');
    for (int lines = 0; lines < 100; ++lines) {
        writer.write(line);
    }
    std::istringstream before(read_all());
    writer.write("back");
    std::istringstream after(read_all());
    int told = 0;
    int came = 0;
    int words = 0;
    for (std::istringstream* text : {&before, &after}) {
        for (std::string found; std::getline(*text, found);) {
            came += found == line ? 1 : 0;
            words += found.starts_with('(') ? 1 : 0;
            told += found.starts_with('(') ? std::stoi(found.substr(1)) : 0;
        }
    }
    EXPECT_GT(words, 1);
    EXPECT_EQ(came + told, 100);
}

TEST_F(APipe, WhoseReaderComesBackSaysHowManyLinesWereLost) {
    LineWriter writer(in_.get());
    out_ = UniqueFd();
    writer.write("loss");
    writer.write("loss");
    open_again();
    writer.write("back");
    EXPECT_EQ(read_all(), "(2 lines lost here: there was no room)\nback\n");
}

TEST_F(APipe, InThePlaceOfAClosedDescriptorSaysHowManyLinesWereLost) {
    const int place = ::dup(in_.get());
    ::close(place);
    LineWriter writer(place);
    writer.write("loss");
    const UniqueFd again(::dup2(in_.get(), place));
    writer.write("back");
    EXPECT_EQ(read_all(), "(1 line lost here: there was no room)\nback\n");
}

TEST_F(APipe, InThePlaceOfAFullDeviceSaysHowManyLinesWereLost) {
    const UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    LineWriter writer(full.get());
    writer.write("loss");
    ASSERT_EQ(::dup2(in_.get(), full.get()), full.get());
    writer.write("back");
    EXPECT_EQ(read_all(), "(1 line lost here: there was no room)\nback\n");
}

}  // namespace
}  // namespace tribus::line_writer_test
