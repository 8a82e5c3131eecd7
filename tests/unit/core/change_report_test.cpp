#include "core/change_report.h"

#include <gtest/gtest.h>

namespace tribus::change_report_test {
namespace {

using namespace std::chrono_literals;

TEST(ChangeReport, ReportsEachChangeWhileTheLimitAllowsIt) {
    RateLimit limit(6, 30s);
    ChangeReport report(1);
    EXPECT_EQ(report.look(1, limit, Instant(0s)), std::nullopt);
    EXPECT_EQ(report.look(2, limit, Instant(1s)), 0U);
    EXPECT_EQ(report.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(report.look(1, limit, Instant(3s)), 0U);
}

TEST(ChangeReport, AChangeThatHadToWaitIsReportedAsSoonAsItMay) {
    RateLimit limit(1, 30s);
    ChangeReport report(1);
    EXPECT_EQ(report.look(2, limit, Instant(0s)), 0U);
    for (auto second = 1s; second < 30s; ++second) {
        EXPECT_EQ(report.look(3, limit, Instant(second)), std::nullopt);
    }
    EXPECT_EQ(report.reported(), 2);
    EXPECT_EQ(report.look(3, limit, Instant(30s)), 0U) << "nothing but this one had to wait";
    EXPECT_EQ(report.reported(), 3);
}

TEST(ChangeReport, AChangeThatWasUndoneIsOnlyCounted) {
    RateLimit limit(1, 30s);
    ChangeReport report(1);
    EXPECT_EQ(report.look(2, limit, Instant(0s)), 0U);
    EXPECT_EQ(report.look(3, limit, Instant(1s)), std::nullopt);
    EXPECT_EQ(report.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(report.look(2, limit, Instant(31s)), std::nullopt);
    EXPECT_EQ(report.look(1, limit, Instant(32s)), 2U) << "to 3 and back";
}

TEST(ChangeReport, WhatIsKnownAlreadyIsNotReported) {
    RateLimit limit(6, 30s);
    ChangeReport report(1);
    report.take_as_known(2);
    EXPECT_EQ(report.look(2, limit, Instant(0s)), std::nullopt);
    EXPECT_EQ(report.look(1, limit, Instant(1s)), 0U);
}

TEST(ChangeReport, SharesItsLimitAndCountsWhatOthersHadSuppressed) {
    RateLimit limit(1, 30s);
    ChangeReport report(1);
    EXPECT_EQ(limit.pass(Instant(0s)), 0U);
    EXPECT_EQ(limit.pass(Instant(1s)), std::nullopt);
    EXPECT_EQ(report.look(2, limit, Instant(2s)), std::nullopt);
    EXPECT_EQ(report.look(2, limit, Instant(30s)), 1U);
}

}  // namespace
}  // namespace tribus::change_report_test
