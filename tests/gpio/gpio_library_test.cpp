#include "transports/links/gpio/gpio_library.h"

#include <fcntl.h>
#include <sys/time.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "tests/support/gpiod_stand_in.h"

/// Lines as the library gives them. What a kernel does is shown in the laboratory (`lab_gpio`).
namespace tribus::test::gpio_library_test {
namespace {

using Line = std::unique_ptr<GpioHeldLine>;

Line hold(const GpioRequest& request) {
    auto line = request_gpio_line("/dev/gpiochip0", request);
    EXPECT_TRUE(line) << line.error();
    return line ? std::move(*line) : nullptr;
}

TEST(GpioLines, AreDescribedInTheirOrder) {
    const GpioChipStandIn chip("gpiochip0",
                               {{.name = "LAMP"}, {.consumer = "lab-hog"}, {.used = true}});
    const auto lines = read_gpio_lines("/dev/gpiochip0");
    ASSERT_TRUE(lines) << lines.error();
    ASSERT_EQ(lines->size(), 3U);
    EXPECT_EQ((*lines)[0].name, "LAMP");
    EXPECT_FALSE((*lines)[0].used);
    EXPECT_EQ((*lines)[0].consumer, "");
    EXPECT_EQ((*lines)[1].name, "");
    EXPECT_TRUE((*lines)[1].used);
    EXPECT_EQ((*lines)[1].consumer, "lab-hog");
    EXPECT_TRUE((*lines)[2].used);
    EXPECT_EQ((*lines)[2].consumer, "");
    EXPECT_EQ(chip.open_count(), 0) << "it is closed again";
}

TEST(GpioLines, AreNotKnownOfAChipThatCannotBeOpened) {
    GpioChipStandIn chip("gpiochip0", {{}});
    chip.refuse(EACCES);
    const auto lines = read_gpio_lines("/dev/gpiochip0");
    ASSERT_FALSE(lines);
    EXPECT_EQ(lines.error(), EACCES);
}

TEST(GpioLines, AreNotKnownWhereTheKernelDoesNotDescribeOne) {
    const GpioChipStandIn chip("gpiochip0", {{}, {.undescribed = ENOMEM}, {}});
    const auto lines = read_gpio_lines("/dev/gpiochip0");
    ASSERT_FALSE(lines);
    EXPECT_EQ(lines.error(), ENOMEM);
}

TEST(GpioRequest, ThatFailsTellsTheErrorOfTheKernel) {
    GpioChipStandIn chip("gpiochip0", {{.undescribed = ENOMEM}, {.refusal = EIO}, {.used = true}});
    const auto error_of = [](unsigned offset) {
        const auto line = request_gpio_line("/dev/gpiochip0", {.offset = offset});
        return line ? 0 : line.error();
    };
    EXPECT_EQ(error_of(0), ENOMEM);
    EXPECT_EQ(error_of(1), EIO);
    EXPECT_EQ(error_of(2), EBUSY);
    EXPECT_EQ(error_of(3), EINVAL) << "there is no such line";
    chip.refuse(EPERM);
    EXPECT_EQ(error_of(2), EPERM);
    EXPECT_EQ(chip.open_count(), 0);
}

struct Asked {
    GpioRequest request;
    const char* requested;
};

class GpioRequestOfALine : public testing::TestWithParam<Asked> {};

TEST_P(GpioRequestOfALine, IsThatAndNoMore) {
    const GpioChipStandIn chip("gpiochip0", {{}, {}, {}});
    const Line line = hold(GetParam().request);
    EXPECT_EQ(chip.requested(GetParam().request.offset), GetParam().requested);
}

INSTANTIATE_TEST_SUITE_P(
    Each, GpioRequestOfALine,
    testing::Values(Asked{{.use = GpioUse::output}, "tribus: output"},
                    Asked{{.offset = 2, .use = GpioUse::output}, "tribus: output"},
                    Asked{{.use = GpioUse::output, .active_low = true},
                          "tribus: output, active-low"},
                    Asked{{.use = GpioUse::output, .bias = GpioBias::pull_up}, "tribus: output"},
                    Asked{{.offset = 1}, "tribus: both edges"},
                    Asked{{.active_low = true}, "tribus: both edges, active-low"},
                    Asked{{.bias = GpioBias::pull_up}, "tribus: both edges, pull-up"},
                    Asked{{.bias = GpioBias::pull_down}, "tribus: both edges, pull-down"},
                    Asked{{.bias = GpioBias::none}, "tribus: both edges, no resistor"},
                    Asked{{.active_low = true, .bias = GpioBias::pull_up},
                          "tribus: both edges, active-low, pull-up"},
                    Asked{{.edges = GpioEdges::rising}, "tribus: rising edges"},
                    Asked{{.edges = GpioEdges::falling}, "tribus: falling edges"}));

TEST(GpioHeldLine, IsFreeAgainAtItsEnd) {
    const GpioChipStandIn chip("gpiochip0", {{}});
    Line line = hold({});
    EXPECT_EQ(chip.open_count(), 1);
    line.reset();
    EXPECT_EQ(chip.requested(0), "");
    EXPECT_EQ(chip.open_count(), 0);
}

struct Level {
    bool active_low;
    bool active;
    bool high;
};

class GpioLevel : public testing::TestWithParam<Level> {};

TEST_P(GpioLevel, ThatIsSetIsOnTheWire) {
    const auto [active_low, active, high] = GetParam();
    const GpioChipStandIn chip("gpiochip0", {{.high = !high}});
    const Line line =
        hold({.use = GpioUse::output, .active_low = active_low, .active_at_start = active});
    EXPECT_EQ(chip.is_high(0), high) << "from the start";
    EXPECT_TRUE(line->set(!active));
    EXPECT_EQ(chip.is_high(0), !high);
    EXPECT_TRUE(line->set(active));
    EXPECT_EQ(chip.is_high(0), high);
}

TEST_P(GpioLevel, OnTheWireIsRead) {
    const auto [active_low, active, high] = GetParam();
    const GpioChipStandIn chip("gpiochip0", {{.high = high}});
    const Line line = hold({.active_low = active_low});
    EXPECT_EQ(line->get(), std::optional(active));
}

INSTANTIATE_TEST_SUITE_P(Each, GpioLevel,
                         testing::Values(Level{false, true, true}, Level{false, false, false},
                                         Level{true, true, false}, Level{true, false, true}));

TEST(GpioHeldLine, ThatDoesNotAnswerHasNoLevelAndTakesNone) {
    GpioChipStandIn chip("gpiochip0", {{.high = true}});
    const Line line = hold({.use = GpioUse::output});
    chip.silence(0);
    EXPECT_FALSE(line->set(true));
    EXPECT_EQ(line->get(), std::nullopt);
}

/// Edges of one input, which is read as the product does.
class GpioEdgesRead : public testing::Test {
  protected:
    explicit GpioEdgesRead(const GpioRequest& request = {}) {
        line_ = hold(request);
        if (line_) {
            ::fcntl(line_->descriptor(), F_SETFL, O_NONBLOCK);
        }
        edges_.fill({.nanoseconds = 7, .after_loss = true});
    }
    /// As "1000 2000 lost 3000"; "gone".
    std::string read() {
        const auto count = line_->read_edges(edges_);
        if (!count) {
            return "gone";
        }
        std::string text;
        for (std::size_t edge = 0; edge < *count; ++edge) {
            text += (text.empty() ? "" : " ") +
                    std::string(edges_[edge].after_loss ? "lost " : "") +
                    std::to_string(edges_[edge].nanoseconds);
        }
        return text;
    }
    /// Moves the line that often. Each edge has its number as its time.
    void move(int times) {
        for (int edge = 0; edge < times; ++edge) {
            ++moved_;
            chip_.drive(0, moved_ % 2 != 0, moved_);
        }
    }

    GpioChipStandIn chip_{"gpiochip0", {{}}};
    Line line_;
    /// One more than a read takes.
    std::array<GpioEdge, kEdgesPerRead + 1> edges_{};
    std::uint64_t moved_ = 0;
};

TEST_F(GpioEdgesRead, ComeOnceEachWithTheirTimes) {
    EXPECT_EQ(read(), "");
    chip_.drive(0, true, 1000);
    chip_.drive(0, false, 5'000'000'000);
    EXPECT_EQ(read(), "1000 5000000000");
    EXPECT_EQ(read(), "");
    chip_.drive(0, true, 5'000'000'001);
    EXPECT_EQ(read(), "5000000001");
}

TEST_F(GpioEdgesRead, LeaveTheRestOfTheirRoomAlone) {
    move(2);
    EXPECT_EQ(read(), "1 2");
    EXPECT_EQ(edges_[2].nanoseconds, 7U);
    move(16);
    read();
    EXPECT_EQ(edges_[16].nanoseconds, 7U);
}

TEST_F(GpioEdgesRead, AreMarkedBehindAQueueThatWasFull) {
    move(20);
    EXPECT_EQ(read(), "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16");
    move(2);
    EXPECT_EQ(read(), "lost 21 22");
    move(1);
    EXPECT_EQ(read(), "23");
}

TEST_F(GpioEdgesRead, AreNotMarkedBehindAQueueThatWasNearlyFull) {
    move(15);
    EXPECT_EQ(read(), "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15");
    move(1);
    EXPECT_EQ(read(), "16");
}

TEST_F(GpioEdgesRead, AreGoneWithTheChip) {
    move(1);
    chip_.unplug();
    EXPECT_EQ(read(), "gone");
    EXPECT_EQ(line_->get(), std::nullopt);
    EXPECT_FALSE(line_->set(true));
}

TEST_F(GpioEdgesRead, AreNoneWhereAReadGivesNothing) {
    chip_.end_events(0);
    errno = 0;
    EXPECT_EQ(read(), "");
}

void note_nothing(int /*signal*/) {}

/// Signals interrupt a read that waits.
TEST_F(GpioEdgesRead, AreNoneWhereASignalEndsTheRead) {
    ::fcntl(line_->descriptor(), F_SETFL, 0);
    struct sigaction action {};
    action.sa_handler = note_nothing;
    struct sigaction before {};
    ::sigaction(SIGALRM, &action, &before);
    const itimerval each{.it_interval = {.tv_sec = 0, .tv_usec = 2000},
                         .it_value = {.tv_sec = 0, .tv_usec = 2000}};
    ::setitimer(ITIMER_REAL, &each, nullptr);
    const std::string text = read();
    constexpr itimerval kNever{};
    ::setitimer(ITIMER_REAL, &kNever, nullptr);
    ::sigaction(SIGALRM, &before, nullptr);
    EXPECT_EQ(text, "");
}

class RisingGpioEdgesRead : public GpioEdgesRead {
  protected:
    RisingGpioEdgesRead() : GpioEdgesRead({.edges = GpioEdges::rising}) {}
};

TEST_F(RisingGpioEdgesRead, AreThoseThatWereAskedFor) {
    move(4);
    EXPECT_EQ(read(), "1 3");
}

class FallingGpioEdgesRead : public GpioEdgesRead {
  protected:
    FallingGpioEdgesRead() : GpioEdgesRead({.edges = GpioEdges::falling}) {}
};

TEST_F(FallingGpioEdgesRead, AreThoseThatWereAskedFor) {
    move(4);
    EXPECT_EQ(read(), "2 4");
}

}  // namespace
}  // namespace tribus::test::gpio_library_test
