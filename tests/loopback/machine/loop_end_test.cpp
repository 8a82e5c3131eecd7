#include <atomic>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"

namespace tribus::test::loop_end_test {
namespace {

using namespace std::chrono_literals;

/// Counts the frames that are written.
class CountingLink final : public ByteLink {
  public:
    explicit CountingLink(std::atomic<int>& frames) : frames_(frames) {}
    int descriptor() const override { return -1; }
    ReadStatus read(Reception& /*reception*/) override { return ReadStatus::nothing; }
    WriteStatus write(std::span<const std::uint8_t> /*frame*/) override {
        ++frames_;
        return WriteStatus::written;
    }
    void discard_unread() override {}

  private:
    std::atomic<int>& frames_;
};

struct End {
    int frames = 0;
    Duration took{};
};

/// What an output of this period writes from the request to end to the end, and how long that is.
End end_with(const std::string& period) {
    const auto configuration = load_configuration(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/none\"\ntimeout = \"2s\"\n"
        "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/servos\"\nforce = true\nperiod = "
        "\"" +
            period + "\"\n[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n",
        "test.toml");
    EXPECT_TRUE(configuration) << configuration.error().front().text;
    const auto engine = build_engine(*configuration);
    std::atomic<int> frames = 0;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    for (PortPlan& plan : plan_ports(*configuration)) {
        const bool writes = plan.config.device == "/dev/servos";
        links.push_back(writes ? std::make_unique<CountingLink>(frames) : nullptr);
        wiring.push_back(std::move(plan.wiring));
    }
    Loop loop(*engine, std::move(wiring), std::move(links));
    EXPECT_TRUE(loop.prepare());
    loop.request_end();
    const Instant begin = monotonic_now();
    loop.run();
    return {frames, monotonic_now() - begin};
}

TEST(LoopEnd, SendsTheFramesOfThreePeriods) {
    // A busy machine may stop the thread for the whole second after which a loop ends.
    End end;
    do {
        end = end_with("20ms");
    } while (end.took > 500ms);
    EXPECT_GE(end.frames, 2);
}

TEST(LoopEnd, IsAfterASecondHoweverLongThePeriodIs) {
    EXPECT_LE(end_with("1s").frames, 1) << "two of them would take two seconds";
}

}  // namespace
}  // namespace tribus::test::loop_end_test
