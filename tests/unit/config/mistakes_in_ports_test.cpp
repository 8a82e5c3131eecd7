#include <string>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::mistakes_in_ports_test {
namespace {

class MistakeInPorts : public ::testing::TestWithParam<Spoilt> {};

TEST_P(MistakeInPorts, IsReportedWithItsPlaceAndWhatIsAllowed) {
    const Spoilt& spoilt = GetParam();
    const auto mistakes = mistakes_in(main_job_with(spoilt.line, spoilt.replacement));
    EXPECT_EQ(mistakes, std::vector<std::string>{written_out(std::string(spoilt.expected))});
}

constexpr Spoilt kMistakes[]{
    {"device_that_would_begin_a_line_in_a_log", 3,
     R"(device = "/dev/ttyA\n12:00:00.000 info started")",
     R"(t.toml:3:10: "device" is "/dev/ttyA\u000a12:00:00.000 info started"; allowed: text in )"
     R"(quotes, not empty, without control characters; a backslash begins an escape )"
     R"(between ", and stands for itself between ')"},
    {"misspelt_key", 3, R"(devcie = "/dev/ttyA")",
     R"(t.toml:3:1: unknown key "devcie" in [input.receiver]; did you mean "device"? )"
     R"(Allowed: "protocol", "device", "timeout", )"
     R"("failsafe_flag", "frame_lost_flag", "frame_lost_run", "frame_lost_ratio", )"
     R"("failsafe_when", "frozen", "plausible", "zero_guard", "map", "baud", "slots")"},
    {"key_of_an_output_in_an_input", 3,
     R"(device = "/dev/ttyA"
period = "14ms")",
     R"(t.toml:4:1: unknown key "period" in [input.receiver]; it belongs in )"
     R"([output.NAME]; allowed: "protocol", "device", "timeout", )"
     R"("failsafe_flag", "frame_lost_flag", "frame_lost_run", "frame_lost_ratio", )"
     R"("failsafe_when", "frozen", "plausible", "zero_guard", "map", "baud", "slots")"},
    {"key_of_another_protocol", 6,
     R"(device = "/dev/ttyB"
slots = "plain")",
     R"(t.toml:7:1: unknown key "slots" in [output.servos]; it belongs in [input.NAME] )"
     R"(with protocol "ibus"; allowed: "protocol", "device", "period", "force", )"
     R"("schedule", "phase", "baud", "scale", "inverted")"},
    {"key_for_the_other_direction", 3,
     R"(device = "/dev/ttyA"
channels = 18)",
     R"(t.toml:4:1: unknown key "channels" in [input.receiver]; it belongs in )"
     R"([output.NAME] with protocol "ibus"; allowed: "protocol", "device", "timeout", )"
     R"("failsafe_flag", "frame_lost_flag", "frame_lost_run", "frame_lost_ratio", )"
     R"("failsafe_when", "frozen", "plausible", "zero_guard", "map", "baud", "slots")"},
    {"missing_protocol", 2, "",
     R"(t.toml:1:1: [input.receiver] lacks "protocol"; required: one of INPUTS)"},
    {"missing_device", 3, "",
     R"(t.toml:1:1: [input.receiver] lacks "device"; required: Serial device, such as )"
     R"("/dev/ttyAMA5" or a stable name under /dev/serial/by-idOTHER_PLACES)"},
    {"empty_device", 3, R"(device = "")",
     R"(t.toml:3:10: "device" is ""; allowed: text in quotes, not empty)"},
    {"device_of_a_wrong_type", 3, "device = 3",
     R"(t.toml:3:10: "device" is 3; allowed: text in quotes, not empty)"},
    {"misspelt_protocol", 2, R"(protocol = "isub")",
     R"(t.toml:2:12: "protocol" is "isub"; allowed: INPUTS)"},
    {"unknown_protocol", 5, R"(protocol = "fm")",
     R"(t.toml:5:12: "protocol" is "fm"; allowed: OUTPUTS)"},
    {"protocol_of_a_wrong_type", 5, "protocol = 1",
     R"(t.toml:5:12: "protocol" is 1; allowed: OUTPUTS)"},
    {"timeout_without_a_unit", 3,
     R"(device = "/dev/ttyA"
timeout = 100)",
     R"(t.toml:4:11: "timeout" is 100; allowed: a duration from "5ms" to "10s", text )"
     R"(with a unit (us, ms, s) such as "100ms")"},
    {"timeout_with_an_unknown_unit", 3,
     R"(device = "/dev/ttyA"
timeout = "100 min")",
     R"(t.toml:4:11: "timeout" is "100 min"; allowed: a duration from "5ms" to "10s", )"
     R"(text with a unit (us, ms, s) such as "100ms")"},
    {"timeout_too_short", 3,
     R"(device = "/dev/ttyA"
timeout = "4999us")",
     R"(t.toml:4:11: "timeout" is "4999us"; allowed: a duration from "5ms" to "10s", )"
     R"(text with a unit (us, ms, s) such as "100ms")"},
    {"timeout_too_long", 3,
     R"(device = "/dev/ttyA"
timeout = "10.001s")",
     R"(t.toml:4:11: "timeout" is "10.001s"; allowed: a duration from "5ms" to "10s", )"
     R"(text with a unit (us, ms, s) such as "100ms")"},
    {"baud_out_of_range", 3,
     R"(device = "/dev/ttyA"
baud = 9599)",
     R"(t.toml:4:8: "baud" is 9599; allowed: a whole number from 9600 to 1000000)"},
    {"baud_that_is_no_choice", 6,
     R"(device = "/dev/ttyB"
baud = 115200)",
     R"(t.toml:7:8: "baud" is 115200; allowed: 100000, 200000)"},
    {"baud_as_text", 6,
     R"(device = "/dev/ttyB"
baud = "100000")",
     R"(t.toml:7:8: "baud" is "100000"; leave the quotes out: baud = 100000)"},
    {"choice_misspelt", 3,
     R"(device = "/dev/ttyA"
slots = "plian")",
     R"(t.toml:4:9: "slots" is "plian"; did you mean "plain"? Allowed: "nibbles", )"
     R"("plain")"},
    {"inverted", 6,
     R"(device = "/dev/ttyB"
inverted = true)",
     R"(t.toml:7:12: "inverted" is true, but Linux has no setting that inverts a serial )"
     R"(port; let an SPI port do it (spi = "/dev/spidev0.0" in place of device), or )"
     R"(invert the wire: with a transistor or a 74HC04, with the inversion bit in the )"
     R"(EEPROM of an FTDI adapter, or with the device-tree flag that some UARTs have; )"
     R"(then leave inverted = false)"},
    {"inverted_at_an_spi_port", 6,
     R"(spi = "/dev/spidev0.0"
inverted = true)",
     R"(t.toml:7:12: "inverted" is true, but an SPI port inverts the signal by itself; )"
     R"(leave it out)"},
    {"spi_port_of_an_input", 3, R"(spi = "/dev/spidev0.0")",
     R"(t.toml:3:1: unknown key "spi" in [input.receiver]; protocol "ibus" has "device" )"
     R"(instead: Serial device, such as "/dev/ttyAMA5" or a stable name under )"
     R"(/dev/serial/by-id; or "address": IP address and port for UDP, one frame a )"
     R"(datagram: an input receives there, an output sends there)"},
    {"spi_port_that_is_no_path", 6, R"(spi = "spidev0.0")",
     R"(t.toml:6:7: "spi" is "spidev0.0"; allowed: an SPI port, such as "/dev/spidev0.0")"},
    {"inverted_of_a_wrong_type", 6,
     R"(device = "/dev/ttyB"
inverted = 1)",
     R"(t.toml:7:12: "inverted" is 1; allowed: true or false)"},
    {"period_too_long", 6,
     R"(device = "/dev/ttyB"
period = "1001ms")",
     R"(t.toml:7:10: "period" is "1001ms"; allowed: a duration from "100us" to "1s", )"
     R"(text with a unit (us, ms, s) such as "14ms")"},
    {"period_below_what_readers_follow", 6,
     R"(device = "/dev/ttyB"
period = "6999us")",
     R"(t.toml:7:10: "period" is "6999us", shorter than readers of "sbus" can follow; )"
     R"(allowed: "7ms" to "1s", or add force = true)"},
    {"period_below_the_wire_time", 6,
     R"(device = "/dev/ttyB"
period = "3119us")",
     R"(t.toml:7:10: "period" is "3119us", shorter than a frame of "sbus" takes on the )"
     R"(wire at 100000 baud; allowed: "7ms" to "1s")"},
    {"period_below_the_wire_time_in_spite_of_force", 6,
     R"(device = "/dev/ttyB"
force = true
period = "3119us")",
     R"(t.toml:8:10: "period" is "3119us", shorter than a frame of "sbus" takes on the )"
     R"(wire at 100000 baud; allowed: "3120us" to "1s")"},
    {"default_period_below_the_wire_time_of_a_slow_line", 5,
     R"(protocol = "ibus"
baud = 9600)",
     R"(t.toml:4:1: "period" is "7ms" by default, shorter than a frame of "ibus" takes )"
     R"(on the wire at 9600 baud; allowed: "34375us" to "1s")"},
    {"schedule_misspelt", 6,
     R"(device = "/dev/ttyB"
schedule = "grit")",
     R"(t.toml:7:12: "schedule" is "grit"; did you mean "grid"? Allowed: "follow", )"
     R"("grid")"},
    {"locked_phase_without_a_grid", 6,
     R"(device = "/dev/ttyB"
phase = "locked")",
     R"(t.toml:7:9: "phase" is "locked", but "schedule" is "follow", which has no grid )"
     R"(to lock; allowed: schedule = "grid", or leave phase out)"},
    {"scale_misspelt", 6,
     R"(device = "/dev/ttyB"
scale = "betafligth")",
     R"(t.toml:7:9: "scale" is "betafligth"; did you mean "betaflight"? Allowed: )"
     R"("betaflight", "ardupilot", "px4", "frsky", "futaba")"},
    {"scale_of_a_wrong_type", 6,
     R"(device = "/dev/ttyB"
scale = 1.5)",
     R"(t.toml:7:9: "scale" is 1.5; allowed: "betaflight", "ardupilot", "px4", "frsky", )"
     R"("futaba", or two points: { raw = [172, 1811], us = [988, 2012] })"},
    {"scale_with_one_point", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [172], us = [988, 2012] })",
     R"(t.toml:7:17: "raw" is not a list of two different whole numbers from 0 to 2047; )"
     R"(example: { raw = [172, 1811], us = [988, 2012] })"},
    {"scale_with_equal_raw_values", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [172, 172], us = [988, 2012] })",
     R"(t.toml:7:17: "raw" is not a list of two different whole numbers from 0 to 2047; )"
     R"(example: { raw = [172, 1811], us = [988, 2012] })"},
    {"scale_beyond_11_bits", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [0, 2048], us = [988, 2012] })",
     R"(t.toml:7:17: "raw" is not a list of two different whole numbers from 0 to 2047; )"
     R"(example: { raw = [172, 1811], us = [988, 2012] })"},
    {"scale_with_equal_microseconds", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [172, 1811], us = [988, 988] })",
     R"(t.toml:7:35: "us" is not a list of two different numbers from -4000 to 4095; example: { )"
     R"(raw = [172, 1811], us = [988, 2012] })"},
    {"scale_without_us", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [172, 1811] })",
     R"(t.toml:7:9: the scale lacks "us"; allowed: { raw = [172, 1811], us = [988, )"
     R"(2012] })"},
    {"scale_with_an_unknown_key", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [172, 1811], us = [988, 2012], s = 1 })",
     R"(t.toml:7:48: unknown key "s" in a scale; did you mean "us"? Allowed: "raw", "us")"},
    {"scale_that_falls", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [1811, 172], us = [988, 2012] })",
     R"(t.toml:7:17: "raw" is [1811, 172], the higher number first, unlike "us"; write raw = )"
     R"([172, 1811]. To reverse a channel, write reverse = true)"},
    {"scale_that_is_too_flat", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [0, 2000], us = [1000, 1499] })",
     R"(t.toml:7:9: "scale" has a slope of 0.2495 us for each raw step; allowed: 0.25 )"
     R"(to 4)"},
    {"scale_that_leaves_the_range_of_a_pulse", 6,
     R"(device = "/dev/ttyB"
scale = { raw = [0, 1000], us = [0, 2001] })",
     R"(t.toml:7:9: "scale" maps raw 0 to 2047 to the range 0 to 4096.05 us; allowed: within )"
     R"(-4000 to 4095 us)"},
    {"address_beside_a_device", 3,
     R"(device = "/dev/ttyA"
address = "127.0.0.1:5501")",
     R"(t.toml:4:1: "address" in [input.receiver], which has "device" already; leave one of them )"
     R"(out)"},
    {"range_with_a_low_end_out_of_range", 3,
     R"(device = "/dev/ttyA"
plausible = [-1, 2000])",
     R"(t.toml:4:13: "plausible" is [-1, 2000]; allowed: two numbers of microseconds from 0 to )"
     R"(4095, the lower one first: [850, 2150])"},
    {"range_with_a_high_end_out_of_range", 3,
     R"(device = "/dev/ttyA"
plausible = [800, 4096])",
     R"(t.toml:4:13: "plausible" is [800, 4096]; allowed: two numbers of microseconds from 0 to )"
     R"(4095, the lower one first: [850, 2150])"},
    {"schedule_of_a_handset", 5,
     R"(protocol = "crsf"
role = "handset"
baud = 400000
schedule = "follow")",
     R"(t.toml:8:12: "schedule" is "follow", but the receiver of the frames says when they should )"
     R"(come; allowed: "grid", or leave schedule out)"},
    {"phase_of_a_handset", 5,
     R"(protocol = "crsf"
role = "handset"
baud = 400000
phase = "locked")",
     R"(t.toml:8:9: "phase" is "locked", but the receiver of the frames says when they should )"
     R"(come; leave phase out)"},
    {"rate_of_a_handset_by_default", 5,
     R"(protocol = "crsf"
role = "handset")",
     R"(t.toml:4:1: "baud" is 420000, the default, but a transmitter module does not look for )"
     R"(its handset at this rate; allowed: 115200, 400000, 921600, 1870000, 2250000, 3750000, )"
     R"(5250000)"},
    {"value_rules_that_are_no_list", 3,
     R"(device = "/dev/ttyA"
failsafe_when = { channel = 3, below = 950 })",
     R"(t.toml:4:17: "failsafe_when" is a table; allowed: a list of rules, such as [{ )"
     R"(channel = 3, below = 950 }])"},
    {"loss_rule_that_is_no_table", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [3])",
     R"(t.toml:4:18: a rule of "failsafe_when" is 3; allowed: a table, such as [{ )"
     R"(channel = 3, below = 950 }])"},
    {"loss_rule_without_a_limit", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ channel = 3 }])",
     R"(t.toml:4:18: a rule of "failsafe_when" has no limit; at least one of "below", )"
     R"("above", "between" is required, such as [{ channel = 3, below = 950 }])"},
    {"loss_rule_without_a_channel", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ below = 950 }])",
     R"(t.toml:4:18: a rule of "failsafe_when" has no "channel"; required, such as )"
     R"([{ channel = 3, below = 950 }])"},
    {"loss_rule_with_a_channel_out_of_range", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ channel = 19, below = 950 }])",
     R"(t.toml:4:30: "channel" is 19; allowed: a whole number from 1 to 18)"},
    {"loss_rule_with_a_misspelt_limit", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ channel = 3, bellow = 950 }])",
     R"(t.toml:4:33: unknown key "bellow" in a rule of "failsafe_when"; did you mean )"
     R"("below"? Allowed: "channel", "below", "above", "between", "all_zero")"},
    {"loss_rule_that_is_always_true", 3,
     R"(device = "/dev/ttyA"
failsafe_when = [{ channel = 3, below = 2000, above = 1000 }])",
     R"(t.toml:4:55: "below" is 2000 and "above" is 1000, so every value would mean loss; )"
     R"(allowed: "below" less than "above")"},
};

INSTANTIATE_TEST_SUITE_P(Mistakes, MistakeInPorts, ::testing::ValuesIn(kMistakes),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

using Lines = std::vector<std::string>;

/// The mistakes behind the line.
Lines mistakes_in_scale(std::string_view scale) {
    Lines lines =
        mistakes_in(main_job_with(6, "device = \"/dev/ttyB\"\nscale = " + std::string(scale)));
    for (std::string& line : lines) {
        line.erase(0, std::string_view("t.toml:7:").size());
    }
    return lines;
}

TEST(RawValuesOfAScale, AreTwoDifferentWholeNumbers) {
    for (const std::string raw : {"5", "[172.5, 1811]", "[172, 1811.5]", "[172, 2048]",
                                  "[-1, 1811]", "[172, 1000, 1811]"}) {
        EXPECT_EQ(mistakes_in_scale("{ raw = " + raw + ", us = [988, 2012] }"),
                  Lines{"17: \"raw\" is not a list of two different whole numbers from 0 to 2047; "
                        "example: { raw = [172, 1811], us = [988, 2012] }"})
            << raw;
    }
}

TEST(MicrosecondsOfAScale, AreTwoDifferentNumbersOfAPulse) {
    for (const std::string us : {"[988, 4096]", "[-4001, 988]"}) {
        EXPECT_EQ(mistakes_in_scale("{ raw = [172, 1811], us = " + us + " }"),
                  Lines{"35: \"us\" is not a list of two different numbers from -4000 to 4095; "
                        "example: { raw = [172, 1811], us = [988, 2012] }"})
            << us;
    }
}

TEST(SlopeOfAScale, HasLimits) {
    EXPECT_EQ(mistakes_in_scale("{ raw = [0, 2000], us = [1000, 1500] }"), Lines{});
    EXPECT_EQ(
        mistakes_in_scale("{ raw = [1000, 1250], us = [1000, 2000] }"),
        Lines{"9: \"scale\" maps raw 0 to 2047 to the range -3000 to 5188 us; allowed: within "
              "-4000 to 4095 us"});
    EXPECT_EQ(mistakes_in_scale("{ raw = [0, 100], us = [1000, 1500] }"),
              Lines{"9: \"scale\" has a slope of 5 us for each raw step; allowed: 0.25 to 4"});
}

TEST(RangeOfAScale, IsThatOfAPulse) {
    EXPECT_EQ(mistakes_in_scale("{ raw = [0, 1000], us = [-4000, -3000] }"), Lines{});
    EXPECT_EQ(mistakes_in_scale("{ raw = [0, 1000], us = [2048, 3048] }"), Lines{});
    EXPECT_EQ(mistakes_in_scale("{ raw = [0, 1000], us = [2049, 3049] }").size(), 1U);
    EXPECT_EQ(mistakes_in_scale("{ raw = [1, 1001], us = [-4000, -3000] }").size(), 1U);
}

TEST(Range, MayBeOneNumber) {
    EXPECT_EQ(
        mistakes_in(main_job_with(
            3, "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, between = [990, 990] }]")),
        Lines{});
}

}  // namespace
}  // namespace tribus::test::mistakes_in_ports_test
