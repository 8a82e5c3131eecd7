#include "tests/sim/loss_run.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/stored_table.h"

/// Each loss detector alone: against the loss that it is for, and switched off.
namespace tribus::test::detectors_test {
namespace {

using namespace std::chrono_literals;

struct Row {
    std::string_view detector;
    std::string_view line;  ///< configuration line in [input.receiver]
    std::string_view protocol;
    std::string_view loss;
    std::function<std::optional<ChannelFrame>(Duration, const ChannelFrame&)> lost;
};

ChannelFrame flagged(ChannelFrame frame, bool frame_lost, bool failsafe) {
    frame.frame_lost = frame_lost;
    frame.failsafe = failsafe;
    return frame;
}
std::optional<ChannelFrame> silent(Duration /*since*/, const ChannelFrame& /*last*/) {
    return std::nullopt;
}
std::optional<ChannelFrame> failsafe_flag(Duration /*since*/, const ChannelFrame& last) {
    return flagged(last, false, true);
}
std::optional<ChannelFrame> frame_lost_flag(Duration /*since*/, const ChannelFrame& last) {
    return flagged(last, true, false);
}
std::optional<ChannelFrame> one_good_in_twelve(Duration since, const ChannelFrame& last) {
    return flagged(last, since / 9ms % 12 != 0, false);
}
std::optional<ChannelFrame> frozen(Duration /*since*/, const ChannelFrame& last) {
    return last;
}
/// Sets the throttle to this value.
auto throttle_at(std::int64_t microseconds) {
    return [microseconds](Duration, ChannelFrame last) {
        last.set(2, Pulse::from_microseconds(microseconds));
        return std::optional(last);
    };
}
std::optional<ChannelFrame> zeros(Duration /*since*/, const ChannelFrame& last) {
    ChannelFrame frame = last;
    for (std::size_t channel = 0; channel < 16; ++channel) {
        frame.set(channel, Pulse::from_microseconds(880));
    }
    return frame;
}

std::vector<Row> rows() {
    return {
        {"timeout", "", "ibus", "the wire falls silent", silent},
        {"timeout", "timeout = \"50ms\"", "ibus", "the wire falls silent", silent},
        {"failsafe_flag", "", "sbus", "failsafe flag, values held", failsafe_flag},
        {"failsafe_flag off", "failsafe_flag = false", "sbus", "failsafe flag, values held",
         failsafe_flag},
        {"frame_lost_run", "", "sbus", "every frame marked frame-lost", frame_lost_flag},
        {"frame_lost_run", "frame_lost_run = \"1s\"", "sbus", "every frame marked frame-lost",
         frame_lost_flag},
        {"frame_lost_flag off", "frame_lost_flag = false", "sbus", "every frame marked frame-lost",
         frame_lost_flag},
        {"frame_lost_ratio", "timeout = \"200ms\"", "sbus", "11 of 12 marked frame-lost",
         one_good_in_twelve},
        {"frame_lost_ratio off", "timeout = \"200ms\"\nframe_lost_ratio = 1", "sbus",
         "11 of 12 marked frame-lost", one_good_in_twelve},
        {"failsafe_when below", "failsafe_when = [{ channel = 3, below = 950 }]", "ibus",
         "throttle at 900", throttle_at(900)},
        {"failsafe_when above", "failsafe_when = [{ channel = 3, above = 2050 }]", "ibus",
         "throttle at 2100", throttle_at(2100)},
        {"failsafe_when between", "failsafe_when = [{ channel = 3, between = [2090, 2110] }]",
         "ibus", "throttle at 2100", throttle_at(2100)},
        {"failsafe_when all_zero", "failsafe_when = [{ all_zero = true }]", "sbus",
         "all channels at raw zero", zeros},
        {"failsafe_when none", "", "ibus", "throttle at 900", throttle_at(900)},
        {"frozen", "frozen = \"1s\"", "ibus", "values held", frozen},
        {"frozen off", "", "ibus", "values held", frozen},
        {"plausible", "plausible = [950, 2050]", "ibus", "throttle at 2100", throttle_at(2100)},
        {"plausible off", "", "ibus", "throttle at 2100", throttle_at(2100)},
    };
}

std::string seconds(const std::optional<Duration>& duration) {
    return duration ? fmt::format("{:.2f}", std::chrono::duration<double>(*duration).count())
                    : "never";
}

TEST(Detectors, TimeToFailsafeAndBackOfEachIsAsStored) {
    std::string table =
        "# Each detector alone against the loss that it is for, which lasts ten seconds: seconds\n"
        "# to failsafe, and from the end of the loss to control, at the SBUS output (timeout 100\n"
        "# ms unless said, hold 300 ms, recover 500 ms), and the cause while it lasts.\n\n"
        "failsafe  control  cause         detector\n";
    for (const Row& row : rows()) {
        const KnownReceiver receiver{.name = row.loss,
                                     .protocol = row.protocol,
                                     .period = row.protocol == "sbus" ? 9ms : Duration(7700us),
                                     .lost = row.lost};
        const Configuration job = configuration_of(job_with(row.protocol, {std::string(row.line)}));
        const LossRun run(job,
                          wire_of(receiver, [](Duration since) { return pilot(since, true); }));
        const auto to_failsafe = run.to_failsafe();
        std::string settings(row.line);
        std::ranges::replace(settings, '\n', ' ');
        table += fmt::format("{:>8} {:>8}  {:<12}  {}{}{}: {}\n", seconds(to_failsafe),
                             to_failsafe ? seconds(run.to_control()) : "-",
                             name_of(run.cause_while_lost()), row.detector,
                             settings.empty() ? "" : ", ", settings, row.loss);
    }
    expect_stored("detectors.txt", table);
}

}  // namespace
}  // namespace tribus::test::detectors_test
