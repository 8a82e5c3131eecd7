#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/gpio_bank.h"
#include "tests/loopback/program.h"
#include "transports/links/gpio/gpio_library.h"
#include "transports/links/gpio/gpio_line.h"

/// Edges of an input with the times at which the kernel saw them.
namespace tribus::test::gpio_edges_test {
namespace {

class GpioEdgesOfALine : public testing::Test {
  protected:
    void hold(GpioEdges edges) {
        auto line = hold_for_edges({bank_.chip(), 2U}, edges, GpioBias::as_is);
        ASSERT_TRUE(line.has_value()) << line.error();
        line_ = std::move(*line);
    }
    void pulse(int times) const {
        for (int pulse = 0; pulse < times; ++pulse) {
            bank_.pull(2, true);
            bank_.pull(2, false);
        }
    }
    /// Reads until `count` edges came.
    std::vector<GpioEdge> read(std::size_t count) {
        std::vector<GpioEdge> all;
        EXPECT_TRUE(eventually([&] {
            std::array<GpioEdge, kEdgesPerRead> edges{};
            const auto taken = line_->read_edges(edges);
            EXPECT_TRUE(taken.has_value());
            all.insert(all.end(), edges.begin(),
                       edges.begin() + static_cast<std::ptrdiff_t>(taken.value_or(0)));
            return all.size() >= count;
        })) << all.size();
        return all;
    }

    GpioBank bank_;
    std::unique_ptr<GpioHeldLine> line_;
};

TEST_F(GpioEdgesOfALine, ComeOnceEachInTheirOrder) {
    for (const GpioEdges edges : {GpioEdges::rising, GpioEdges::falling}) {
        line_.reset();
        hold(edges);
        // The simulated chip makes one interrupt of edges that come before it has run.
        std::vector<GpioEdge> seen;
        for (int pulses = 0; pulses < 5; ++pulses) {
            pulse(1);
            const auto more = read(1);
            seen.insert(seen.end(), more.begin(), more.end());
        }
        ASSERT_EQ(seen.size(), 5U) << "one kind of edge only";
        for (std::size_t edge = 0; edge < seen.size(); ++edge) {
            EXPECT_FALSE(seen[edge].after_loss) << edge;
            EXPECT_GT(seen[edge].nanoseconds, edge == 0 ? 0 : seen[edge - 1].nanoseconds);
        }
    }
}

TEST_F(GpioEdgesOfALine, AreMarkedBehindALoss) {
    hold(GpioEdges::rising);
    pulse(100);
    std::vector<GpioEdge> seen = read(kEdgesPerRead);
    pulse(1);
    for (const GpioEdge& edge : read(1)) {
        seen.push_back(edge);
    }
    EXPECT_LT(seen.size(), 101U);
    EXPECT_TRUE(std::any_of(seen.begin(), seen.end(),
                            [](const GpioEdge& edge) { return edge.after_loss; }));
}

TEST_F(GpioEdgesOfALine, AreGoneWithTheChip) {
    hold(GpioEdges::rising);
    bank_.remove();
    EXPECT_EQ(line_->get(), std::nullopt);
}

}  // namespace
}  // namespace tribus::test::gpio_edges_test
