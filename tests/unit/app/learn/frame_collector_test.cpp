#include "app/learn/frame_collector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "tests/unit/config/main_job.h"

namespace tribus::test::frame_collector_test {
namespace {

/// i.Bus, 14 channels at 1500 us.
TEST(FrameCollector, KeepsAllFramesThatItMayAndSaysThatMoreCame) {
    const Bytes frame = from_hex(
        "20 40 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 dc 05 "
        "51 f3");
    const std::vector<bool> undamaged(frame.size());
    FrameCollector collector(loaded(main_job_with(3, "device = \"/dev/ttyA\"")).inputs[0]);
    Instant now{};
    const auto receive = [&] {
        collector.receive(frame, undamaged, now += std::chrono::milliseconds(7));
    };
    while (collector.frames().size() < FrameCollector::kMostFrames && !collector.overflowed()) {
        receive();
    }
    EXPECT_FALSE(collector.overflowed());
    receive();
    EXPECT_TRUE(collector.overflowed());
    EXPECT_EQ(collector.frames().size(), FrameCollector::kMostFrames);
}

}  // namespace
}  // namespace tribus::test::frame_collector_test
