#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/load.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/support/sbus_frames.h"
#include "tests/unit/config/examples.h"

/// The two examples that belong together, sbus-to-can-with-key and can-with-key-to-sbus, as two
/// boards on one bus in virtual time.
namespace tribus::test::example_boards_test {
namespace {

using namespace std::chrono_literals;

using CanFrames = std::vector<CanFrame>;

RandomSeed next_seed() {
    static std::uint32_t made = 0;
    ++made;
    return {static_cast<std::uint8_t>(made), static_cast<std::uint8_t>(made >> 8U), 1};
}

/// A board with one input and one output. It keeps what its output sent since `take`.
class Board : StationObserver {
  public:
    Board(const Configuration& configuration, Instant start)
        : engine_(build_engine(configuration, {}, {.random = next_seed})),
          loop_(*engine_, *this, start) {}

    void run_until(Instant until) { loop_.run_until(until); }
    void receive(const Bytes& bytes, Instant at) {
        loop_.receive({StationKind::input, 0}, bytes, at);
    }
    /// A frame of the bus arrives at the input. Returns what it answers.
    CanFrames read(const CanFrame& frame, Instant at) {
        loop_.receive({StationKind::input, 0}, frame, at);
        const auto answer = engine_->answer(0, at).can_frames();
        return {answer.begin(), answer.end()};
    }
    /// A frame of the bus that answers those of the output.
    void hear(const CanFrame& frame, Instant at) {
        loop_.receive({StationKind::replies, 0}, frame, at);
    }
    CanFrames take_can() { return std::exchange(can_, {}); }
    std::vector<SbusFrame> take_sbus() { return std::exchange(sbus_, {}); }

  private:
    void wrote(Station /*station*/, Instant /*at*/, const Transmission& sent) override {
        can_.insert(can_.end(), sent.can_frames().begin(), sent.can_frames().end());
        if (!sent.bytes().empty()) {
            sbus_.push_back(parse_sbus(sent.bytes().first<kSbusFrameLength>()));
        }
    }

    std::unique_ptr<Engine> engine_;
    CanFrames can_;
    std::vector<SbusFrame> sbus_;
    VirtualLoop loop_;
};

/// The receiver, both boards, and the servos.
class ExampleBoards : public testing::Test {
  protected:
    enum class Receiver : std::uint8_t { sends, is_silent };
    enum class Bus : std::uint8_t { carries, is_cut };

    /// Goes on for so long. Returns what the servos got meanwhile.
    std::vector<SbusFrame> run(Duration how_long, Receiver receiver = Receiver::sends,
                               Bus bus = Bus::carries) {
        std::vector<SbusFrame> got;
        for (const Instant end = now_ + how_long; now_ < end; now_ += 1ms, ++step_) {
            if (receiver == Receiver::sends && step_ % 14 == 0) {
                sender_->receive(from_hex(kHundreds), now_);
            }
            sender_->run_until(now_);
            reader_->run_until(now_);
            for (const CanFrame& frame : sender_->take_can()) {
                carried_.push_back(frame);
                const CanFrames answers =
                    bus == Bus::carries ? reader_->read(frame, now_) : CanFrames{};
                for (const CanFrame& answer : answers) {
                    sender_->hear(answer, now_);
                }
            }
            for (const SbusFrame& frame : reader_->take_sbus()) {
                got.push_back(frame);
            }
        }
        return got;
    }
    /// The configuration of an example, with its own key or that of somebody else.
    static Configuration load(const ExamplesWithKeys& examples, const std::string& name) {
        auto configuration = load_configuration_file(examples / (name + ".toml"));
        EXPECT_TRUE(configuration) << name;
        return std::move(*configuration);
    }

    const ExamplesWithKeys examples_;
    Instant now_ = Instant(1h);
    std::unique_ptr<Board> sender_ =
        std::make_unique<Board>(load(examples_, "sbus-to-can-with-key"), now_);
    std::unique_ptr<Board> reader_ =
        std::make_unique<Board>(load(examples_, "can-with-key-to-sbus"), now_);
    CanFrames carried_;
    int step_ = 0;
};

RawValues hundreds() {
    return raw_values(parse(kHundreds));
}
/// 1500 us in Betaflight's scale, on all channels.
const RawValues kStandstill(16, 992);

TEST_F(ExampleBoards, CarryTheChannelsOfTheReceiverToTheServos) {
    run(2s);
    const auto got = run(500ms);
    ASSERT_GT(got.size(), 25U);
    for (const SbusFrame& frame : got) {
        EXPECT_EQ(raw_values(frame), hundreds());
        EXPECT_FALSE(frame.frame_lost || frame.failsafe);
    }
}

TEST_F(ExampleBoards, StopTheMachineWhenTheReceiverIsLost) {
    run(2s);
    run(1s, Receiver::is_silent);
    const auto got = run(500ms, Receiver::is_silent);
    ASSERT_GT(got.size(), 25U);
    for (const SbusFrame& frame : got) {
        EXPECT_EQ(raw_values(frame), kStandstill);
        EXPECT_TRUE(frame.frame_lost && frame.failsafe);
    }
}

TEST_F(ExampleBoards, StopTheMachineWhenTheBusIsCutWithinTimeoutAndHold) {
    run(2s);
    const auto held = run(350ms, Receiver::sends, Bus::is_cut);
    EXPECT_TRUE(held[held.size() / 2 + 8].frame_lost) << "marked before it is failsafe";
    const auto got = run(500ms, Receiver::sends, Bus::is_cut);
    ASSERT_GT(got.size(), 25U);
    for (const SbusFrame& frame : got) {
        EXPECT_EQ(raw_values(frame), kStandstill);
        EXPECT_TRUE(frame.failsafe);
    }
    run(2s);
    EXPECT_EQ(raw_values(run(100ms).back()), hundreds()) << "it comes back without a hand";
}

TEST_F(ExampleBoards, DoNotTakeOldFramesForNewOnes) {
    run(2s);
    const CanFrames recorded = std::exchange(carried_, {});
    run(1s, Receiver::is_silent, Bus::is_cut);
    for (const CanFrame& frame : recorded) {
        reader_->read(frame, now_);
        now_ += 1ms;
        reader_->run_until(now_);
    }
    const auto got = reader_->take_sbus();
    ASSERT_GT(got.size(), 5U);
    for (const SbusFrame& frame : got) {
        EXPECT_EQ(raw_values(frame), kStandstill);
        EXPECT_TRUE(frame.failsafe);
    }
}

TEST_F(ExampleBoards, MoveNothingWithAnotherKey) {
    const ExamplesWithKeys others(std::string(64, '8'));
    sender_ = std::make_unique<Board>(load(others, "sbus-to-can-with-key"), now_);
    const auto got = run(3s);
    ASSERT_GT(got.size(), 150U);
    for (const SbusFrame& frame : got) {
        EXPECT_EQ(raw_values(frame), kStandstill);
        EXPECT_TRUE(frame.failsafe);
    }
    EXPECT_FALSE(carried_.empty());
}

}  // namespace
}  // namespace tribus::test::example_boards_test
