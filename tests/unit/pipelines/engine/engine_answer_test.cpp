#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/value_board.h"
#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/reference/plain_exbus_telemetry.h"
#include "transports/codecs/exbus/telemetry.h"

/// An output whose receiver asks for each frame, as receivers of Jeti do (docs/protocols/exbus.md,
/// "Telemetry").
namespace tribus::test::engine_answer_test {
namespace {

using namespace std::chrono_literals;
using reference::plain_exbus_request;

constexpr Instant kStart = Instant(1h);
constexpr Station kReplies{StationKind::replies, 0};

std::vector<OutputSettings> display(const ValueBoard& board) {
    auto encoder = std::make_unique<ExBusTelemetryEncoder>(
        ExBusDevice{"boat", 1, {{.number = 1, .value = "supply", .label = "Supply", .unit = {}}}});
    encoder->use(board);
    std::vector<OutputSettings> outputs(1);
    outputs[0].name = "display";
    outputs[0].encoder = std::move(encoder);
    outputs[0].schedule.kind = ScheduleKind::grid;
    outputs[0].schedule.period = 1s;
    return outputs;
}

class AnswerBench final : public StationObserver {
  public:
    AnswerBench() : engine_({}, display(board_)), loop_(engine_, *this, kStart) {
        board_.set(0, 12.6, kStart);
    }
    void wrote(Station /*station*/, Instant at, const Transmission& /*sent*/) override {
        sent_.push_back(at - kStart);
    }
    void ask(Duration at) { loop_.receive(kReplies, plain_exbus_request(1), kStart + at); }
    void run_until(Duration until) { loop_.run_until(kStart + until); }
    Engine& engine() { return engine_; }
    VirtualLoop& loop() { return loop_; }
    const std::vector<Duration>& sent() const { return sent_; }

  private:
    ValueBoard board_{{{.name = "supply", .unit = "V", .lasts = kForever}}};
    Engine engine_;
    VirtualLoop loop_;
    std::vector<Duration> sent_;
};

TEST(EngineAnswer, IsWrittenAtTheInstantOfTheRequestWhereverThatIs) {
    AnswerBench bench;
    const std::vector<Duration> asked{1ms, 21ms, 33333us, 999999us, 1000ms, 3500ms};
    for (const Duration at : asked) {
        bench.ask(at);
    }
    bench.run_until(10s);
    EXPECT_EQ(bench.sent(), asked);
}

TEST(EngineAnswer, NothingIsWrittenWithoutARequest) {
    AnswerBench bench;
    bench.run_until(10s);
    EXPECT_TRUE(bench.sent().empty());
}

TEST(EngineAnswer, TheEndNeedNotWaitForAnOutputOfValuesAlone) {
    AnswerBench bench;
    bench.run_until(100ms);
    // Its period is 1 s, and it has no last frames to send.
    EXPECT_EQ(bench.engine().end(kStart + 100ms), kStart + 100ms);
    EXPECT_EQ(bench.engine().end(Leaving{.outputs = {0}, .nodes = {}}, kStart + 200ms),
              kStart + 200ms);
}

TEST(EngineAnswer, ARequestThatWasReadAfterAStallIsNotAnswered) {
    AnswerBench bench;
    bench.run_until(100ms);
    // The program did not run for 5 ms. The bytes may have come at its beginning.
    bench.engine().hear(0, plain_exbus_request(1), kStart + 100ms);
    bench.loop().come_back(kStart + 100ms, kStart + 105ms);
    bench.run_until(2s);
    EXPECT_TRUE(bench.sent().empty());
}

}  // namespace
}  // namespace tribus::test::engine_answer_test
