#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/dbc_maps.h"
#include "tests/support/streams.h"
#include "transports/codecs/dbc/dbc.h"

/// Random maps over random signals: decoding returns what was encoded, within one step of the
/// signal.
namespace tribus::dbc_round_trip_test {
namespace {

using namespace test;

struct RandomMap {
    std::string dbc;
    std::string signals;
    std::vector<double> step;  ///< one for each channel, in microseconds
};

int between(Random& random, int least, int most) {
    return least + static_cast<int>(random() % static_cast<unsigned>(most - least + 1));
}

/// Returns up to four messages full of signals of 4 to 24 bits. Each signal has whole bytes for
/// itself, so signals do not overlap in either byte order.
RandomMap random_map(Random& random, const std::string& protection, bool in_json) {
    RandomMap map;
    const int messages = between(random, 1, 4);
    int channel = 0;
    for (int m = 0; m < messages; ++m) {
        const std::string name = "M" + std::to_string(m);
        const bool extended = random() % 2 == 0;
        const unsigned id = 0x100U + static_cast<unsigned>(m) + (extended ? 0x80000000U : 0U);
        map.dbc += "BO_ " + std::to_string(id) + " " + name + ": 8 A\n" + protection;
        map.signals += (m == 0 ? "{\"" : ", \"") + name + "\": {";
        bool first = !in_json;
        if (in_json) {
            map.signals += R"("Check": {"checksum": "crc8_2f"}, "Count": {"counter": true})";
        }
        for (int byte = 2; byte < 8 && channel < 18;) {
            const int bytes = std::min(between(random, 1, 3), 8 - byte);
            const int bits = between(random, 8 * bytes - 4, 8 * bytes);
            const bool motorola = random() % 2 == 0;
            const bool is_signed = random() % 2 == 0;
            const double factor = 0.25 * between(random, 1, 20);
            const double offset = between(random, -500, 500);
            const double low = is_signed ? -std::ldexp(1.0, bits - 1) : 0;
            const double high = low + std::ldexp(1.0, bits) - 1;
            const std::string signal = "S" + std::to_string(channel);
            map.dbc +=
                " SG_ " + signal + " : " + std::to_string(motorola ? byte * 8 + 7 : byte * 8) +
                "|" + std::to_string(bits) + (motorola ? "@0" : "@1") + (is_signed ? "-" : "+") +
                " (" + std::to_string(factor) + "," + std::to_string(offset) + ") [0|0] \"\" B\n";
            const bool reversed = random() % 2 == 0;
            map.signals += (first ? "\"" : ", \"") + signal + R"(": {"channel": )" +
                           std::to_string(channel + 1) + R"(, "value": [)" +
                           std::to_string(low * factor + offset) + ", " +
                           std::to_string(high * factor + offset) + R"(], "us": )" +
                           (reversed ? "[2000, 1000]" : "[1000, 2000]") + "}";
            first = false;
            map.step.push_back(1000 / (high - low));
            byte += bytes;
            ++channel;
        }
        map.signals += "}";
    }
    map.signals += "}";
    return map;
}

constexpr const char* kProtection =
    " SG_ Check : 0|8@1+ (1,0) [0|255] \"\" B\n SG_ Count : 8|8@1+ (1,0) [0|255] \"\" B\n";

TEST(DbcRoundTrip, GivesBackEachChannelToTheStepOfItsSignal) {
    Random random(1);
    for (int round = 0; round < 300; ++round) {
        const RandomMap map = random_map(random, "", false);
        SCOPED_TRACE(map.dbc + map.signals);
        DbcEncoder encoder(dbc_map(dbc_settings(map.dbc, map.signals), SettingScope::output));
        DbcDecoder decoder(dbc_map(dbc_settings(map.dbc, map.signals), SettingScope::input));
        for (int snapshot = 0; snapshot < 20; ++snapshot) {
            std::vector<double> sent;
            for (std::size_t i = 0; i < map.step.size(); ++i) {
                sent.push_back(between(random, 1000, 2000));
            }
            std::optional<ChannelFrame> received;
            for (const CanFrame& frame : frames_of(encoder, channels(sent), at(20 * snapshot))) {
                ASSERT_FALSE(received) << "a snapshot was published before its last frame";
                received = decoder.next(frame, at(20 * snapshot));
            }
            ASSERT_TRUE(received);
            ASSERT_TRUE(received->good());
            for (std::size_t i = 0; i < sent.size(); ++i) {
                constexpr double kRoundingOfPulse = 0.0626;
                ASSERT_NEAR(received->channel_or(i, {}).microseconds(), sent[i],
                            map.step[i] / 2 + kRoundingOfPulse)
                    << i;
            }
        }
    }
}

TEST(DbcRoundTrip, AnySingleFlippedBitIsRefusedWhereThereIsACrc) {
    Random random(2);
    for (int round = 0; round < 50; ++round) {
        const RandomMap map = random_map(random, kProtection, true);
        SCOPED_TRACE(map.dbc + map.signals);
        DbcEncoder encoder(dbc_map(dbc_settings(map.dbc, map.signals), SettingScope::output));
        DbcDecoder decoder(dbc_map(dbc_settings(map.dbc, map.signals), SettingScope::input));
        for (int snapshot = 0; snapshot < 4; ++snapshot) {
            const auto frames = frames_of(encoder, channels({1100, 1300, 1700}), at(20 * snapshot));
            for (const CanFrame& frame : frames) {
                for (unsigned bit = 0; bit < 64; ++bit) {
                    CanFrame flipped = frame;
                    flipped.data[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
                    const std::uint64_t before = rejected(decoder, "checksum");
                    ASSERT_FALSE(decoder.next(flipped, at(20 * snapshot)));
                    ASSERT_EQ(rejected(decoder, "checksum"), before + 1) << bit;
                }
                const bool last = &frame == &frames.back();
                ASSERT_EQ(decoder.next(frame, at(20 * snapshot)).has_value(),
                          last && snapshot >= 2);
            }
        }
    }
}

TEST(DbcRoundTrip, AnyFramesGiveWholeSnapshotsOrNone) {
    Random random(3);
    for (int round = 0; round < 100; ++round) {
        const RandomMap map = random_map(random, kProtection, round % 2 == 0);
        SCOPED_TRACE(map.dbc + map.signals);
        DbcDecoder decoder(dbc_map(dbc_settings(map.dbc, map.signals), SettingScope::input));
        for (int i = 0; i < 500; ++i) {
            CanFrame frame{.id = 0x100U + random.below(5),
                           .extended = random() % 2 == 0,
                           .remote = random.below(20) == 0,
                           .fd = random.below(20) == 0,
                           .length = static_cast<std::uint8_t>(random.below(9))};
            frame.length = random() % 2 == 0 ? std::uint8_t{8} : frame.length;
            for (std::uint8_t& byte : frame.data) {
                byte = random.byte();
            }
            const auto snapshot = decoder.next(frame, at(i));
            for (std::size_t channel = 0; snapshot && channel < map.step.size(); ++channel) {
                ASSERT_TRUE(snapshot->failsafe || snapshot->has(channel)) << channel;
            }
        }
    }
}

}  // namespace
}  // namespace tribus::dbc_round_trip_test
