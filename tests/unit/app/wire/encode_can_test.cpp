#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "app/wire/encode.h"
#include "tests/support/outcome.h"
#include "tests/support/tiny_can.h"

namespace tribus::encode_can_test {
namespace {

using test::kTinyCan;
using test::Outcome;
using test::outcome_of;
using test::use_of;

Outcome encoded(const std::string& lines, const std::string& interface = "can0") {
    std::istringstream input(lines);
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        return encode_lines(input, "frames.json", use_of(kTinyCan), EncodeFormat::candump, results,
                            messages, interface);
    });
}

// 1500 is 0x05DC, 1000 is 0x03E8.
TEST(EncodeCan, KeepsTimesAndSpacesFramesWithoutByTheDefaultPeriod) {
    const Outcome outcome = encoded(
        "{\"t_us\":1146,\"channels\":[1500]}\n{\"channels\":[1000]}\n"
        "{\"t_us\":2000000,\"channels\":[1500]}\n");
    EXPECT_EQ(outcome.status, kExitFine);
    EXPECT_EQ(outcome.results,
              "(0000000000.001146) can0 123#05DC\n"
              "(0000000000.021146) can0 123#03E8\n"
              "(0000000002.000000) can0 123#05DC\n");
}

TEST(EncodeCan, LogNamesTheInterfaceThatWasAskedFor) {
    EXPECT_EQ(encoded("{\"channels\":[1500]}\n", "vcan7").results,
              "(0000000000.000000) vcan7 123#05DC\n");
}

TEST(EncodeCan, TimeBeforeZeroIsReportedAndLeftOut) {
    const Outcome outcome = encoded("{\"t_us\":-5,\"channels\":[1500]}\n{\"channels\":[1000]}\n");
    EXPECT_EQ(outcome.status, kExitFailed);
    EXPECT_EQ(outcome.messages,
              "frames.json:1:1: t_us is -5; a candump log has no times before 0\n");
    EXPECT_EQ(outcome.results, "(0000000000.000000) can0 123#03E8\n");
}

TEST(EncodeCan, TimeThatGoesBackIsReportedAndLeftOut) {
    const Outcome outcome =
        encoded("{\"t_us\":5,\"channels\":[1500]}\n{\"t_us\":4,\"channels\":[1500]}\n");
    EXPECT_EQ(outcome.messages,
              "frames.json:2:1: t_us is 4, less than the 5 of the frame before; times must not go "
              "back\n");
    EXPECT_EQ(outcome.results, "(0000000000.000005) can0 123#05DC\n");
}

}  // namespace
}  // namespace tribus::encode_can_test
