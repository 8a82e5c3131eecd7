#include "tests/captures/recordings.h"
#include "tests/sim/loss_run.h"

#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/learn/frame_collector.h"
#include "transports/recordings/recording.h"

/// Repeated recordings of real receivers and their twins, with a simulated loss in each of the
/// known ways. The configuration has the lines that `learn` printed for that way.
namespace tribus::test::recorded_loss_test {
namespace {

using namespace std::chrono_literals;

struct RecordedFlight {
    std::string_view file;
    std::string_view protocol;
    Duration period{};
    /// Whether values move all the time, so that `frozen` can tell live values from frozen ones.
    bool moving = false;
};

/// Periods and movement: README of the recordings, docs/protocols/ibus.md, "Period and gaps", and
/// docs/protocols/sbus.md, "Periods".
constexpr RecordedFlight kFlights[]{
    {"ibus_servo18_afhds3.timed.txt", "ibus", 4ms, true},
    {"ibus_servo14_ia6b_2sensors.timed.txt", "ibus", 7701us, false},
    {"ibus_servo14_ia6b_rpmsensor.timed.txt", "ibus", 7701us, false},
    {"sbus2_r7008SB.timed.txt", "sbus", 15ms, false},
};

std::vector<ChannelFrame> recorded_frames(const RecordedFlight& flight, Capture capture) {
    const Recording recording = recording_of(flight.file, capture);
    const Configuration job = configuration_of(job_with(flight.protocol, {}));
    FrameCollector collector(job.inputs[0]);
    for (const Burst& burst : recording.bursts) {
        collector.receive(burst.bytes, burst.damaged, Instant(*burst.start));
    }
    std::vector<ChannelFrame> frames;
    for (const StudiedFrame& studied : collector.frames()) {
        frames.push_back(studied.frame);
    }
    return frames;
}

class RecordedLoss : public testing::TestWithParam<std::tuple<RecordedFlight, Capture>> {};

TEST_P(RecordedLoss, IsRecognisedInEachKnownWayAndNothingBeforeIsTakenForIt) {
    const auto& [recorded, capture] = GetParam();
    const std::vector<ChannelFrame> frames = recorded_frames(recorded, capture);
    ASSERT_GT(frames.size(), 80U);
    const Flight flight = [&](Duration since) {
        return frames[static_cast<std::size_t>(since / recorded.period) % frames.size()];
    };
    int ways = 0;
    for (KnownReceiver receiver : known_receivers()) {
        const bool told = receiver.told_by != ToldBy::nothing &&
                          (receiver.told_by != ToldBy::standing_still || recorded.moving);
        if (receiver.protocol != recorded.protocol || !told) {
            continue;
        }
        SCOPED_TRACE(receiver.name);
        const LossStudyResult learned = study(receiver);
        receiver.period = recorded.period;
        const LossRun run = run_with(learned, receiver, flight);
        EXPECT_TRUE(run.always_in_control_before());
        EXPECT_TRUE(run.in_failsafe_at(study_times().back - 1s));
        EXPECT_FALSE(run.in_failsafe_at(study_end() - 500ms))
            << "failsafe goes on although the transmitter is back";
        ++ways;
    }
    EXPECT_GE(ways, 5);
}

INSTANTIATE_TEST_SUITE_P(Captures, RecordedLoss,
                         testing::Combine(testing::ValuesIn(kFlights),
                                          testing::ValuesIn(captures())),
                         [](const auto& test) {
                             const std::string_view file =
                                 std::get<RecordedFlight>(test.param).file;
                             return std::string(file.substr(0, file.find('.'))) + "_" +
                                    capture_name(std::get<Capture>(test.param));
                         });

}  // namespace
}  // namespace tribus::test::recorded_loss_test
