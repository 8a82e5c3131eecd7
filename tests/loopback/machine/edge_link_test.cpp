#include "transports/links/pulse_line/edge_link.h"

#include <poll.h>
#include <sys/timerfd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/edges.h"
#include "tests/support/fewer_descriptors.h"

/// Edges of the kernel as records. The stamps lie in the past, so the line has been quiet since, or
/// far in the future, so it is not quiet yet.
namespace tribus::test::edge_link_test {
namespace {

constexpr std::uint64_t kLongAgo = 1'000'000;
constexpr std::uint64_t kMuchLater = 4'000'000'000'000'000'000;

/// What the kernel gives at each read. It must outlive the link.
struct Kernel {
    std::deque<std::vector<GpioEdge>> reads{};
    bool gone = false;
};

class ScriptedLine final : public GpioHeldLine {
  public:
    explicit ScriptedLine(Kernel& kernel) : kernel_(kernel) {}
    bool set(bool /*active*/) override { return false; }
    std::optional<bool> get() const override {
        return kernel_.gone ? std::nullopt : std::optional(false);
    }
    int descriptor() const override { return -1; }
    std::optional<std::size_t> read_edges(std::span<GpioEdge> edges) override {
        if (kernel_.gone) {
            return std::nullopt;
        }
        if (kernel_.reads.empty()) {
            return 0;
        }
        const std::vector<GpioEdge> waiting = std::move(kernel_.reads.front());
        kernel_.reads.pop_front();
        std::copy(waiting.begin(), waiting.end(), edges.begin());
        return waiting.size();
    }

  private:
    Kernel& kernel_;
};

std::unique_ptr<EdgeLink> link_on(Kernel& kernel) {
    auto link = EdgeLink::on(std::make_unique<ScriptedLine>(kernel));
    EXPECT_TRUE(link.has_value());
    return std::move(*link);
}

/// Waits until the link's timer expires, which is set to the past.
void wait_for_timer(const EdgeLink& link) {
    pollfd timer{.fd = link.second_descriptor(), .events = POLLIN, .revents = 0};
    ASSERT_EQ(::poll(&timer, 1, -1), 1);
}

/// Lets the link's timer expire now.
void expire(const EdgeLink& link) {
    const itimerspec now{.it_interval = {}, .it_value = {.tv_sec = 0, .tv_nsec = 1}};
    ASSERT_EQ(::timerfd_settime(link.second_descriptor(), 0, &now, nullptr), 0);
    wait_for_timer(link);
}

/// When the link's timer expires, in seconds from now; it is set to an edge of `kMuchLater`.
time_t seconds_left(const EdgeLink& link) {
    itimerspec set{};
    EXPECT_EQ(::timerfd_gettime(link.second_descriptor(), &set), 0);
    return set.it_value.tv_sec;
}
constexpr time_t kADay = 86'400;

Bytes read(EdgeLink& link) {
    Reception reception;
    return link.read(reception) == ReadStatus::received
               ? Bytes(reception.view().begin(), reception.view().end())
               : Bytes{};
}

Bytes joined(std::vector<Bytes> parts) {
    Bytes all;
    for (const Bytes& part : parts) {
        append(all, part);
    }
    return all;
}

TEST(EdgeLink, GivesTheDistanceOfEachEdgeToTheOneBefore) {
    Kernel kernel{{{{kMuchLater}, {kMuchLater + 1'500'000}}, {{kMuchLater + 2'500'125}}}};
    const auto link = link_on(kernel);
    EXPECT_EQ(read(*link),
              joined({edge_record(Edge::after_loss, 0xFFFFFF), edge_record(Edge::seen, 1500 * 8)}));
    EXPECT_EQ(read(*link), edge_record(Edge::seen, 1000 * 8 + 1));
    EXPECT_EQ(read(*link), Bytes{}) << "it is not quiet for 2.7 ms yet";
}

// 1000 distances of 1000.04 us are 1000040 us: each alone would be rounded to 1000.
TEST(EdgeLink, RoundsEdgesAndNotTheirDistances) {
    Kernel kernel;
    std::uint64_t sum = 0;
    for (std::uint64_t edge = 0; edge <= 1000; ++edge) {
        kernel.reads.push_back({{kMuchLater + edge * 1'000'040}});
    }
    const auto link = link_on(kernel);
    read(*link);
    for (int edge = 1; edge <= 1000; ++edge) {
        const Bytes record = read(*link);
        ASSERT_EQ(record.size(), 5U);
        sum += record[1] | static_cast<std::uint64_t>(record[2]) << 8U;
    }
    EXPECT_EQ(sum, 8'000'320U);
}

TEST(EdgeLink, SaysOnceThatTheLineIsQuiet) {
    Kernel kernel{{{{kLongAgo}}}};
    const auto link = link_on(kernel);
    read(*link);
    wait_for_timer(*link);
    EXPECT_EQ(read(*link), quiet_record());
    EXPECT_EQ(read(*link), Bytes{});
    kernel.reads.push_back({{kLongAgo + 8'000'000}});
    EXPECT_EQ(read(*link), edge_record(Edge::seen, 8000 * 8));
    wait_for_timer(*link);
    EXPECT_EQ(read(*link), quiet_record());
}

TEST(EdgeLink, AnEdgeThatCameWithTheTimerShowsThatTheLineIsNotQuiet) {
    Kernel kernel{{{{kLongAgo}}, {{kMuchLater}}}};
    const auto link = link_on(kernel);
    read(*link);
    wait_for_timer(*link);
    EXPECT_EQ(read(*link), edge_record(Edge::seen, 0xFFFFFF));
    EXPECT_EQ(read(*link), Bytes{});
    EXPECT_GT(seconds_left(*link), kADay);
}

TEST(EdgeLink, TheTimerOfAnEdgeShowsNothingWhenAnotherOneCameSince) {
    constexpr std::uint64_t kSoonNanoseconds = 30'000'000;
    timespec now{};
    ::clock_gettime(CLOCK_MONOTONIC, &now);
    const std::uint64_t soon = static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000 +
                               static_cast<std::uint64_t>(now.tv_nsec) + kSoonNanoseconds;
    Kernel kernel{{{{soon}}, {{kMuchLater}}}};
    const auto link = link_on(kernel);
    read(*link);
    read(*link);
    pollfd timer{.fd = link->second_descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&timer, 1, 10 * static_cast<int>(kSoonNanoseconds / 1'000'000));
    EXPECT_EQ(read(*link), Bytes{});
    EXPECT_GT(seconds_left(*link), kADay) << "the later edge has a time of its own";
}

// An eighth of a microsecond is 125 ns; halves are rounded up.
TEST(EdgeLink, RoundsToTheNearestEighthOfAMicrosecond) {
    Kernel kernel{{{{kMuchLater},
                    {kMuchLater + 62},
                    {kMuchLater + 63},
                    {kMuchLater + 63 + 124},
                    {kMuchLater + 63 + 125}}}};
    const auto link = link_on(kernel);
    EXPECT_EQ(read(*link), joined({edge_record(Edge::after_loss, 0xFFFFFF),
                                   edge_record(Edge::seen, 0), edge_record(Edge::seen, 1),
                                   edge_record(Edge::seen, 0), edge_record(Edge::seen, 1)}));
}

TEST(EdgeLink, AnEdgeThatIsOlderThanTheOneBeforeHasNoDistance) {
    Kernel kernel{{{{kMuchLater}, {kMuchLater - 1'000'000}, {kMuchLater}}}};
    const auto link = link_on(kernel);
    EXPECT_EQ(read(*link), joined({edge_record(Edge::after_loss, 0xFFFFFF),
                                   edge_record(Edge::seen, 0), edge_record(Edge::seen, 1000 * 8)}));
}

TEST(EdgeLink, HasNothingWhileNoEdgeComes) {
    Kernel kernel;
    const auto link = link_on(kernel);
    wait_for_timer(*link);
    for (int i = 0; i < 2; ++i) {
        Reception reception;
        reception.count = 9;
        reception.full = true;
        reception.goes_on = true;
        reception.damaged.set();
        EXPECT_EQ(link->read(reception), ReadStatus::nothing);
        EXPECT_EQ(reception.count, 0U);
        EXPECT_FALSE(reception.full || reception.goes_on || reception.damaged.any());
    }
}

TEST(EdgeLink, AsksAQuietLineEachSecond) {
    Kernel kernel;
    const auto link = link_on(kernel);
    itimerspec set{};
    ASSERT_EQ(::timerfd_gettime(link->second_descriptor(), &set), 0);
    EXPECT_EQ(set.it_interval.tv_sec, 1);
    EXPECT_EQ(set.it_interval.tv_nsec, 0);
}

TEST(EdgeLink, SaysNoSecondTimeThatTheLineIsQuiet) {
    Kernel kernel{{{{kLongAgo}}}};
    const auto link = link_on(kernel);
    read(*link);
    wait_for_timer(*link);
    EXPECT_EQ(read(*link), quiet_record());
    expire(*link);
    EXPECT_EQ(read(*link), Bytes{});
}

TEST(EdgeLink, DiscardsMoreThanOneFullRead) {
    Kernel kernel;
    for (int i = 0; i < 3; ++i) {
        kernel.reads.emplace_back(kEdgesPerRead, GpioEdge{kMuchLater});
    }
    kernel.reads.push_back({{kMuchLater}});
    kernel.reads.push_back({{kMuchLater}});
    const auto link = link_on(kernel);
    link->discard_unread();
    EXPECT_EQ(kernel.reads.size(), 1U);
    kernel.gone = true;
    link->discard_unread();
}

TEST(EdgeLink, SaysThatThereIsNoDescriptorLeftForItsTimer) {
    const FewerDescriptors fewer(0);
    Kernel kernel;
    const auto link = EdgeLink::on(std::make_unique<ScriptedLine>(kernel));
    ASSERT_FALSE(link.has_value());
    EXPECT_EQ(link.error(), EMFILE);
}

TEST(EdgeLink, SaysThatAPlaceIsNoneOrHasNoLine) {
    for (const std::string place : {"", "no such line of a test"}) {
        const auto link = EdgeLink::open(place, GpioEdges::rising, GpioBias::as_is);
        ASSERT_FALSE(link.has_value());
        EXPECT_TRUE(link.error().starts_with(place + ": ")) << link.error();
    }
}

TEST(EdgeLink, MarksAnEdgeBehindALoss) {
    Kernel kernel{{{{kMuchLater}}, {{kMuchLater + 1'000'000, true}, {kMuchLater + 2'000'000}}}};
    const auto link = link_on(kernel);
    read(*link);
    EXPECT_EQ(read(*link),
              joined({edge_record(Edge::after_loss, 0xFFFFFF), edge_record(Edge::seen, 1000 * 8)}));
    kernel.reads = {{{kMuchLater + 3'000'000}}, {}, {{kMuchLater + 4'000'000}}};
    link->discard_unread();
    EXPECT_EQ(read(*link), Bytes{});
    EXPECT_EQ(read(*link), edge_record(Edge::after_loss, 0xFFFFFF));
}

TEST(EdgeLink, AFullReadMayLeaveMore) {
    Kernel kernel;
    kernel.reads.emplace_back(kEdgesPerRead, GpioEdge{kMuchLater});
    kernel.reads.emplace_back(1, GpioEdge{kMuchLater});
    const auto link = link_on(kernel);
    Reception reception;
    EXPECT_EQ(link->read(reception), ReadStatus::received);
    EXPECT_TRUE(reception.full);
    EXPECT_EQ(link->read(reception), ReadStatus::received);
    EXPECT_FALSE(reception.full);
}

TEST(EdgeLink, IsLostWhenTheChipIsGone) {
    for (const bool quiet : {false, true}) {
        Kernel kernel{{{{kMuchLater}}}};
        const auto link = link_on(kernel);
        if (!quiet) {
            read(*link);
        }
        kernel.gone = true;
        Reception reception;
        EXPECT_EQ(link->read(reception), ReadStatus::lost);
        EXPECT_EQ(reception.count, 0U);
        EXPECT_EQ(link->read(reception), ReadStatus::lost);
        EXPECT_EQ(link->write({}), WriteStatus::unavailable);
    }
}

TEST(EdgeLink, AsksAQuietLineWhetherItsChipIsStillThere) {
    class DeafLine final : public GpioHeldLine {
      public:
        bool set(bool /*active*/) override { return false; }
        std::optional<bool> get() const override { return std::nullopt; }
        int descriptor() const override { return -1; }
        std::optional<std::size_t> read_edges(std::span<GpioEdge> /*edges*/) override { return 0; }
    };
    auto link = EdgeLink::on(std::make_unique<DeafLine>());
    ASSERT_TRUE(link.has_value());
    wait_for_timer(**link);
    Reception reception;
    EXPECT_EQ((*link)->read(reception), ReadStatus::lost);
}

}  // namespace
}  // namespace tribus::test::edge_link_test
