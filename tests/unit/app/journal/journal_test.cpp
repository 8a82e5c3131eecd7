#include "app/journal/journal.h"

#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <spdlog/logger.h>

#include "tests/support/temporary_folder.h"
#include "transports/links/unique_fd.h"

namespace tribus::journal_test {
namespace {

using namespace std::string_literals;

std::string entry(const std::string& message, const std::vector<LogField>& fields = {}) {
    return journal_entry(spdlog::level::warn, message, fields);
}

TEST(LogOnATerminal, HasOneLineForEachMessageAndNoControlCharacters) {
    spdlog::memory_buf_t line;
    const spdlog::details::log_msg message(
        "tribus", spdlog::level::info, "device a\n12:00:00.000 info started\x1b[2J\x7f is gone");
    terminal_formatter()->format(message, line);
    const std::string text(line.data(), line.size());
    EXPECT_NE(text.find(" info device a\\x0a12:00:00.000 info started\\x1b[2J\\x7f is gone\n"),
              std::string::npos)
        << text;
    EXPECT_EQ(std::ranges::count(text, '\n'), 1);
}

TEST(LogText, HasNoBytesOfDamagedFilesButCharactersOfAnyLanguage) {
    EXPECT_EQ(without_control_characters("/dev/\xff\xc3 gef\u00e4hrlich"),
              "/dev/\\xff\\xc3 gef\u00e4hrlich");
    // NEXT LINE, a control sequence introducer, RIGHT-TO-LEFT OVERRIDE, LINE SEPARATOR.
    EXPECT_EQ(without_control_characters("a\u0085\u009b\u202e\u2028z"),
              "a\\xc2\\x85\\xc2\\x9b\\xe2\\x80\\xae\\xe2\\x80\\xa8z");
}

TEST(JournalEntry, HasMessagePriorityAndWhoSaysIt) {
    EXPECT_EQ(entry("input receiver: good"),
              "MESSAGE=input receiver: good\nPRIORITY=4\nSYSLOG_IDENTIFIER=tribus\n");
}

TEST(JournalEntry, HasThePrioritiesOfSyslog) {
    constexpr std::array<const char*, 6> kPriorities{"7", "7", "6", "4", "3", "2"};
    for (int level = spdlog::level::trace; level < spdlog::level::off; ++level) {
        const std::string text =
            journal_entry(static_cast<spdlog::level::level_enum>(level), "x", {});
        EXPECT_EQ(text, "MESSAGE=x\nPRIORITY="s + kPriorities[static_cast<std::size_t>(level)] +
                            "\nSYSLOG_IDENTIFIER=tribus\n");
    }
}

TEST(JournalEntry, HasTheFieldsThatHaveANameOnly) {
    EXPECT_EQ(entry("x", {{"TRIBUS_INPUT", "receiver"}, {}, {"TRIBUS_CAUSE", ""}}),
              "MESSAGE=x\nPRIORITY=4\nSYSLOG_IDENTIFIER=tribus\n"
              "TRIBUS_INPUT=receiver\nTRIBUS_CAUSE=\n");
}

/// Format of systemd.io/JOURNAL_NATIVE_PROTOCOL: name, line end, 64-bit little-endian length,
/// bytes, line end. A device may have any name, which must not add fields of its own.
TEST(JournalEntry, TellsTheLengthOfTextWithLineEnds) {
    EXPECT_EQ(entry("x", {{"TRIBUS_DEVICE", "/dev/a\nPRIORITY=0"}}),
              "MESSAGE=x\nPRIORITY=4\nSYSLOG_IDENTIFIER=tribus\n"
              "TRIBUS_DEVICE\n\x11\0\0\0\0\0\0\0/dev/a\nPRIORITY=0\n"s);
}

/// A journal's socket, and a logger that writes to it.
class Journal : public testing::Test {
  protected:
    Journal() : journal_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path_.copy(address.sun_path, sizeof address.sun_path - 1);
        EXPECT_EQ(
            ::bind(journal_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    std::string read() const {
        std::array<char, 4096> bytes;
        const ssize_t count = ::recv(journal_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        return count < 0 ? "(nothing)" : std::string(bytes.data(), static_cast<std::size_t>(count));
    }

    test::TemporaryFolder folder_;
    std::string path_ = folder_ / "journal";
    UniqueFd journal_;
};

TEST_F(Journal, GetsEachMessageAsOneEntryWithWhatItIsAbout) {
    spdlog::logger logger("t", journal_sink(path_));
    {
        const LogFields fields({"TRIBUS_INPUT", "receiver"}, {"TRIBUS_CAUSE", "wire_silent"});
        logger.warn("input receiver: wire silent");
    }
    logger.info("stopped");
    EXPECT_EQ(read(),
              "MESSAGE=input receiver: wire silent\nPRIORITY=4\nSYSLOG_IDENTIFIER=tribus\n"
              "TRIBUS_INPUT=receiver\nTRIBUS_CAUSE=wire_silent\n");
    EXPECT_EQ(read(), "MESSAGE=stopped\nPRIORITY=6\nSYSLOG_IDENTIFIER=tribus\n");
    EXPECT_EQ(read(), "(nothing)");
}

TEST_F(Journal, ThatIsNotThereCostsTheFieldsOnly) {
    testing::internal::CaptureStderr();
    spdlog::logger logger("t", journal_sink(folder_ / "other"));
    logger.error("no such device");
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "<3>no such device\n");
}

}  // namespace
}  // namespace tribus::journal_test
