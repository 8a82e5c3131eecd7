#include "tests/sim/loss_run.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "tests/sim/stored_table.h"

/// Each receiver of tests/support/known_receivers.h loses its transmitter for ten seconds. `learn`
/// studies it, the lines that it prints go into a configuration, and the whole engine runs over the
/// same bytes.
namespace tribus::test::known_receivers_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kHold = 300ms;
constexpr Duration kPeriod = 10ms;

Flight pilot_of(const KnownReceiver& receiver) {
    return [&receiver](Duration since) { return pilot(since, receiver.trembling); };
}

class KnownReceivers : public testing::TestWithParam<KnownReceiver> {};

TEST_P(KnownReceivers, LossIsRecognisedWithTheLinesThatLearnPrintsOrSaidNotToBe) {
    const KnownReceiver& receiver = GetParam();
    const LossStudyResult learned = study(receiver);
    const LossRun run = run_with(learned, receiver, pilot_of(receiver));
    const bool recognisable = receiver.told_by != ToldBy::nothing;
    EXPECT_EQ(learned.recognised, recognisable) << fmt::format("{}", learned.findings);
    EXPECT_TRUE(run.always_in_control_before());
    EXPECT_EQ(run.in_failsafe_at(study_times().back - 1s), recognisable);
    EXPECT_FALSE(run.in_failsafe_at(study_end() - 500ms))
        << "failsafe goes on although the transmitter is back";
}

TEST_P(KnownReceivers, LossEndsInFailsafeNoLaterThanItsKindAllows) {
    const KnownReceiver& receiver = GetParam();
    const LossStudyResult learned = study(receiver);
    const LossRun run = run_with(learned, receiver, pilot_of(receiver));
    switch (receiver.told_by) {
        case ToldBy::flag:
        case ToldBy::value:
            EXPECT_LE(run.to_failsafe(), kHold + kPeriod + receiver.period);
            break;
        case ToldBy::frame_lost:
            EXPECT_LE(run.to_failsafe(), kHold + 100ms + kPeriod + receiver.period);
            break;
        case ToldBy::silence:  // one of these receivers sends for 400 ms more
            EXPECT_LE(run.to_failsafe(), kHold + 500ms + kPeriod);
            break;
        case ToldBy::standing_still:
            EXPECT_LE(run.to_failsafe(), kHold + 2s + kPeriod);
            break;
        case ToldBy::nothing:
            EXPECT_FALSE(learned.advice.empty()) << "no advice about the setting of the receiver";
            EXPECT_TRUE(learned.lines.empty());
            break;
    }
}

std::string test_name(const testing::TestParamInfo<KnownReceiver>& info) {
    std::string name = fmt::format("{:02}_{}", info.index, info.param.name);
    std::ranges::replace_if(
        name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return name;
}
INSTANTIATE_TEST_SUITE_P(Reference, KnownReceivers, testing::ValuesIn(known_receivers()),
                         test_name);

std::string seconds(const std::optional<Duration>& duration) {
    return duration ? fmt::format("{:.2f}", std::chrono::duration<double>(*duration).count()) : "-";
}

TEST(KnownReceiversTable, WhatIsLearnedOfEachAndItsTimesAreAsStored) {
    std::string table =
        "# Each receiver of docs/protocols/ibus.md, \"Loss of signal\", and of\n"
        "# docs/protocols/sbus.md, \"Flags\", loses its transmitter for ten seconds. Time from\n"
        "# the loss to failsafe, and from the return to control, at the SBUS output (timeout\n"
        "# 100 ms, hold 300 ms, recover 500 ms), with the lines that `tribus learn` prints.\n\n"
        "failsafe s  control s  receiver: lines\n";
    for (const KnownReceiver& receiver : known_receivers()) {
        const LossStudyResult learned = study(receiver);
        const LossRun run = run_with(learned, receiver, pilot_of(receiver));
        table += fmt::format(
            "{:>10} {:>10}  {} {}: {}\n", seconds(run.to_failsafe()),
            learned.recognised ? seconds(run.to_control()) : "-", receiver.protocol, receiver.name,
            !learned.recognised     ? "NOT RECOGNISABLE"
            : learned.lines.empty() ? "(the defaults)"
                                    : fmt::format("{}", fmt::join(learned.lines, "; ")));
    }
    expect_stored("known_receivers.txt", table);
}

}  // namespace
}  // namespace tribus::test::known_receivers_test
