#include "transports/codecs/ppm/ppm.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "tests/support/channel_bytes.h"
#include "tests/support/edges.h"
#include "tests/unit/config/main_job.h"
#include "transports/links/pulse_line/pulse_line_medium.h"
#include "transports/registry/registry.h"

namespace tribus::test::ppm_test {
namespace {

using namespace std::chrono_literals;
using Lines = std::vector<std::string>;
using Channels = std::vector<double>;

const Channels kSticks{1500, 1000, 2000, 1500, 1200, 1800, 1500.125, 1499.875};

/// A decoder that knows how many channels its sender has.
class Trained {
  public:
    explicit Trained(const Channels& channels = kSticks, std::size_t median = 1)
        : decoder_(median) {
        EXPECT_EQ(hear(ppm_frame(channels)), std::vector<Channels>{});
        EXPECT_EQ(hear(ppm_frame(channels)), std::vector<Channels>{channels});
    }
    std::vector<Channels> hear(const Bytes& bytes, Duration at = {}) {
        std::vector<Channels> heard;
        for (const DecodedFrame& frame : feed(decoder_, bytes, kOneRead, Instant{} + at)) {
            EXPECT_TRUE(frame.channels.good());
            heard.push_back(pulses_of(frame.channels));
        }
        return heard;
    }
    std::uint64_t refused() const {
        std::uint64_t sum = 0;
        for (const NamedCount& cause : decoder_.rejected()) {
            sum += cause.count;
        }
        return sum;
    }
    std::uint64_t refused(std::string_view cause) const { return count_of(decoder_, cause); }
    PpmDecoder& decoder() { return decoder_; }

  private:
    PpmDecoder decoder_;
};

/// The frame without the edge `lost`: the two distances beside it become one.
Bytes without_edge(const Channels& channels, std::size_t lost) {
    Channels left = channels;
    left[lost + 1] += left[lost];
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(lost));
    return ppm_frame(left);
}

TEST(Ppm, TakesTheDistanceOfTwoEdgesAsAChannel) {
    Trained line;
    const Channels moved{1100, 1200, 1300, 1400, 1500, 1600, 1700, 1800};
    EXPECT_EQ(line.hear(ppm_frame(moved)), std::vector<Channels>{moved});
    EXPECT_EQ(line.refused(), 0U);
}

TEST(Ppm, GivesAFrameOnceWhenTheLineIsQuietOrElseAtTheNextFirstEdge) {
    Trained line;
    EXPECT_EQ(line.hear(ppm_edges(kSticks)), std::vector<Channels>{});
    EXPECT_EQ(line.hear(quiet_record()), std::vector<Channels>{kSticks});
    EXPECT_EQ(line.hear(quiet_record()), std::vector<Channels>{});
    EXPECT_EQ(line.hear(ppm_edges(kSticks)), std::vector<Channels>{});
    EXPECT_EQ(line.hear(edge_record(Edge::seen, 2700 * 8)), std::vector<Channels>{kSticks});
}

TEST(Ppm, ReadsEveryDistanceFrom700To2300AndNoOther) {
    Trained line;
    for (std::uint32_t eighths = 600 * 8; eighths < 2700 * 8; ++eighths) {
        Channels channels = kSticks;
        channels[3] = eighths / 8.0;
        const bool is_channel = eighths >= 700 * 8 && eighths <= 2300 * 8;
        ASSERT_EQ(line.hear(ppm_frame(channels)),
                  is_channel ? std::vector<Channels>{channels} : std::vector<Channels>{})
            << eighths;
    }
    EXPECT_EQ(line.refused("distance"), 8U * (100 + 400) - 1);
}

TEST(Ppm, ReadsFourToEighteenChannels) {
    for (std::size_t count = 1; count <= 20; ++count) {
        PpmDecoder decoder(1);
        Channels channels;
        for (std::size_t channel = 0; channel < count; ++channel) {
            channels.push_back(1000.0 + 10.0 * static_cast<double>(channel));
        }
        Bytes line;
        for (int frame = 0; frame < 10; ++frame) {
            append(line, ppm_frame(channels));
        }
        const auto frames = feed(decoder, line);
        ASSERT_EQ(frames.size(), count >= 4 && count <= 18 ? 9U : 0U) << count;
        for (const DecodedFrame& frame : frames) {
            ASSERT_EQ(pulses_of(frame.channels), channels);
        }
    }
}

// Two low channels without the edge between them look like one channel.
TEST(Ppm, ALostEdgeKillsItsFrameAndNoOther) {
    const Channels low(8, 1000);
    Trained line(low);
    for (std::size_t lost = 0; lost < 7; ++lost) {
        EXPECT_EQ(line.hear(without_edge(low, lost)), std::vector<Channels>{}) << lost;
        EXPECT_EQ(line.refused("channel_count"), lost + 1);
        EXPECT_EQ(line.hear(ppm_frame(low)), std::vector<Channels>{low}) << lost;
    }
}

TEST(Ppm, AnEdgeTooManyKillsItsFrameAndNoOther) {
    const Channels high(8, 2000);
    Trained line(high);
    for (std::size_t split = 0; split < 8; ++split) {
        Channels more = high;
        more[split] = 900;
        more.insert(more.begin() + static_cast<std::ptrdiff_t>(split), 1100);
        EXPECT_EQ(line.hear(ppm_frame(more)), std::vector<Channels>{}) << split;
        EXPECT_EQ(line.hear(ppm_frame(high)), std::vector<Channels>{high}) << split;
    }
    EXPECT_EQ(line.refused("channel_count"), 8U);
}

TEST(Ppm, AnEdgeAfterALossKillsTheFrameThatItIsIn) {
    Trained line;
    for (std::size_t at = 0; at <= 8; ++at) {
        Bytes frame = ppm_frame(kSticks);
        frame[at * 5] = 0xE1;
        frame[at * 5 + 4] ^= 1;
        EXPECT_EQ(line.hear(frame), std::vector<Channels>{}) << at;
        EXPECT_EQ(line.hear(ppm_frame(kSticks)), std::vector<Channels>{kSticks}) << at;
    }
}

// As the link marks it: nobody knows how many edges came since the edge before.
TEST(Ppm, AnEdgeAfterALossEndsNoFrame) {
    Trained line;
    line.hear(ppm_edges(kSticks));
    EXPECT_EQ(line.hear(edge_record(Edge::after_loss, 0xFFFFFF)), std::vector<Channels>{});
    EXPECT_EQ(line.hear(quiet_record()), std::vector<Channels>{});
    EXPECT_EQ(line.refused("edge_lost"), 1U);
}

TEST(Ppm, AFlippedBitNeverGivesAnotherFrame) {
    const Bytes frame = ppm_frame(kSticks);
    for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
        Trained line;
        Bytes flipped = frame;
        flipped[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        append(flipped, ppm_frame(kSticks));
        for (const Channels& heard : line.hear(flipped)) {
            ASSERT_EQ(heard, kSticks) << bit;
        }
        EXPECT_EQ(line.hear(ppm_frame(kSticks)), std::vector<Channels>{kSticks}) << bit;
    }
}

TEST(Ppm, AnotherNumberOfChannelsCountsFromTheFifthFrameRunning) {
    Trained line;
    const Channels six(6, 1300);
    for (int frame = 1; frame <= 4; ++frame) {
        EXPECT_EQ(line.hear(ppm_frame(six)), std::vector<Channels>{}) << frame;
    }
    EXPECT_EQ(line.hear(ppm_frame(kSticks)), std::vector<Channels>{kSticks});
    for (int frame = 1; frame <= 4; ++frame) {
        EXPECT_EQ(line.hear(ppm_frame(six)), std::vector<Channels>{}) << frame;
    }
    EXPECT_EQ(line.hear(ppm_frame(six)), std::vector<Channels>{six});
    EXPECT_EQ(line.hear(ppm_frame(six)), std::vector<Channels>{six});
}

TEST(Ppm, AfterAResetTheFirstFrameOnlyTellsTheNumberOfChannels) {
    Trained line;
    line.hear(ppm_edges(kSticks));
    line.decoder().reset();
    EXPECT_EQ(line.hear(quiet_record()), std::vector<Channels>{}) << "it is cut in two";
    EXPECT_EQ(line.hear(ppm_frame(kSticks)), std::vector<Channels>{});
    EXPECT_EQ(line.hear(ppm_frame(kSticks)), std::vector<Channels>{kSticks});
}

TEST(Ppm, AMedianOfThreeHidesOneWrongPulse) {
    Trained line(kSticks, 3);
    const auto with_first = [](double first) {
        Channels channels = kSticks;
        channels[0] = first;
        return channels;
    };
    const auto heard_first = [&](double first, Duration at) {
        const auto heard = line.hear(ppm_frame(with_first(first)), at);
        return heard.size() == 1 ? heard[0][0] : 0;
    };
    EXPECT_EQ(heard_first(1500, 20ms), 1500);
    EXPECT_EQ(heard_first(1500, 40ms), 1500);
    EXPECT_EQ(heard_first(2100, 60ms), 1500) << "one wrong pulse";
    EXPECT_EQ(heard_first(1510, 80ms), 1510);
    EXPECT_EQ(heard_first(1600, 100ms), 1600);
    EXPECT_EQ(heard_first(1700, 120ms), 1600);
}

TEST(Ppm, AMedianHasNoFrameFromBeforeAPause) {
    Trained line(kSticks, 5);
    const Channels moved(8, 1100);
    for (int frame = 1; frame <= 5; ++frame) {
        line.hear(ppm_frame(kSticks), frame * 22ms);
    }
    EXPECT_EQ(line.hear(ppm_frame(moved), 111ms), std::vector<Channels>{kSticks});
    EXPECT_EQ(line.hear(ppm_frame(moved), 212ms), std::vector<Channels>{moved});
}

// 1500 us are 12000 eighths, 0x2EE0; the pause of 3000 us is 24000, 0x5DC0.
TEST(PpmEncoder, WritesThePauseTheEdgesAndThePauseBehindThem) {
    PpmEncoder encoder(4);
    EXPECT_EQ(encoded(encoder, frame_of_microseconds({1500, 1000, 2000, 1500.125, 1234})),
              from_hex("e0 c0 5d 00 7d  e0 e0 2e 00 2e  e0 40 1f 00 bf  e0 80 3e 00 5e"
                       "e0 e1 2e 00 2f  e2 c0 5d 00 7f"));
    EXPECT_EQ(encoder.needed_channels({}), 0xFU);
}

TEST(PpmEncoder, LimitsEachPulseToWhatIsAChannelAndIsReadAgainExactly) {
    PpmEncoder encoder(6);
    PpmDecoder decoder(1);
    for (int eighths = -32768; eighths <= 32767; ++eighths) {
        ChannelFrame frame = frame_of_microseconds({1500, 1500, 1500, 1500, 1500, 1500});
        frame.set(5, Pulse::from_eighths(eighths));
        const auto frames = feed(decoder, encoded(encoder, frame));
        if (eighths == -32768) {
            continue;
        }
        ASSERT_EQ(frames.size(), 1U) << eighths;
        ASSERT_EQ(frames[0].channels.channel(5)->eighths(), std::clamp(eighths, 700 * 8, 2300 * 8));
    }
}

TEST(PpmEncoder, WritesNoEdgeInSilence) {
    PpmEncoder encoder(8);
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder.write_silence(wire, {});
    EXPECT_EQ(Bytes(wire.begin(), wire.begin() + static_cast<std::ptrdiff_t>(length)),
              edge_record(Edge::quiet, 3000 * 8));
}

std::string from_ppm(const std::string& lines) {
    return "[input.trainer]\nprotocol = \"ppm\"\n" + lines +
           "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyA\"\n"
           "[pipeline.main]\nfrom = \"trainer\"\nto = \"servos\"\n";
}

std::string to_ppm(const std::string& lines) {
    return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
           "[output.trainer]\nprotocol = \"ppm\"\n" +
           lines + "[pipeline.main]\nfrom = \"receiver\"\nto = \"trainer\"\n";
}

TEST(Ppm, ComesByAGpioLineAndLeavesByAnSpiPort) {
    EXPECT_EQ(media_for(kPpmProtocol), std::vector<const Medium*>{&kPulseLineMedium});
    EXPECT_EQ(mistakes_in(from_ppm("line = \"GPIO17\"\nedge = \"falling\"\nbias = \"pull_up\"\n"
                                   "median = 3\n")),
              Lines{});
    EXPECT_EQ(mistakes_in(from_ppm("line = \"/dev/gpiochip0:17\"\n")), Lines{});
    EXPECT_EQ(mistakes_in(to_ppm("line = \"/dev/spidev0.0\"\nchannels = 6\ncalibration = 1.01\n")),
              Lines{});
    EXPECT_EQ(mistakes_in(from_ppm("line = \"/dev/spidev0.0\"\n")),
              Lines{"t.toml:3:8: \"line\" is \"/dev/spidev0.0\"; allowed for an input: a GPIO "
                    "line, such as \"GPIO17\""});
    EXPECT_EQ(mistakes_in(to_ppm("line = \"GPIO17\"\n")),
              Lines{"t.toml:6:8: \"line\" is \"GPIO17\"; allowed for an output: an SPI port, such "
                    "as \"/dev/spidev0.0\", whose data line (MOSI) makes the pulses"});
    EXPECT_EQ(mistakes_in(from_ppm("line = \"GPIO17\"\nmedian = 2\n")),
              Lines{"t.toml:4:10: \"median\" is 2; allowed: 1, 3, 5"});
    EXPECT_EQ(mistakes_in(from_ppm("")).size(), 1U) << "line is required";
}

TEST(Ppm, MoreThanEightChannelsTakeLonger) {
    const auto period_of = [](const std::string& lines) {
        return loaded(to_ppm("line = \"/dev/spidev0.0\"\n" + lines)).outputs.at(0).schedule.period;
    };
    EXPECT_EQ(period_of(""), 22500us);
    EXPECT_EQ(period_of("channels = 4\n"), 22500us);
    EXPECT_EQ(period_of("channels = 12\n"), 32500us);
    EXPECT_EQ(period_of("channels = 12\nperiod = \"40ms\"\n"), 40ms);
    EXPECT_EQ(loaded(from_ppm("line = \"GPIO17\"\n")).inputs.at(0).supervision.timeout, 150ms)
        << "the sender decides";
    // The longest pulses of all channels and a pause fit into it.
    for (std::size_t channels = 4; channels <= 12; ++channels) {
        EXPECT_GE(ppm_period(channels), channels * 2300us + 3000us) << channels;
    }
}

}  // namespace
}  // namespace tribus::test::ppm_test
