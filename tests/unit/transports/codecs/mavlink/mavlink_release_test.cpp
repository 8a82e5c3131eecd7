#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/channel_bytes.h"
#include "tests/support/streams.h"
#include "tests/unit/transports/codecs/mavlink/mavlink_messages.h"
#include "transports/codecs/mavlink/mavlink.h"

/// Which channels an output gives back, when, and to whom.
namespace tribus::test::mavlink_release_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};
constexpr auto kOverrides = MavlinkChannels::rc_channels_override;

/// What a message of RC_CHANNELS_OVERRIDE does with a channel.
constexpr char kAlone = '.';
constexpr char kBack = 'b';
constexpr char kSteered = 's';

struct Override {
    unsigned target = 0;
    unsigned system = 0;
    std::string channels;  ///< a letter each, 1 to 18

    bool operator==(const Override&) const = default;
};
void PrintTo(const Override& said, std::ostream* stream) {
    *stream << said.system << " to " << said.target << ": " << said.channels;
}

/// The override that a frame begins with; nothing if it is another message. In channels 1 to 8,
/// 65535 leaves a channel alone and 0 gives it back; in 9 to 18, 0 or 65535 leaves it alone and
/// 65534 gives it back (common.xml).
std::optional<Override> override_in(const Bytes& bytes) {
    if (bytes.empty()) {
        return std::nullopt;
    }
    const bool old = bytes[0] == 0xFE;
    const std::size_t header = old ? 6 : 10;
    if (bytes.at(old ? 5 : 7) != 70 || (!old && (bytes.at(8) != 0 || bytes.at(9) != 0))) {
        return std::nullopt;
    }
    Bytes payload(bytes.begin() + static_cast<std::ptrdiff_t>(header),
                  bytes.begin() + static_cast<std::ptrdiff_t>(header + bytes.at(1)));
    payload.resize(38);
    Override said{payload[16], bytes.at(old ? 3 : 5), ""};
    for (std::size_t channel = 0; channel < 18; ++channel) {
        const std::size_t at = channel < 8 ? 2 * channel : 2 + 2 * channel;
        const unsigned word = payload[at] | static_cast<unsigned>(payload[at + 1]) << 8U;
        const bool first = channel < 8;
        const bool alone = word == 65535 || (!first && word == 0);
        said.channels += alone ? kAlone : word == (first ? 0U : 65534U) ? kBack : kSteered;
    }
    return said;
}

/// An output that a configuration has, then another.
class MavlinkRelease : public testing::Test {
  protected:
    MavlinkRelease() { load({.message = kOverrides, .channels = 8, .releases = true}); }
    void load(const MavlinkEncoder::Settings& settings) {
        auto fresh = std::make_unique<MavlinkEncoder>(settings);
        if (encoder_) {
            fresh->continue_from(*encoder_);
        }
        encoder_ = std::move(fresh);
    }
    Bytes steer() { return encoded(*encoder_, frame_, now_ += 20ms); }
    Bytes silence() {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = encoder_->write_silence(wire, now_ += 20ms);
        return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
    }
    /// The next `count` messages all are this.
    void expect_steered(int count, const Override& expected) {
        for (int i = 0; i < count; ++i) {
            ASSERT_EQ(override_in(steer()), expected) << i;
        }
    }
    void expect_silent(int count, const Override& expected) {
        for (int i = 0; i < count; ++i) {
            ASSERT_EQ(override_in(silence()), expected) << i;
        }
        EXPECT_EQ(silence(), Bytes{});
    }

  private:
    ChannelFrame frame_ = frame_of_microseconds(std::vector<double>(18, 1500));
    std::unique_ptr<MavlinkEncoder> encoder_;
    Instant now_ = kStart;
};

TEST_F(MavlinkRelease, GivesBackOnlyItsOwnChannels) {
    expect_steered(1, {1, 255, "ssssssss.........."});
    expect_silent(10, {1, 255, "bbbbbbbb.........."});
    load({.message = kOverrides, .channels = 11, .releases = true});
    expect_steered(1, {1, 255, "sssssssssss......."});
    expect_silent(10, {1, 255, "bbbbbbbbbbb......."});
    load({.message = kOverrides, .channels = 3, .releases = true});
    expect_steered(1, {1, 255, "sss..............."});
    expect_silent(10, {1, 255, "bbb..............."});
}

TEST_F(MavlinkRelease, AfterAReloadWithFewerChannelsStandsInTheNextTenMessages) {
    steer();
    load({.message = kOverrides, .channels = 4, .releases = true});
    expect_steered(10, {1, 255, "ssssbbbb.........."});
    expect_steered(5, {1, 255, "ssss.............."});
}

TEST_F(MavlinkRelease, AfterAReloadGoesOnWhileTheOutputIsSilent) {
    steer();
    load({.message = kOverrides, .channels = 4, .releases = true});
    expect_steered(3, {1, 255, "ssssbbbb.........."});
    for (int i = 0; i < 7; ++i) {
        EXPECT_EQ(override_in(silence()), (Override{1, 255, "bbbbbbbb.........."})) << i;
    }
    expect_silent(3, {1, 255, "bbbb.............."});
}

TEST_F(MavlinkRelease, AfterAReloadToAnotherTargetComesFirstAndGoesToTheOldOne) {
    steer();
    load({.message = kOverrides, .system = 254, .target = 2, .channels = 8, .releases = true});
    expect_steered(10, {1, 255, "bbbbbbbb.........."});
    expect_steered(5, {2, 254, "ssssssss.........."});
    expect_silent(10, {2, 254, "bbbbbbbb.........."});
}

/// An autopilot may refuse the new sender.
TEST_F(MavlinkRelease, AfterAReloadToAnotherSenderComesFirstAsTheOldOne) {
    steer();
    load({.message = kOverrides, .system = 254, .channels = 8, .releases = true});
    expect_steered(10, {1, 255, "bbbbbbbb.........."});
    expect_steered(5, {1, 254, "ssssssss.........."});
    load({.message = kOverrides, .system = 254, .component = 191, .channels = 8, .releases = true});
    for (int i = 0; i < 10; ++i) {
        EXPECT_EQ(steer().at(6), 190) << i;
    }
    EXPECT_EQ(steer().at(6), 191);
}

TEST_F(MavlinkRelease, AfterAReloadToAnotherKeyComesFirstWithTheOldOne) {
    const SecretKey old_key{1};
    const SecretKey new_key{2};
    load({.message = kOverrides, .channels = 8, .releases = true, .key = old_key});
    steer();
    load({.message = kOverrides, .channels = 8, .releases = true, .key = new_key});
    MavlinkDecoder old_autopilot({.target = 1, .key = old_key});
    for (int i = 0; i < 10; ++i) {
        const Bytes release = steer();
        EXPECT_EQ(override_in(release), (Override{1, 255, "bbbbbbbb.........."})) << i;
        feed(old_autopilot, release);
    }
    EXPECT_EQ(count_of(old_autopilot, "wrong_signature"), 0U);
    expect_steered(5, {1, 255, "ssssssss.........."});
}

TEST_F(MavlinkRelease, AfterAReloadToAnotherTargetComesWhileTheOutputIsSilent) {
    steer();
    load({.message = kOverrides, .target = 2, .channels = 8, .releases = true});
    expect_silent(10, {1, 255, "bbbbbbbb.........."});
}

TEST_F(MavlinkRelease, AfterAReloadToAnotherMessageComesFirst) {
    for (const auto message :
         {MavlinkChannels::radio_rc_channels, MavlinkChannels::manual_control}) {
        load({.message = kOverrides, .channels = 8, .releases = true});
        steer();
        load({.message = message, .channels = 4});
        expect_steered(10, {1, 255, "bbbbbbbb.........."});
        EXPECT_EQ(override_in(steer()), std::nullopt);
        EXPECT_EQ(silence(), Bytes{});
    }
}

TEST_F(MavlinkRelease, ComesInVersion2ForChannelsThatVersion1CannotName) {
    load({.message = kOverrides, .channels = 12, .releases = true});
    steer();
    load({.message = kOverrides, .version_1 = true, .channels = 8, .releases = true});
    expect_steered(10, {1, 255, "........bbbb......"});
    expect_steered(5, {1, 255, "ssssssss.........."});
}

TEST_F(MavlinkRelease, EndsAtTheNextReloadThatSendsTheChannelsAgain) {
    steer();
    load({.message = kOverrides, .channels = 4, .releases = true});
    expect_steered(2, {1, 255, "ssssbbbb.........."});
    load({.message = kOverrides, .channels = 6, .releases = true});
    expect_steered(10, {1, 255, "ssssssbb.........."});
    expect_steered(2, {1, 255, "ssssss............"});
}

TEST_F(MavlinkRelease, GoesToTheFirstTargetAfterTwoReloadsInARow) {
    steer();
    load({.message = kOverrides, .target = 2, .channels = 8, .releases = true});
    expect_steered(4, {1, 255, "bbbbbbbb.........."});
    load({.message = kOverrides, .target = 3, .channels = 8, .releases = true});
    expect_steered(6, {1, 255, "bbbbbbbb.........."});
    expect_steered(2, {3, 255, "ssssssss.........."});
}

TEST_F(MavlinkRelease, IsSignedWithTheKeyOfBefore) {
    const SecretKey old_key{1};
    const SecretKey new_key{2};
    load({.message = kOverrides, .channels = 8, .releases = true, .key = old_key});
    steer();
    load({.message = kOverrides, .target = 2, .channels = 8, .releases = true, .key = new_key});
    MavlinkDecoder old_autopilot({.target = 1, .key = old_key});
    EXPECT_EQ(feed(old_autopilot, steer()).size(), 1U);
    EXPECT_EQ(count_of(old_autopilot, "wrong_signature"), 0U);
}

TEST_F(MavlinkRelease, DoesNotHappenWithoutTheKeyOnLoss) {
    load({.message = kOverrides, .channels = 8});
    steer();
    load({.message = kOverrides, .channels = 4});
    expect_steered(3, {1, 255, "ssss.............."});
    load({.message = kOverrides, .target = 2, .channels = 4});
    expect_steered(3, {2, 255, "ssss.............."});
    EXPECT_EQ(silence(), Bytes{});
}

TEST_F(MavlinkRelease, DoesNotHappenTwiceOrOfWhatWasNeverSent) {
    load({.message = kOverrides, .target = 2, .channels = 8, .releases = true});
    expect_steered(1, {2, 255, "ssssssss.........."});
    expect_silent(10, {2, 255, "bbbbbbbb.........."});
    load({.message = kOverrides, .target = 3, .channels = 4, .releases = true});
    expect_steered(1, {3, 255, "ssss.............."});
}

}  // namespace
}  // namespace tribus::test::mavlink_release_test
