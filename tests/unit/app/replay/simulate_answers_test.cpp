#include <cstdint>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/reference/plain_exbus_telemetry.h"
#include "tests/support/shell.h"
#include "tests/support/streams.h"

/// `tribus simulate` with an output whose receiver asks for each frame.
namespace tribus::test::simulate_answers_test {
namespace {

constexpr const char* kConfiguration = R"([values.supply]
constant = 12.6
unit = "V"
[input.receiver]
protocol = "exbus"
device = "/dev/ttyA"
[output.display]
protocol = "exbus-telemetry"
device = "/dev/ttyA"
sensors = { 1 = { value = "supply" } }
[output.servos]
protocol = "sbus"
device = "/dev/ttyB"
[pipeline.main]
from = "receiver"
to = "servos"
)";

std::string hex_of(const Bytes& bytes) {
    std::string text;
    for (const std::uint8_t byte : bytes) {
        text += fmt::format(" {:02x}", byte);
    }
    return text;
}

TEST(SimulateAnswers, ARequestOfAJetiReceiverIsAnsweredOnItsLine) {
    TemporaryFolder folder;
    folder.write("t.toml", kConfiguration);
    std::string requests;
    for (int i = 0; i < 20; ++i) {
        requests +=
            fmt::format("{}{}\n", 100'000 * i,
                        hex_of(reference::plain_exbus_request(static_cast<std::uint8_t>(i))));
    }
    folder.write("requests.txt", requests);
    const Ended ended = run_in_shell("cd '" + folder / "" +
                                     "'; \"$TRIBUS\" simulate t.toml --in receiver=requests.txt "
                                     "--out display=answers.txt --format hex; cat answers.txt");
    EXPECT_EQ(ended.status, 0) << ended.output;
    EXPECT_NE(ended.output.find("output display: 20 frames"), std::string::npos) << ended.output;
    std::size_t answers = 0;
    for (std::size_t at = ended.output.find("\n3b 01"); at != std::string::npos;
         at = ended.output.find("\n3b 01", at + 1)) {
        ++answers;
    }
    EXPECT_EQ(answers, 20U) << ended.output;
}

}  // namespace
}  // namespace tribus::test::simulate_answers_test
