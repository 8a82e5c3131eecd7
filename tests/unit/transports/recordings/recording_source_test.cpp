#include "transports/recordings/recording_source.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

namespace tribus::test::recording_source_test {
namespace {

constexpr std::string_view kLog =
    "(1.0) vcan1 1F0#01\n"
    "(1.1) can0 1F0#02\n"
    "(1.2) can0 20000040#0000000000000000\n"
    "(1.3) vcan1 1F0#03\n";

/// Writes down what it takes: the index and bytes of a burst, the interface and data of a frame.
class Noted final : public RecordingTaker {
  public:
    void feed_burst(std::size_t index, const Burst& burst) override {
        text += fmt::format("{}:{:02x} ", index, fmt::join(burst.bytes, ""));
    }
    void feed_frame(const RecordedCanFrame& frame) override {
        text += fmt::format("{}:{:02x} ", frame.interface, frame.frame.data[0]);
    }
    std::string text;
};

std::string read(RecordingSource& source) {
    Noted noted;
    source.read(noted);
    return noted.text;
}

/// A content in pieces of one byte, the hardest way to cut it.
class Crumbs final : public Pieces {
  public:
    explicit Crumbs(std::string content) : content_(std::move(content)) {}
    std::string_view next() override {
        return at_ == content_.size() ? std::string_view()
                                      : std::string_view(content_).substr(at_++, 1);
    }
    void rewind() override { at_ = 0; }
    void replace(std::string content) { content_ = std::move(content); }

  private:
    std::string content_;
    std::size_t at_ = 0;
};

TEST(RecordingSource, GivesTheSameEachTimeInPiecesAndInMemory) {
    for (const auto& [kind, content] : std::vector<std::pair<RecordingKind, std::string>>{
             {RecordingKind::hex, "20 40\n01\n\n02 03 # two\n"},
             {RecordingKind::timed, "# t_us\n10 20 40\n20 01\n"},
             {RecordingKind::candump, std::string(kLog)}}) {
        Crumbs crumbs(content);
        RecordingInPieces pieces(crumbs, "file", kind);
        ASSERT_TRUE(pieces.judge());
        const auto parsed = parse_recording(content, "file", kind);
        ASSERT_TRUE(parsed);
        RecordingInMemory memory(*parsed);
        EXPECT_EQ(memory.kind(), pieces.kind());
        const std::string once = read(memory);
        EXPECT_FALSE(once.empty());
        EXPECT_EQ(read(memory), once);
        EXPECT_EQ(read(pieces), once);
        EXPECT_EQ(read(pieces), once);
    }
}

TEST(RecordingSource, RawBytesAreOneBurstInPieces) {
    Crumbs crumbs("ab");
    RecordingInPieces pieces(crumbs, "file", RecordingKind::raw);
    EXPECT_EQ(read(pieces), "0:61 0:62 ");
}

TEST(RecordingSource, ListsTheInterfacesInTheOrderOfTheLogAndReadsTheOneThatIsSelected) {
    OnePiece log(kLog);
    RecordingInPieces pieces(log, "can.log", RecordingKind::candump);
    ASSERT_TRUE(pieces.judge());
    EXPECT_EQ(pieces.interfaces(), (std::vector<std::string>{"vcan1", "can0"}));
    EXPECT_EQ(read(pieces), "vcan1:01 can0:02 vcan1:03 ");
    pieces.select_interface("vcan1");
    EXPECT_EQ(read(pieces), "vcan1:01 vcan1:03 ");
    Noted noted;
    EXPECT_EQ(pieces.read(noted).error_frames, 1U);
}

TEST(RecordingSource, AMistakeIsFoundBeforeAnythingIsUsed) {
    OnePiece text("20 40\n2x\n");
    RecordingInPieces pieces(text, "wire.txt", RecordingKind::hex);
    const auto judged = pieces.judge();
    ASSERT_FALSE(judged);
    EXPECT_TRUE(judged.error().starts_with("wire.txt:2:1: ")) << judged.error();
}

TEST(RecordingSource, AFileThatIsDamagedAfterItWasJudgedIsToldAboutAndReadUpToThere) {
    Crumbs crumbs("20 40\n01\n");
    RecordingInPieces pieces(crumbs, "wire.txt", RecordingKind::hex);
    ASSERT_TRUE(pieces.judge());
    EXPECT_FALSE(pieces.failed());
    crumbs.replace("20 40\nx\n");
    EXPECT_EQ(read(pieces), "0:2040 ");
    ASSERT_TRUE(pieces.failed());
    EXPECT_TRUE(pieces.failed()->starts_with("wire.txt:2:1: ")) << *pieces.failed();
}

}  // namespace
}  // namespace tribus::test::recording_source_test
