#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/loop.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/seen_within.h"

namespace tribus::test::loop_arrivals_test {
namespace {

using namespace std::chrono_literals;

struct Pipe {
    UniqueFd out;
    UniqueFd in;

    static Pipe open() {
        std::array<int, 2> ends{};
        EXPECT_EQ(::pipe2(ends.data(), O_NONBLOCK), 0);
        return {UniqueFd(ends[0]), UniqueFd(ends[1])};
    }
    void write(const Bytes& bytes) const {
        ASSERT_EQ(::write(in.get(), bytes.data(), bytes.size()),
                  static_cast<ssize_t>(bytes.size()));
    }
};

enum class Reports : std::uint8_t { each_arrival, nothing };

/// Reads from a pipe, which wakes epoll at each write, also at the last one before it is closed. Or
/// it shows epoll another descriptor, of which the kernel reports nothing.
class PipeLink : public ByteLink {
  public:
    /// `known_age`: how old the link says that its bytes are when they are read.
    PipeLink(UniqueFd pipe, Reports reports, Duration known_age = {})
        : pipe_(std::move(pipe)),
          known_age_(known_age),
          other_(reports == Reports::nothing ? ::eventfd(0, EFD_NONBLOCK) : -1) {}

    int descriptor() const override { return other_.valid() ? other_.get() : pipe_.get(); }
    bool wakes_at_each_arrival() const override { return true; }
    ReadStatus read(Reception& reception) override {
        const ssize_t taken = ::read(pipe_.get(), reception.bytes.data(), reception.bytes.size());
        reception.count = taken > 0 ? static_cast<std::size_t>(taken) : 0;
        reception.full = reception.count == reception.bytes.size();
        if (known_age_ > Duration::zero()) {
            reception.at = monotonic_now() - known_age_;
        }
        return taken > 0 ? ReadStatus::received
                         : (taken == 0 ? ReadStatus::lost : ReadStatus::nothing);
    }
    WriteStatus write(std::span<const std::uint8_t>) override { return WriteStatus::written; }
    void discard_unread() override {}

  private:
    UniqueFd pipe_;
    Duration known_age_;
    UniqueFd other_;
};

/// Each frame of the output takes so long that the thread is late for all that follows.
class SlowLink : public PipeLink {
  public:
    SlowLink() : PipeLink(UniqueFd(), Reports::nothing) {}
    WriteStatus write(std::span<const std::uint8_t> /*frame*/) override {
        std::this_thread::sleep_for(20ms);
        return WriteStatus::written;
    }
};

/// An input of i.Bus that reads from a pipe. Its output has no device unless it is given one. The
/// test plays the thread of a GPIO line that forces failsafe.
class LoopArrivals : public testing::Test {
  protected:
    explicit LoopArrivals(Reports reports = Reports::each_arrival,
                          std::unique_ptr<Link> servos = nullptr, Duration known_age = {}) {
        const auto configuration = load_configuration(
            "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/pipe\"\n"
            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/none\"\n"
            "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
            "[gpio.stop]\nline = \"GPIO22\"\nrole = \"force_failsafe\"\n",
            "test.toml");
        EXPECT_TRUE(configuration);
        engine_ = build_engine(*configuration);
        std::vector<PortWiring> wiring;
        std::vector<std::unique_ptr<Link>> links;
        for (PortPlan& plan : plan_ports(*configuration)) {
            const bool reads = plan.config.device == "/dev/pipe";
            links.push_back(
                reads ? std::make_unique<PipeLink>(std::move(pipe_.out), reports, known_age)
                      : std::move(servos));
            plan.wiring.byte_time = {};
            wiring.push_back(std::move(plan.wiring));
        }
        EXPECT_TRUE(lines_.prepare());
        lines_.set_levels(kNoLineActive, monotonic_now());
        loop_ = std::make_unique<Loop>(*engine_, std::move(wiring), std::move(links),
                                       LoopSettings{.lines = &lines_});
        EXPECT_TRUE(loop_->prepare());
    }
    ~LoopArrivals() override {
        loop_->request_end();
        thread_.join();
    }
    void start() {
        thread_ = std::thread([this] {
            wake_in_time();
            loop_->run();
        });
    }
    /// As on a board: a thread that is late proves nothing about what the kernel reports. Where the
    /// machine refuses this, only an idle one shows it.
    static void wake_in_time() {
        const sched_param priority{.sched_priority = 1};
        ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
    }
    /// Sends a frame each 7 ms, and looks at the line if `looks`, until the output is forced into
    /// failsafe or not.
    bool becomes_forced(bool forced, bool looks) {
        return seen_within([&] {
            pipe_.write(from_hex(kIa6bFrame));
            if (looks) {
                lines_.set_levels(kNoLineActive, monotonic_now());
            }
            return loop_->output_status(0).state.forced == forced &&
                   loop_->output_status(0).at != Instant{};
        });
    }

    Pipe pipe_ = Pipe::open();
    LineExchange lines_{1};
    std::unique_ptr<Engine> engine_;
    std::unique_ptr<Loop> loop_;
    std::thread thread_;
};

TEST_F(LoopArrivals, AreReadToTheLastThoughOneWakeDoesNotTakeAll) {
    constexpr std::size_t kFrames = 700;  // a wake takes 64 reads of 256 bytes, 512 frames
    Bytes bytes;
    for (std::size_t i = 0; i < kFrames; ++i) {
        append(bytes, from_hex(kIa6bFrame));
    }
    pipe_.write(bytes);
    start();
    EXPECT_TRUE(seen_within([this] { return loop_->input_status(0).counts.frames == kFrames; }))
        << loop_->input_status(0).counts.frames;
}

TEST_F(LoopArrivals, WithTheHangUpBehindThemLoseTheLink) {
    pipe_.write(from_hex(kIa6bFrame));
    pipe_.in.reset();
    start();
    EXPECT_TRUE(seen_within([this] { return loop_->take_lost(0) != nullptr; }));
    EXPECT_EQ(loop_->input_status(0).counts.frames, 1U);
}

class ArrivalsOfKnownAge : public LoopArrivals {
  protected:
    ArrivalsOfKnownAge() : LoopArrivals(Reports::each_arrival, nullptr, 5ms) {}
};

TEST_F(ArrivalsOfKnownAge, HaveTheTimeThatTheirLinkKnows) {
    const Instant begin = monotonic_now();
    pipe_.write(from_hex(kIa6bFrame));
    start();
    ASSERT_TRUE(seen_within([this] { return loop_->input_status(0).counts.frames == 1; }));
    const Instant received = loop_->input_status(0).latest.received;
    EXPECT_GE(received, begin - 5ms);
    EXPECT_LE(received, monotonic_now() - 5ms);
}

class UnreportedArrivals : public LoopArrivals {
  protected:
    UnreportedArrivals() : LoopArrivals(Reports::nothing) {}
};

TEST_F(UnreportedArrivals, AreReadOnceASecondAndToldAsAFault) {
    start();
    EXPECT_TRUE(seen_within([this] {
        pipe_.write(from_hex(kIa6bFrame));
        return loop_->standing_port().fault == StandingPort::Fault::unheard;
    }));
    EXPECT_EQ(loop_->standing_port().port, 0U);
    EXPECT_GE(loop_->input_status(0).counts.frames, 2U);
    EXPECT_NE(loop_->input_status(0).state.cause, LinkCause::good) << "they may be a second old";
}

class ArrivalsOfALateThread : public LoopArrivals {
  protected:
    ArrivalsOfALateThread() : LoopArrivals(Reports::nothing, std::make_unique<SlowLink>()) {}
};

/// It reads all ports whenever it is late, and a report may have been on its way.
TEST_F(ArrivalsOfALateThread, AreNoFaultOfTheKernel) {
    start();
    EXPECT_FALSE(seen_within(
        [&] {
            pipe_.write(from_hex(kIa6bFrame));
            return loop_->standing_port().fault != StandingPort::Fault::none;
        },
        6s));
    EXPECT_GE(loop_->input_status(0).counts.frames, 2U);
}

TEST_F(LoopArrivals, ThatTheKernelReportsAreNoFault) {
    start();
    EXPECT_FALSE(seen_within(
        [this] {
            pipe_.write(from_hex(kIa6bFrame));
            return loop_->standing_port().fault != StandingPort::Fault::none;
        },
        3s));
}

TEST_F(LoopArrivals, AreNotPassedOnWhileNobodyLooksAtALineThatForcesFailsafe) {
    start();
    EXPECT_TRUE(becomes_forced(false, true));
    EXPECT_TRUE(becomes_forced(true, false)) << "the chip's bus hangs";
    EXPECT_TRUE(becomes_forced(false, true)) << "and goes on";
}

}  // namespace
}  // namespace tribus::test::loop_arrivals_test
