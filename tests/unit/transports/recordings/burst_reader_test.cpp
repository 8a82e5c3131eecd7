#include "transports/recordings/burst_reader.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "transports/recordings/candump.h"
#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/text.h"

namespace tribus::burst_reader_test {
namespace {

/// A content in pieces of some bytes each. A piece is overwritten by the next one, as in a file's
/// buffer.
class SmallPieces final : public Pieces {
  public:
    SmallPieces(std::string_view content, std::size_t size) : content_(content), size_(size) {}
    std::string_view next() override {
        piece_ = content_.substr(at_, size_);
        at_ += piece_.size();
        return piece_;
    }
    void rewind() override { at_ = 0; }

  private:
    std::string_view content_;
    std::size_t size_;
    std::size_t at_ = 0;
    std::string piece_;
};

constexpr std::string_view kTimed =
    "\xEF\xBB\xBF# t_us bytes, \xC3\xA9\n0 20 40 dc! 05\r\n\n  # between\n1146.5 0f 00\n7700 55";
constexpr std::string_view kHex = "20 40 dc! 05\n\n# nothing\n0f 00 01 # more\n";
constexpr std::string_view kSaleae =
    "Time [s],Value,Parity Error,Framing Error\n0.001,0x0F,,\n0.00112,0x00,Error,\n0.015,0x0F,,\n";
constexpr std::string_view kCandump =
    "(1436509052.249713) can0 123#1122\n# nothing\n(1436509052.250000) vcan1 00000123#R\n";
constexpr std::string_view kRaw = "\x20\x40\x01\x02\x0f\x04\n\x01#\x05";
constexpr std::string_view kMistaken = "# t_us\n0 20\n1 20 4\n";

/// Reads all bursts into a text, which ends with the mistake if there is one.
std::string told(Pieces& content, RecordingKind kind) {
    std::string text;
    BurstReader reader(content, "f", kind);
    auto burst = reader.next();
    for (; burst && *burst; burst = reader.next()) {
        text += (*burst)->start ? std::to_string((*burst)->start->count()) : "-";
        for (std::size_t i = 0; i < (*burst)->bytes.size(); ++i) {
            text += " " + std::to_string((*burst)->bytes[i]) + ((*burst)->damaged[i] ? "!" : "");
        }
        text += kind == RecordingKind::raw ? "" : "\n";
    }
    return burst ? text : text + burst.error();
}

TEST(BurstReader, SaysTheSameWhateverThePiecesAre) {
    for (const std::string_view content : {kTimed, kHex, kSaleae, kMistaken}) {
        OnePiece whole(content);
        const auto kind = detect_recording_kind(whole, "f");
        ASSERT_TRUE(kind) << content;
        const std::string expected = told(whole, *kind);
        ASSERT_GT(expected.size(), 10U);
        // The first piece has the whole byte order mark.
        for (std::size_t size = 3; size <= content.size(); ++size) {
            SmallPieces pieces(content, size);
            ASSERT_EQ(detect_recording_kind(pieces, "f"), kind) << content << size;
            ASSERT_EQ(told(pieces, *kind), expected) << size;
        }
    }
}

TEST(BurstReader, GivesRawBytesPieceByPiece) {
    for (std::size_t size = 1; size <= kRaw.size(); ++size) {
        SmallPieces pieces(kRaw, size);
        ASSERT_EQ(detect_recording_kind(pieces, "f"), RecordingKind::raw);
        BurstReader reader(pieces, "f", RecordingKind::raw);
        std::string bytes;
        for (auto burst = reader.next(); *burst; burst = reader.next()) {
            ASSERT_LE((*burst)->bytes.size(), size);
            bytes.append((*burst)->bytes.begin(), (*burst)->bytes.end());
        }
        ASSERT_EQ(bytes, kRaw);
    }
}

TEST(CandumpFrames, AreTheSameWhateverThePiecesAre) {
    const auto whole = parse_recording(kCandump, "f");
    ASSERT_TRUE(whole);
    ASSERT_EQ(whole->can_frames.size(), 2U);
    for (std::size_t size = 1; size <= kCandump.size(); ++size) {
        SmallPieces pieces(kCandump, size);
        CandumpFrames frames(pieces, "f");
        for (const RecordedCanFrame& expected : whole->can_frames) {
            const auto frame = frames.next();
            ASSERT_TRUE(frame && *frame) << size;
            ASSERT_EQ((*frame)->at, expected.at);
            ASSERT_EQ((*frame)->interface, expected.interface);
            ASSERT_EQ((*frame)->frame, expected.frame);
        }
        const auto end = frames.next();
        ASSERT_TRUE(end && !*end) << size;
    }
}

TEST(Oddities, HaveTheirPlaceWhateverThePiecesAre) {
    constexpr std::string_view kOdd = "# \xC3\xA9 fine\n20 40\n20 \x01 40 \xC3\xA9\n";
    for (std::size_t size = 1; size <= kOdd.size(); ++size) {
        SmallPieces pieces(kOdd, size);
        recording_text::Oddities odd;
        for (auto piece = pieces.next(); !piece.empty(); piece = pieces.next()) {
            odd.take(piece);
        }
        ASSERT_EQ(odd.count(), 3U) << size;
        ASSERT_EQ(odd.line(), 3U) << size;
        ASSERT_EQ(odd.column(), 4U) << size;
        ASSERT_EQ(odd.size(), kOdd.size());
    }
}

}  // namespace
}  // namespace tribus::burst_reader_test
