#include "transports/codecs/crsf/handset.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <vector>

#include "tests/reference/plain_crsf.h"
#include "tests/support/streams.h"
#include "transports/codecs/crsf/crsf.h"

namespace tribus::test::crsf_handset_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_crsf;
using reference::plain_crsf_timing;

constexpr Instant kNow = Instant(1h);

ChannelFrame centred() {
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, kCentrePulse);
    }
    return frame;
}

Bytes sent(CrsfHandsetEncoder& encoder, const ChannelFrame& frame = centred()) {
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write(frame, wire, kNow);
    return {wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// docs/protocols/crsf.md: all 992 = 1500 us, with the address of a module.
TEST(CrsfHandset, WritesChannelsToTheModule) {
    CrsfHandsetEncoder encoder(std::nullopt);
    EXPECT_EQ(sent(encoder), plain_crsf(0xEE, 0x16,
                                        from_hex("E0031FF8C0073EF0810F7CE0031FF8C0073E"
                                                 "F0810F7C")));
}

TEST(CrsfHandset, WritesEveryPulseAsTheReceiverRoleDoes) {
    CrsfHandsetEncoder handset(std::nullopt);
    CrsfEncoder receiver;
    ChannelFrame frame = centred();
    for (int eighths = 0; eighths <= 8 * 2500; ++eighths) {
        frame.set(static_cast<std::size_t>(eighths) % 16, Pulse::from_eighths(eighths));
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        const std::size_t length = receiver.write(frame, wire, kNow);
        const Bytes bytes = sent(handset, frame);
        ASSERT_EQ(bytes.size(), length);
        ASSERT_EQ(bytes[0], 0xEE);
        ASSERT_TRUE(std::equal(bytes.begin() + 1, bytes.end(), wire.begin() + 1)) << eighths;
    }
}

TEST(CrsfHandset, SaysNothingWhileSilent) {
    CrsfHandsetEncoder encoder(1);
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    EXPECT_EQ(encoder.write_silence(wire, kNow), 0U);
}

TEST(CrsfHandset, HearsTheTimingThatTheModuleAsksFor) {
    CrsfHandsetEncoder encoder(std::nullopt);
    const auto later = encoder.hear(plain_crsf_timing(40000, 1234), kNow);
    ASSERT_TRUE(later);
    EXPECT_EQ(later->period, 4ms);
    EXPECT_EQ(later->later, 123400ns);
    const auto sooner = encoder.hear(plain_crsf_timing(66670, -5), kNow);
    ASSERT_TRUE(sooner);
    EXPECT_EQ(sooner->period, 6667us);
    EXPECT_EQ(sooner->later, -500ns);
}

TEST(CrsfHandset, HearsAModuleWhoseFramesBeginWithTheSyncByte) {
    CrsfHandsetEncoder encoder(3);
    const auto asked = encoder.hear(plain_crsf_timing(200000, -5, 0xC8), kNow);
    ASSERT_TRUE(asked);
    EXPECT_EQ(asked->period, 20ms);
    EXPECT_EQ(asked->later, -500ns);
    EXPECT_EQ(sent(encoder).at(7), 3U);
    EXPECT_EQ(sent(encoder).size(), 26U);
    EXPECT_EQ(encoder.hear(plain_crsf_timing(20000, 0, 0xC8), kNow + 200ms)->period, 2ms);
    EXPECT_EQ(sent(encoder).size(), 26U);
}

TEST(CrsfHandset, TakesTheLastOfSeveralTimings) {
    CrsfHandsetEncoder encoder(std::nullopt);
    Bytes bytes = plain_crsf_timing(40000, 1);
    append(bytes, plain_crsf_timing(20000, 2));
    EXPECT_EQ(encoder.hear(bytes, kNow)->period, 2ms);
}

TEST(CrsfHandset, HearsTimingWhereverTheReadsAreCut) {
    const Bytes bytes = plain_crsf_timing(40000, 1);
    for (std::size_t cut = 1; cut < bytes.size(); ++cut) {
        CrsfHandsetEncoder encoder(std::nullopt);
        EXPECT_FALSE(encoder.hear(std::span(bytes).first(cut), kNow));
        EXPECT_TRUE(encoder.hear(std::span(bytes).subspan(cut), kNow)) << cut;
    }
}

TEST(CrsfHandset, ForgetsABeginningBeforeAGap) {
    const Bytes bytes = plain_crsf_timing(40000, 1);
    CrsfHandsetEncoder encoder(std::nullopt);
    EXPECT_FALSE(encoder.hear(std::span(bytes).first(5), kNow));
    encoder.forget_heard();
    EXPECT_FALSE(encoder.hear(std::span(bytes).subspan(5), kNow));
}

TEST(CrsfHandset, TakesNoTimingThatIsNone) {
    CrsfHandsetEncoder encoder(std::nullopt);
    const Bytes good = plain_crsf_timing(40000, 1);
    for (std::size_t bit = 8; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        encoder.forget_heard();
        EXPECT_FALSE(encoder.hear(bytes, kNow)) << bit;
    }
    encoder.forget_heard();
    EXPECT_FALSE(encoder.hear(plain_crsf_timing(0, 1), kNow));
    EXPECT_FALSE(encoder.hear(plain_crsf(0xEA, 0x3A, {0xEA, 0xEE, 0x10, 0, 0, 0x9C, 0x40}), kNow));
    // To another device, of another kind, and an own frame that comes back.
    Bytes other = plain_crsf_timing(40000, 1);
    EXPECT_FALSE(encoder.hear(plain_crsf(0xEC, 0x3A, {other.begin() + 3, other.end() - 1}), kNow));
    EXPECT_FALSE(encoder.hear(
        plain_crsf(0xEA, 0x3A, {0xEA, 0xEE, 0x11, 0, 0, 0x9C, 0x40, 0, 0, 0, 0}), kNow));
    EXPECT_FALSE(encoder.hear(sent(encoder), kNow));
}

/// EE 08 32 EE EA 10 05, number, CRC-8 with polynomial BA of these, CRC-8 with D5
/// (docs/protocols/crsf.md, "Towards a transmitter module"). Both computed bit by bit.
TEST(CrsfHandset, TellsTheModelToAModuleThatAppears) {
    CrsfHandsetEncoder encoder(3);
    const Bytes channels = sent(encoder);
    EXPECT_EQ(channels.size(), 26U);
    encoder.hear(plain_crsf(0xEA, 0x14, Bytes(10)), kNow);
    const Bytes model = sent(encoder);
    unsigned inner = 0;
    for (const std::uint8_t byte : Bytes{0x32, 0xEE, 0xEA, 0x10, 0x05, 0x03}) {
        for (int bit = 7; bit >= 0; --bit) {
            const unsigned out = (inner >> 7U ^ byte >> static_cast<unsigned>(bit)) & 1U;
            inner = (inner << 1U & 0xFFU) ^ (out != 0 ? 0xBAU : 0U);
        }
    }
    EXPECT_EQ(model, plain_crsf(0xEE, 0x32,
                                {0xEE, 0xEA, 0x10, 0x05, 0x03, static_cast<std::uint8_t>(inner)}));
    EXPECT_EQ(sent(encoder), channels);
    encoder.hear(plain_crsf(0xEA, 0x14, Bytes(10)), kNow + 1999ms);
    EXPECT_EQ(sent(encoder), channels);
    encoder.hear(plain_crsf(0xEA, 0x14, Bytes(10)), kNow + 1999ms + 2s);
    EXPECT_EQ(sent(encoder), model);
}

/// On one wire the port hears what it sends.
TEST(CrsfHandset, TakesItsOwnFramesForNoModule) {
    CrsfHandsetEncoder encoder(3);
    const Bytes channels = sent(encoder);
    encoder.hear(channels, kNow);
    EXPECT_EQ(sent(encoder), channels);
}

TEST(CrsfHandset, TellsNoModelWithoutOne) {
    CrsfHandsetEncoder encoder(std::nullopt);
    encoder.hear(plain_crsf(0xEA, 0x14, Bytes(10)), kNow);
    EXPECT_EQ(sent(encoder).size(), 26U);
}

TEST(CrsfHandset, TellsAnotherModelAfterAReload) {
    CrsfHandsetEncoder before(3);
    before.hear(plain_crsf(0xEA, 0x14, Bytes(10)), kNow);
    sent(before);
    CrsfHandsetEncoder same(3);
    same.continue_from(before);
    EXPECT_EQ(sent(same).size(), 26U);
    CrsfHandsetEncoder other(4);
    other.continue_from(before);
    EXPECT_EQ(sent(other).at(7), 4U);
}

/// Sends channels each 4 ms from `from` to `until` after the start, while these bytes come back
/// behind each of them.
void send_for(CrsfHandsetEncoder& encoder, Duration from, Duration until, const Bytes& back = {}) {
    for (Duration at = from; at < until; at += 4ms) {
        std::array<std::uint8_t, kLongestSerialFrame> wire{};
        encoder.write(centred(), wire, kNow + at);
        encoder.hear(back, kNow + at + 1ms);
    }
}

TEST(CrsfHandset, KnowsThatItsModuleIsSilentThreeSecondsAfterChannelsGoToIt) {
    CrsfHandsetEncoder encoder(3);
    EXPECT_EQ(encoder.hearing(kNow + 10s), Hearing::not_awaited);
    const Bytes own = plain_crsf(0xEE, 0x16, Bytes(22));
    send_for(encoder, 0s, 2900ms, own);
    EXPECT_EQ(encoder.hearing(kNow + 2900ms), Hearing::not_awaited);
    send_for(encoder, 2900ms, 3100ms, own);
    EXPECT_EQ(encoder.hearing(kNow + 3100ms), Hearing::silent);
    EXPECT_EQ(encoder.hearing(kNow + 5s), Hearing::not_awaited) << "it sends nothing any more";
    send_for(encoder, 6s, 8s);
    EXPECT_EQ(encoder.hearing(kNow + 8s), Hearing::not_awaited);
}

TEST(CrsfHandset, KnowsThatBytesAreNoFrameOfAModule) {
    for (const bool damaged : {false, true}) {
        CrsfHandsetEncoder encoder(3);
        send_for(encoder, 0s, 4s);
        EXPECT_EQ(encoder.hearing(kNow + 4s), Hearing::silent);
        if (damaged) {
            encoder.forget_heard();
        }
        send_for(encoder, 4s, 4100ms, damaged ? Bytes{} : Bytes{0x55, 0xAA});
        EXPECT_EQ(encoder.hearing(kNow + 4100ms), Hearing::unreadable);
        send_for(encoder, 4100ms, 7s);
        EXPECT_EQ(encoder.hearing(kNow + 7s), Hearing::silent);
    }
}

TEST(CrsfHandset, KnowsThatItsModuleIsHeardUntilItWasSilentForTwoSeconds) {
    CrsfHandsetEncoder encoder(3);
    send_for(encoder, 0s, 4s);
    encoder.hear(plain_crsf_timing(40000, 0, 0xC8), kNow + 4s);
    EXPECT_EQ(encoder.hearing(kNow + 4s), Hearing::heard);
    send_for(encoder, 4s, 6100ms, {0x55});
    EXPECT_EQ(encoder.hearing(kNow + 5999ms), Hearing::heard);
    CrsfHandsetEncoder reloaded(3);
    reloaded.continue_from(encoder);
    EXPECT_EQ(reloaded.hearing(kNow + 5999ms), Hearing::heard);
    EXPECT_EQ(reloaded.hearing(kNow + 6100ms), Hearing::unreadable);
}

std::vector<std::string> mistakes(
    std::initializer_list<std::pair<std::string_view, SettingValue>> given) {
    SettingValues settings;
    for (const auto& [key, value] : given) {
        settings.set(key, value);
    }
    std::vector<std::string> texts;
    for (const SettingMistake& mistake : kCrsfProtocol.check(settings, SettingScope::output)) {
        texts.push_back(mistake.path.at(0));
    }
    return texts;
}

TEST(CrsfHandset, RefusesRatesAtWhichNoModuleLooks) {
    const SettingValue handset = std::string("handset");
    for (const std::int64_t good : {115200, 400000, 921600, 1870000, 2250000, 3750000, 5250000}) {
        EXPECT_TRUE(mistakes({{"role", handset}, {"baud", good}}).empty()) << good;
    }
    for (const std::int64_t wrong : {420000, 460800, 416666}) {
        EXPECT_EQ(mistakes({{"role", handset}, {"baud", wrong}}), std::vector<std::string>{"baud"});
    }
    EXPECT_EQ(mistakes({{"model_id", std::int64_t{3}}}), std::vector<std::string>{"model_id"});
}

}  // namespace
}  // namespace tribus::test::crsf_handset_test
