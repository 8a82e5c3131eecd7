#include <poll.h>

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/lab/ppm_player.h"
#include "tests/lab/shell.h"
#include "tests/support/channel_bytes.h"
#include "transports/codecs/ppm/ppm.h"
#include "transports/links/pulse_line/edge_link.h"
#include "transports/links/pulse_line/pulse_line_medium.h"

/// Pulses on a line of a simulated chip (gpio-sim), read by the link and the decoder. The guest's
/// clock counts its instructions, so nothing that the host does moves an edge.
namespace tribus::test::ppm_line_test {
namespace {

using Channels = std::vector<double>;

const Channels kRest{1500, 1500, 1000, 1500, 1200, 1800, 1500, 1500};

class LabPpmLine : public testing::Test {
  protected:
    LabPpmLine() { require_guest(); }

    void open(GpioEdges edges = GpioEdges::rising) {
        auto link = EdgeLink::open(bank_.chip() + ":3", edges, GpioBias::as_is);
        ASSERT_TRUE(link.has_value()) << link.error();
        link_ = std::move(*link);
    }
    /// Waits until the link has something or its timer expires; at most a second.
    void wait() const {
        std::array<pollfd, 2> both{
            {{link_->descriptor(), POLLIN, 0}, {link_->second_descriptor(), POLLIN, 0}}};
        ::poll(both.data(), both.size(), 1000);
    }
    /// The next frame, once the line is quiet behind it; nothing if the line is quiet without one.
    std::optional<Channels> next_frame() {
        for (int waits = 0; waits < 3;) {
            Reception reception;
            if (link_->read(reception) != ReadStatus::received) {
                wait();
                ++waits;
                continue;
            }
            const bool quiet = reception.bytes[reception.count - 5] == 0xE2;
            std::span<const std::uint8_t> bytes = reception.view();
            DecodedFrame frame;
            if (decoder_.next(bytes, {}, frame)) {
                return pulses_of(frame.channels);
            }
            if (quiet) {
                return std::nullopt;
            }
        }
        return std::nullopt;
    }
    /// Plays until a frame counts: the first edge says nothing, the next frame only how many
    /// channels there are.
    void train(PpmPlayer& player) {
        std::optional<Channels> heard;
        for (int frame = 0; frame < 4 && !heard; ++frame) {
            player.play(kRest);
            heard = next_frame();
        }
        EXPECT_TRUE(heard.has_value());
    }

    GpioBank bank_;
    std::unique_ptr<EdgeLink> link_;
    PpmDecoder decoder_{1};
};

TEST_F(LabPpmLine, EachDistanceIsThatOfTheEdgesOnTheLine) {
    for (const GpioEdges edges : {GpioEdges::rising, GpioEdges::falling}) {
        link_.reset();
        open(edges);
        decoder_.reset();
        PpmPlayer player(bank_, 3);
        train(player);
        for (int number = 0; number < 60; ++number) {
            Channels channels = kRest;
            channels[0] = 1000 + 16 * number;
            channels[7] = 2000 - 16 * number;
            const PlayedFrame played = player.play(channels);
            const auto heard = next_frame();
            ASSERT_TRUE(heard.has_value()) << number;
            ASSERT_EQ(heard->size(), played.size());
            for (std::size_t channel = 0; channel < played.size(); ++channel) {
                // The falling edges are not those whose moments are known.
                const double slack = edges == GpioEdges::rising ? 0.125 : 20;
                EXPECT_GE(heard->at(channel), played[channel].least_us - slack) << number;
                EXPECT_LE(heard->at(channel), played[channel].most_us + slack) << number;
            }
        }
    }
}

TEST_F(LabPpmLine, ALateReaderLosesEdgesAndNoFrameIsWrong) {
    open();
    PpmPlayer player(bank_, 3);
    train(player);
    // More edges than the kernel keeps of any version of its interface.
    for (int frame = 0; frame < 10; ++frame) {
        player.play(Channels(8, 1100));
    }
    std::size_t frames = 0;
    for (int rest = 0; rest < 4; ++rest) {
        if (const auto heard = next_frame()) {
            EXPECT_EQ(heard->size(), 8U);
            for (const double channel : *heard) {
                EXPECT_NEAR(channel, 1100, 60) << "two channels in one would be 2200";
            }
            ++frames;
        }
    }
    EXPECT_LT(frames, 10U) << "edges were lost";
    train(player);
}

TEST_F(LabPpmLine, IsLostWhenItsChipGoesAndOpensAgain) {
    open();
    {
        PpmPlayer player(bank_, 3);
        train(player);
    }
    bank_.remove();
    Reception reception;
    bool lost = false;
    for (int reads = 0; reads < 10 && !lost; ++reads) {
        lost = link_->read(reception) == ReadStatus::lost;
        if (!lost) {
            wait();
        }
    }
    EXPECT_TRUE(lost);
    EXPECT_TRUE(kPulseLineMedium.is_missing("gpiochip99:3"));
    link_.reset();
    bank_.put_back();
    EXPECT_FALSE(kPulseLineMedium.is_missing(bank_.chip() + ":3"));
    open();
    decoder_.reset();
    PpmPlayer again(bank_, 3);
    train(again);
}

}  // namespace
}  // namespace tribus::test::ppm_line_test
