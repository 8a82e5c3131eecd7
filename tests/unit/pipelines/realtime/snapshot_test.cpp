#include "pipelines/realtime/snapshot.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

namespace tribus::snapshot_test {
namespace {

/// Before the data thread has published anything, an input was never seen and is not good.
TEST(SnapshotTest, UntilTheFirstValueIsPublishedItIsADefaultOne) {
    struct Value {
        int number = 7;
    };
    EXPECT_EQ(Snapshot<Value>().read().number, 7);
}

TEST(SnapshotTest, AReaderNeverSeesHalfOfAValue) {
    struct Value {
        std::array<std::uint64_t, 40> same{};
    };
    Snapshot<Value> snapshot;
    std::atomic<bool> stop = false;
    std::thread writer([&] {
        for (std::uint64_t number = 1; !stop; ++number) {
            Value value;
            value.same.fill(number);
            snapshot.publish(value);
            // Without a pause the reader would be overtaken nearly always.
            for (std::uint64_t pauses = number % 4; pauses > 0; --pauses) {
                std::this_thread::yield();
            }
        }
    });
    for (int i = 0; i < 100'000; ++i) {
        const Value value = snapshot.read();
        for (const std::uint64_t number : value.same) {
            ASSERT_EQ(number, value.same[0]);
        }
    }
    stop = true;
    writer.join();
}

}  // namespace
}  // namespace tribus::snapshot_test
