#include "app/web/pairing/pairing_pauses.h"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace tribus::web::pairing_pauses_test {
namespace {

using namespace std::chrono_literals;

const Instant kStart{1h};

TEST(PairingPauses, GrowWithEachWrongCodeUpTo32Seconds) {
    PairingPauses pauses;
    Instant now = kStart;
    for (const Duration pause : {1s, 2s, 4s, 8s, 16s, 32s, 32s}) {
        EXPECT_EQ(pauses.left("192.0.2.7", now), 0s);
        EXPECT_EQ(pauses.wrong("192.0.2.7", now), pause);
        EXPECT_EQ(pauses.left("192.0.2.7", now), pause);
        EXPECT_EQ(pauses.left("192.0.2.7", now + pause - 1ns), 1ns);
        now += pause;
    }
}

TEST(PairingPauses, KeepNobodyElseWaiting) {
    PairingPauses pauses;
    pauses.wrong("192.0.2.7", kStart);
    EXPECT_EQ(pauses.left("192.0.2.8", kStart), 0s);
}

TEST(PairingPauses, BeginAnewAfterARightCode) {
    PairingPauses pauses;
    pauses.wrong("192.0.2.7", kStart);
    pauses.wrong("192.0.2.7", kStart + 1s);
    pauses.right("192.0.2.7");
    EXPECT_EQ(pauses.left("192.0.2.7", kStart + 1s), 0s);
    EXPECT_EQ(pauses.wrong("192.0.2.7", kStart + 2s), 1s);
}

TEST(PairingPauses, AreForgottenAfterTenMinutes) {
    PairingPauses pauses;
    pauses.wrong("192.0.2.7", kStart);
    EXPECT_EQ(pauses.wrong("192.0.2.7", kStart + 1s + PairingPauses::kForgotten), 2s);
    pauses.right("192.0.2.7");
    pauses.wrong("192.0.2.7", kStart);
    EXPECT_EQ(pauses.wrong("192.0.2.7", kStart + 1s + PairingPauses::kForgotten + 1ns), 1s);
}

TEST(PairingPauses, GiveWayToANewAddressWhereTheyEndSoonest) {
    PairingPauses pauses;
    pauses.wrong("first", kStart);
    pauses.wrong("first", kStart);
    for (std::size_t i = 0; i < PairingPauses::kMostAddresses; ++i) {
        pauses.wrong(std::to_string(i), kStart);
    }
    EXPECT_EQ(pauses.left("0", kStart), 0s) << "one of 1 s went";
    EXPECT_EQ(pauses.left("first", kStart), 2s);
    EXPECT_EQ(pauses.left(std::to_string(PairingPauses::kMostAddresses - 1), kStart), 1s);
}

}  // namespace
}  // namespace tribus::web::pairing_pauses_test
