#include "pipelines/realtime/port_waits.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <utility>

#include <gtest/gtest.h>

namespace tribus::test::port_waits_test {
namespace {

using namespace std::chrono_literals;

/// Both descriptors are always ready.
class ReadyLink final : public Link {
  public:
    int descriptor() const override { return first_.get(); }
    int second_descriptor() const override { return second_.get(); }

  private:
    UniqueFd first_{::eventfd(1, EFD_NONBLOCK | EFD_CLOEXEC)};
    UniqueFd second_{::eventfd(1, EFD_NONBLOCK | EFD_CLOEXEC)};
};

class PortWaitsTest : public testing::Test {
  protected:
    PortWaitsTest() { EXPECT_TRUE(waits_.prepare(2)); }
    std::vector<std::size_t> ready(PortWaits& waits) {
        std::array<std::uint32_t, PortWaits::kMostReady> ports{};
        const std::size_t count = waits.wait(0ms, ports);
        return {ports.begin(), ports.begin() + static_cast<std::ptrdiff_t>(count)};
    }

    using Ports = std::vector<std::size_t>;
    PortWaits waits_;
    ReadyLink link_;
};

TEST_F(PortWaitsTest, NameThePortOfBothDescriptors) {
    ASSERT_TRUE(waits_.watch(link_, 1, true));
    EXPECT_EQ(ready(waits_), (Ports{1, 1}));
}

TEST_F(PortWaitsTest, NameNothingAfterTheEndOfTheWatch) {
    const auto watch = waits_.watch(link_, 1, true);
    ASSERT_TRUE(watch);
    waits_.end(*watch, link_);
    EXPECT_EQ(ready(waits_), Ports{});
}

TEST_F(PortWaitsTest, NameNoPortForAWatchWhosePlaceBelongsToAnother) {
    const auto watch = waits_.watch(link_, 0, true);
    ASSERT_TRUE(watch);
    // The kernel still watches `link_`, as if an end had been forgotten.
    const ReadyLink closed;
    waits_.end(*watch, closed);
    const ReadyLink other;
    ASSERT_TRUE(waits_.watch(other, 1, true));
    EXPECT_EQ(ready(waits_), (Ports{1, 1}));
}

TEST_F(PortWaitsTest, GoOnInTheNextLoopWithAnotherIndex) {
    const auto watch = waits_.watch(link_, 1, true);
    ASSERT_TRUE(watch);
    PortWaits next;
    ASSERT_TRUE(next.prepare(1));
    next.make_room(waits_);
    next.continue_from(waits_);
    next.set_port(*watch, 0);
    EXPECT_EQ(ready(next), (Ports{0, 0}));
}

TEST_F(PortWaitsTest, HaveRoomForTheLinksOfAnyNumberOfSuccessors) {
    auto waits = std::make_unique<PortWaits>();
    ASSERT_TRUE(waits->prepare(3));
    for (int reload = 0; reload < 50; ++reload) {
        const std::array<ReadyLink, 3> links;
        std::vector<PortWaits::Watch> watches;
        for (std::size_t port = 0; port < links.size(); ++port) {
            const auto watch = waits->watch(links[port], port, true);
            ASSERT_TRUE(watch) << "reload " << reload;
            watches.push_back(*watch);
        }
        auto next = std::make_unique<PortWaits>();
        ASSERT_TRUE(next->prepare(3));
        const std::array<ReadyLink, 3> beside;
        for (const ReadyLink& link : beside) {
            ASSERT_TRUE(next->watch(link, 0, true)) << "as a loop does before it takes over";
        }
        next->make_room(*waits);
        next->continue_from(*waits);
        const std::array<ReadyLink, 3> more;
        std::vector<PortWaits::Watch> fresh;
        for (std::size_t port = 0; port < more.size(); ++port) {
            const auto watch = next->watch(more[port], port, true);
            ASSERT_TRUE(watch) << "beside those of the loop before, reload " << reload;
            fresh.push_back(*watch);
        }
        for (std::size_t port = 0; port < links.size(); ++port) {
            next->end(watches[port], links[port]);
            next->end(fresh[port], more[port]);
        }
        waits = std::move(next);
    }
}

}  // namespace
}  // namespace tribus::test::port_waits_test
