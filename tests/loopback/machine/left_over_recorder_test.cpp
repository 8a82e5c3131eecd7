#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/loopback/machine/running_daemon.h"

/// The recorder of a daemon over reloads. It numbers what it is asked for.
namespace tribus::test::left_over_recorder_test {
namespace {

class RecorderOverAReload : public RunningDaemon {
  protected:
    RecorderOverAReload() {
        start(recorded());
        EXPECT_EQ(number_of_next(), 1);
    }
    std::string recorded(const std::string& runtime = "") const {
        return job("servos", runtime + "[recorder]\nmemory = 65536\ndirectory = \"" +
                                 (folder_ / "recordings") + "\"\n");
    }
    /// Asks for a recording and waits until it is written.
    int number_of_next() {
        const int number = nlohmann::json::parse(answer("record"))["number"];
        EXPECT_TRUE(seen_within([&] {
            return answer("record " + std::to_string(number)).find("\"writing\"") ==
                   std::string::npos;
        }));
        return number;
    }
    static constexpr const char* kOther = "[runtime]\nrealtime = \"off\"\npriority = 70\n";
};

TEST_F(RecorderOverAReload, GoesOn) {
    EXPECT_TRUE(reload(recorded("[runtime]\nrealtime = \"off\"\n")).taken);
    EXPECT_EQ(number_of_next(), 2);
}

TEST_F(RecorderOverAReload, GoesOnAfterAStop) {
    EXPECT_TRUE(reload(recorded(kOther)).taken);
    EXPECT_EQ(number_of_next(), 2);
}

TEST_F(RecorderOverAReload, GoesOnIfItIsBackBeforeAnybodyLooked) {
    EXPECT_TRUE(reload(job("servos")).taken);
    EXPECT_TRUE(reload(recorded()).taken);
    EXPECT_EQ(number_of_next(), 2);
}

TEST_F(RecorderOverAReload, IsGoneOnceItHasWrittenAll) {
    EXPECT_TRUE(reload(job("servos")).taken);
    daemon_->look(monotonic_now());
    EXPECT_TRUE(reload(recorded()).taken);
    EXPECT_EQ(number_of_next(), 1);
}

}  // namespace
}  // namespace tribus::test::left_over_recorder_test
