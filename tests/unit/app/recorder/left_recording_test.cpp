#include "app/recorder/left_recording.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/recorder/recording_folder.h"
#include "app/replay/capture_text.h"
#include "tests/support/temporary_folder.h"
#include "transports/recordings/recording.h"

namespace tribus::test::left_recording_test {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

constexpr Instant kNow{10s};
constexpr std::size_t kRingBytes = CaptureRing::kLeastBytes;

struct alignas(64) Line {
    std::array<std::byte, 64> bytes{};
};

/// A ring as `record` makes it, with its own memory.
class Image {
  public:
    explicit Image(bool can) {
        CaptureRing ring = CaptureRing::create(bytes());
        for (std::uint8_t i = 0; i < 6; ++i) {
            const Instant at(1s + 7ms * i);
            if (can) {
                ring.record(Direction::read, frame_of(i), at);
            } else {
                ring.record(Bytes(45, i), at);
            }
        }
    }
    std::span<std::byte> bytes() { return std::as_writable_bytes(std::span(lines_)); }

  private:
    /// Returns a classic frame, or a frame that takes two pieces.
    static CanFrame frame_of(std::uint8_t number) {
        const bool fd = number % 2 == 1;
        CanFrame frame{.id = 0x123, .fd = fd, .length = fd ? std::uint8_t{48} : std::uint8_t{8}};
        frame.data.fill(number);
        return frame;
    }
    std::vector<Line> lines_ = std::vector<Line>(kRingBytes / sizeof(Line));
};

/// What a recording of that ring would hold.
std::string text_of(std::span<std::byte> image, bool can, Direction direction) {
    const auto ring = CaptureRing::adopt(image);
    CaptureText text({.can = can,
                      .interface = "can0",
                      .byte_time = 87us,
                      .zero = Instant{},
                      .zero_wall = 1'795'348'805s,
                      .end = kNow});
    if (ring) {
        std::vector<CapturePiece> pieces(kRingBytes / sizeof(CapturePiece));
        const auto batch = ring->read(0, pieces);
        text.take(std::span(pieces).first(batch.count));
        text.finish();
    }
    return direction == Direction::read ? text.read() : text.written();
}

/// Flips bits in each byte of a ring, one byte after the other, with each of these values.
void damage_each_byte(bool can) {
    Image image(can);
    for (std::byte& byte : image.bytes()) {
        const std::byte before = byte;
        for (const unsigned flip : {0x01U, 0x80U, 0x7FU, 0xFFU, 0x28U}) {
            byte = before ^ static_cast<std::byte>(flip);
            for (const Direction direction : {Direction::read, Direction::written}) {
                const auto recording =
                    parse_recording(text_of(image.bytes(), can, direction), "damaged");
                EXPECT_TRUE(recording)
                    << "byte " << &byte - image.bytes().data() << ": " << recording.error();
            }
        }
        byte = before;
    }
}

TEST(DamagedRing, GivesARecordingOfASerialPortThatCanBeReadWhicheverByteItIs) {
    damage_each_byte(false);
}

TEST(DamagedRing, GivesARecordingOfACanInterfaceThatCanBeReadWhicheverByteItIs) {
    damage_each_byte(true);
}

TEST(DamagedRing, LosesTheBurstOfTheDamagedPieceOnly) {
    Image image(false);
    // The byte count of the second piece of the third write is 21 bytes into that piece.
    image.bytes()[64 + 5 * sizeof(CapturePiece) + 21] = std::byte{0xFF};
    const auto recording =
        parse_recording(text_of(image.bytes(), false, Direction::written), "text");
    ASSERT_TRUE(recording) << recording.error();
    std::vector<int> values;
    for (const Burst& burst : recording->bursts) {
        EXPECT_EQ(burst.bytes.size(), 45U);
        values.push_back(burst.bytes.front());
    }
    EXPECT_EQ(values, (std::vector<int>{0, 1, 3, 4, 5}));
}

/// The two files that a killed process left behind.
class LeftFolder : public testing::Test {
  protected:
    LeftFolder() {
        plan_.begin = Instant(500ms);
        plan_.replay = "tribus simulate config.toml";
        plan_.ports.push_back({.ring = nullptr,
                               .can = false,
                               .device = "/dev/ttyAMA3",
                               .byte_time = 87us,
                               .read_file = "input-receiver.txt",
                               .written_file = "output-servos.txt",
                               .ring_file = "0.ring"});
        plan_.files.push_back({"config.toml", "# the configuration\n"});
        write("0.ring", image_.bytes());
    }
    void write(const std::string& name, std::span<const std::byte> bytes) {
        std::ofstream(folder_.path() / name, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
    }
    auto read() {
        const std::string text = plan_to_text(plan_);
        write(kRecordingPlanFile, std::as_bytes(std::span(text)));
        return read_left_recording(folder_.path(), kNow);
    }

    TemporaryFolder folder_;
    RecordingPlan plan_;
    Image image_{false};
};

TEST_F(LeftFolder, IsReadWithTheInstantOfItsNewestPiece) {
    const auto left = read();
    ASSERT_TRUE(left) << left.error();
    EXPECT_EQ(left->rings.size(), 1U);
    EXPECT_EQ(left->latest, Instant(1s + 35ms));
}

TEST_F(LeftFolder, WhoseNewestPieceIsDamagedGoesByTheOneBefore) {
    // The highest byte of the time in the last two pieces, which are the last write.
    for (const std::size_t piece : {10U, 11U}) {
        image_.bytes()[64 + piece * sizeof(CapturePiece) + 7] = std::byte{0x40};
    }
    write("0.ring", image_.bytes());
    const auto left = read();
    ASSERT_TRUE(left) << left.error();
    EXPECT_EQ(left->latest, Instant(1s + 28ms));
}

TEST_F(LeftFolder, WithANameThatLeadsElsewhereIsRefused) {
    for (const char* name : {"../0.ring", "/etc/passwd", "..", ".", "", "a/b"}) {
        plan_.ports[0].ring_file = name;
        EXPECT_FALSE(read()) << name;
    }
    plan_.ports[0].ring_file = "0.ring";
    for (const char* name : {"../x", "/tmp/x", "..", ".", "a/b", "config.toml", "README.txt"}) {
        plan_.ports[0].read_file = name;
        EXPECT_FALSE(read()) << name;
    }
    plan_.ports[0].read_file = "input-receiver.txt";
    for (const char* name : {"../x", "", "input-receiver.txt"}) {
        plan_.files[0].name = name;
        EXPECT_FALSE(read()) << name;
    }
    plan_.files[0].name = "config.toml";
    EXPECT_TRUE(read());
}

TEST_F(LeftFolder, WithTextOfSeveralLinesForTheReaderIsRefused) {
    plan_.replay = "true\n  rm -r /";
    EXPECT_FALSE(read());
}

TEST_F(LeftFolder, ThatBeganAfterNowIsRefused) {
    plan_.begin = kNow + 1s;
    EXPECT_FALSE(read());
}

TEST_F(LeftFolder, WithAByteTimeThatNoLineHasIsRefused) {
    for (const Duration byte_time : {Duration(-1), Duration(2s), Duration::max()}) {
        plan_.ports[0].byte_time = byte_time;
        EXPECT_FALSE(read()) << byte_time.count();
    }
}

TEST_F(LeftFolder, WithSomethingElseThanAFileIsRefusedAndNotWaitedFor) {
    const fs::path ring = folder_.path() / "0.ring";
    fs::remove(ring);
    ASSERT_EQ(::mkfifo(ring.c_str(), 0600), 0);
    EXPECT_FALSE(read());
    fs::remove(ring);
    fs::create_symlink("/dev/zero", ring);
    EXPECT_FALSE(read());
    fs::remove(ring);
    fs::create_directory(ring);
    EXPECT_FALSE(read());
    fs::remove(ring);
    write("0.ring", image_.bytes());
    ASSERT_TRUE(read());
    const fs::path plan = folder_.path() / kRecordingPlanFile;
    fs::remove(plan);
    ASSERT_EQ(::mkfifo(plan.c_str(), 0600), 0);
    EXPECT_FALSE(read_left_recording(folder_.path(), kNow));
}

TEST_F(LeftFolder, WithARingLargerThanAnyIsRefused) {
    fs::resize_file(folder_.path() / "0.ring", std::uintmax_t{1} << 40U);
    const auto left = read();
    ASSERT_FALSE(left);
    EXPECT_NE(left.error().find("1099511627776 bytes"), std::string::npos) << left.error();
}

TEST_F(LeftFolder, WithARingThatIsCutIsRefused) {
    fs::resize_file(folder_.path() / "0.ring", 1000);
    EXPECT_FALSE(read());
}

TEST_F(LeftFolder, InWhichNothingHadPassedIsRefused) {
    std::vector<Line> lines(kRingBytes / sizeof(Line));
    CaptureRing::create(std::as_writable_bytes(std::span(lines)));
    write("0.ring", std::as_bytes(std::span(lines)));
    EXPECT_FALSE(read());
}

}  // namespace
}  // namespace tribus::test::left_recording_test
