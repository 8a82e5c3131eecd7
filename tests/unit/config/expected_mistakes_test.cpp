#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

/// Wrong configurations that newcomers write, and all that they are told.
namespace tribus::test::expected_mistakes_test {
namespace {

/// The messages, one a line.
std::string told_about(std::string_view text) {
    std::string told;
    for (const std::string& line : mistakes_in(text)) {
        told += (told.empty() ? "" : "\n") + line;
    }
    return told;
}

class NewcomersMistake : public ::testing::TestWithParam<Spoilt> {};

TEST_P(NewcomersMistake, IsToldWithWhatToWrite) {
    const Spoilt& spoilt = GetParam();
    EXPECT_EQ(told_about(main_job_with(spoilt.line, spoilt.replacement)),
              written_out(std::string(spoilt.expected)));
}

std::string name_of(const ::testing::TestParamInfo<Spoilt>& mistake) {
    return std::string(mistake.param.name);
}

constexpr Spoilt kHeaders[]{
    {"list_of_inputs", 1, "[[input.receiver]]",
     "t.toml:1:1: [[input.receiver]] makes a list of tables; write [input.receiver]"},
    {"list_of_inputs_without_a_name", 1, "[[input]]",
     "t.toml:1:1: [[input]] makes a list; allowed: a table with a name, [input.NAME]"},
    {"list_of_outputs", 4, "[[output.servos]]",
     "t.toml:4:1: [[output.servos]] makes a list of tables; write [output.servos]"},
    {"list_of_pipelines", 7, "[[pipeline.main]]",
     "t.toml:7:1: [[pipeline.main]] makes a list of tables; write [pipeline.main]"},
    {"list_of_a_table_that_exists_once", 10, "[[runtime]]\npriority = 60",
     "t.toml:10:1: [[runtime]] makes a list of tables; write [runtime]"},
    {"list_of_maps", 10, "[[pipeline.main.channels]]\n1 = 2",
     "t.toml:10:1: [[pipeline.main.channels]] makes a list of tables; write "
     "[pipeline.main.channels]"},
    {"list_of_failsafes_of_an_output", 10,
     "[[pipeline.main.failsafe.output.servos]]\naction = \"hold\"",
     "t.toml:10:1: [[pipeline.main.failsafe.output.servos]] makes a list of tables; write "
     "[pipeline.main.failsafe.output.servos]"},
    {"two_of_the_same_name", 4,
     "[[output.servos]]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyC\"\n[[output.servos]]",
     "t.toml:4:1: [[output.servos]] makes a list of tables; write [output.servos]\n"
     "t.toml:7:1: this table was already given further up; give each once"},
    {"a_mistake_in_a_list_of_inputs", 1, "[[input.receiver]]\ntimeout = 5",
     "t.toml:1:1: [[input.receiver]] makes a list of tables; write [input.receiver]\n"
     "t.toml:2:11: \"timeout\" is 5; allowed: a duration from \"5ms\" to \"10s\", text with a unit "
     "(us, ms, s) such as \"100ms\""},
};
INSTANTIATE_TEST_SUITE_P(Headers, NewcomersMistake, ::testing::ValuesIn(kHeaders), name_of);

constexpr Spoilt kCharacters[]{
    {"typographic_quotes", 2, "protocol = \u201cibus\u201d",
     "t.toml:2:12: \u201c (U+201C) is a typographic quote; allowed: \" or '"},
    {"typographic_quotes_of_other_languages", 3,
     "device = \u201e/dev/ttyA\u201c\nslots = \u00abnibbles\u00bb",
     "t.toml:3:10: \u201e (U+201E) is a typographic quote (also in line 4); allowed: \" or '"},
    {"single_typographic_quotes", 2, "protocol = \u2018ibus\u2019",
     "t.toml:2:12: \u2018 (U+2018) is a typographic quote; allowed: \" or '"},
    {"accents_for_quotes", 2, "protocol = `ibus\u00b4",
     "t.toml:2:12: ` (U+0060) is a typographic quote; allowed: \" or '"},
    {"a_typographic_quote_at_the_end_only", 2, "protocol = \"ibus\u201d",
     "t.toml:2:17: \u201d (U+201D) is a typographic quote; allowed: \" or '"},
    {"a_backslash_between_typographic_quotes", 3, "device = \u201cC:\\Users\u201d",
     "t.toml:3:10: \u201c (U+201C) is a typographic quote; allowed: \" or '"},
    {"a_wrong_word_between_typographic_quotes", 2, "protocol = \u201cibuz\u201d",
     "t.toml:2:12: \u201c (U+201C) is a typographic quote; allowed: \" or '\n"
     "t.toml:2:12: \"protocol\" is \"ibuz\"; did you mean \"ibus\"? Allowed: INPUTS"},
    {"no_break_spaces", 2, "protocol\u00a0=\u202f\"ibus\"",
     "t.toml:2:9: U+00A0 looks like a space, but is none; allowed: a space"},
    {"a_character_without_width", 2, "\u200bprotocol = \"ibus\"",
     "t.toml:2:1: U+200B is a character without a width; allowed: nothing; delete it"},
    {"a_byte_order_mark_in_the_middle", 4, "\ufeff[output.servos]",
     "t.toml:4:1: U+FEFF is a character without a width; allowed: nothing; delete it"},
    {"a_dash_for_a_minus", 10, "[pipeline.main.channels]\n1 = { from = 2, trim = \u201312 }",
     "t.toml:11:24: \u2013 (U+2013) is a dash; allowed: the minus of the keyboard, -"},
    {"a_line_separator", 2, "protocol = \"ibus\"\u2028timeout = \"90ms\"",
     "t.toml:2:18: U+2028 does not end a line in TOML; allowed: LF, or CR LF"},
};
INSTANTIATE_TEST_SUITE_P(Characters, NewcomersMistake, ::testing::ValuesIn(kCharacters), name_of);

constexpr Spoilt kSyntax[]{
    {"a_leading_zero", 3, "device = \"/dev/ttyA\"\nbaud = 0115200",
     "t.toml:4:8: 0115200 is not a valid value: a number does not begin with 0; write 115200"},
    {"leading_zeros_in_a_list", 3, "device = \"/dev/ttyA\"\nplausible = [0800, 02200]",
     "t.toml:4:14: 0800 is not a valid value: a number does not begin with 0; write 800"},
    {"a_leading_zero_in_a_list_of_several_lines", 3,
     "device = \"/dev/ttyA\"\nplausible = [\n  0800,\n  2200,\n]",
     "t.toml:5:3: 0800 is not a valid value: a number does not begin with 0; write 800"},
    {"a_leading_zero_in_an_inline_table", 10,
     "[pipeline.main.channels]\n1 = { from = 2, trim = -05 }",
     "t.toml:11:24: -05 is not a valid value: a number does not begin with 0; write -5"},
    {"no_digit_before_the_point", 10, "[pipeline.main.channels]\n1 = { from = 2, expo = .3 }",
     "t.toml:11:24: .3 is not a valid value: a decimal point has digits on both sides; write 0.3"},
    {"no_digit_behind_the_point", 10, "[pipeline.main.channels]\n1 = { from = 2, expo = 1. }",
     "t.toml:11:24: 1. is not a valid value: a decimal point has digits on both sides; write 1.0"},
    {"a_decimal_comma", 3, "device = \"/dev/ttyA\"\nframe_lost_ratio = 0,5",
     "t.toml:4:20: 0,5 is not a valid value: a number has a decimal point; write 0.5"},
    {"a_path_of_windows", 3, R"(device = "C:\Users")",
     R"(t.toml:3:10: "C:\Users" has a backslash, which begins an escape between "; write )"
     R"('C:\Users' or "C:\\Users")"},
    {"a_path_of_windows_with_an_apostrophe", 3, R"(device = "C:\It's")",
     R"(t.toml:3:10: "C:\It's" has a backslash, which begins an escape between "; write )"
     R"("C:\\It's")"},
    {"a_path_of_windows_that_ends_with_a_backslash", 3, R"(device = "C:\Port\")",
     R"(t.toml:3:10: "C:\Port\" has a backslash, which begins an escape between "; write )"
     R"('C:\Port\' or "C:\\Port\\")"},
    {"a_path_of_windows_in_a_line_of_windows", 3, "device = \"C:\\Port\\\"\r",
     R"(t.toml:3:10: "C:\Port\" has a backslash, which begins an escape between "; write )"
     R"('C:\Port\' or "C:\\Port\\")"},
    {"a_path_of_windows_whose_backslash_is_an_escape", 3, R"(device = "C:\new")",
     R"(t.toml:3:10: "device" is "C:\u000aew"; allowed: text in quotes, not empty, without )"
     R"(control characters; a backslash begins an escape between ", and stands for itself )"
     R"(between ')"},
    {"an_inline_table_of_several_lines", 10,
     "[pipeline.main.channels]\n1 = {\n  from = 2,   # aileron\n  reverse = true,\n}\n2 = 1",
     "t.toml:11:5: a table between { and } must end in the line in which it begins; write 1 = { "
     "from = 2, reverse = true }, or a table [pipeline.main.channels.1]"},
    {"an_inline_table_of_two_lines_in_a_list", 3,
     "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3,\n  below = 950 }]",
     "t.toml:4:18: a table between { and } must end in the line in which it begins; write "
     "failsafe_when = [ { channel = 3, below = 950 } ]"},
    {"a_mistake_behind_an_inline_table_of_several_lines", 10,
     "[pipeline.main.channels]\n1 = {\n  from = 2\n}\n2 = 19",
     "t.toml:11:5: a table between { and } must end in the line in which it begins; write 1 = { "
     "from = 2 }, or a table [pipeline.main.channels.1]\n"
     "t.toml:14:5: channel 2 is 19; allowed: the number of an input channel from 1 to 18, or a "
     "table such as { from = 1, reverse = true }"},
    {"a_comma_at_the_end_of_an_inline_table", 10,
     "[pipeline.main.channels]\n1 = { from = 2, reverse = true, }",
     "t.toml:11:31: there is a comma before }, with nothing behind it; leave it out"},
};
INSTANTIATE_TEST_SUITE_P(Syntax, NewcomersMistake, ::testing::ValuesIn(kSyntax), name_of);

constexpr Spoilt kValues[]{
    {"a_range_in_the_wrong_order", 3, "device = \"/dev/ttyA\"\nplausible = [2200, 800]",
     "t.toml:4:13: \"plausible\" is [2200, 800]; the lower number comes first: plausible = [800, "
     "2200]"},
    {"a_range_in_a_rule_in_the_wrong_order", 3,
     "device = \"/dev/ttyA\"\nfailsafe_when = [{ channel = 3, between = [995, 985] }]",
     "t.toml:4:43: \"between\" is [995, 985]; the lower number comes first: between = [985, 995]"},
    {"a_scale_in_the_wrong_order", 6,
     "device = \"/dev/ttyB\"\nscale = { raw = [172, 1811], us = [2012, 988] }",
     "t.toml:7:35: \"us\" is [2012, 988], the higher number first, unlike \"raw\"; write us = "
     "[988, "
     "2012]. To reverse a channel, write reverse = true"},
    {"a_whole_number_in_quotes", 3, "device = \"/dev/ttyA\"\nbaud = \"115200\"",
     "t.toml:4:8: \"baud\" is \"115200\"; leave the quotes out: baud = 115200"},
    {"a_wrong_whole_number_in_quotes", 3, "device = \"/dev/ttyA\"\nbaud = \"300\"",
     "t.toml:4:8: \"baud\" is \"300\"; allowed: a whole number from 9600 to 1000000, without "
     "quotes"},
    {"a_whole_number_with_a_leading_zero_in_quotes", 10, "[runtime]\npriority = \"060\"",
     "t.toml:11:12: \"priority\" is \"060\"; leave the quotes out: priority = 60"},
    {"a_fraction_in_quotes", 10, "[pipeline.main.channels]\n1 = { from = 2, expo = \"0.3\" }",
     "t.toml:11:24: \"expo\" is \"0.3\"; leave the quotes out: expo = 0.3"},
    {"a_pulse_in_quotes", 10, "[pipeline.main.failsafe]\npreset = { 3 = \"988\" }",
     "t.toml:11:16: \"preset.3\" is \"988\"; leave the quotes out: preset.3 = 988"},
    {"pulses_in_quotes", 3, "device = \"/dev/ttyA\"\nplausible = [\"800\", \"2200\"]",
     "t.toml:4:13: \"plausible\" is [\"800\", \"2200\"]; allowed: two numbers of microseconds from "
     "0 to 4095, the lower one first: [850, 2150], without quotes"},
    {"a_channel_in_quotes", 10, "[pipeline.main.channels]\n1 = \"2\"",
     "t.toml:11:5: channel 1 is \"2\"; allowed: the number of an input channel from 1 to 18, "
     "without quotes, or a table such as { from = 1, reverse = true }"},
    {"a_weight_in_quotes", 10, "[pipeline.main.channels]\n1 = { mix = { 2 = \"0.5\" } }",
     "t.toml:11:19: the weight of channel 2 is \"0.5\"; allowed: a number from -10 to 10, without "
     "quotes"},
    {"a_duration_without_a_unit", 3, "device = \"/dev/ttyA\"\ntimeout = \"100\"",
     "t.toml:4:11: \"timeout\" is \"100\"; allowed: a duration from \"5ms\" to \"10s\", text with "
     "a "
     "unit (us, ms, s) such as \"100ms\""},
    {"a_scale_in_quotes", 6,
     "device = \"/dev/ttyB\"\nscale = { raw = [\"172\", \"1811\"], us = [988, 2012] }",
     "t.toml:7:17: \"raw\" is not a list of two different whole numbers from 0 to 2047, without "
     "quotes; example: { raw = [172, 1811], us = [988, 2012] }"},
    {"true_in_quotes", 6, "device = \"/dev/ttyB\"\nforce = \"true\"",
     "t.toml:7:9: \"force\" is \"true\"; leave the quotes out: force = true"},
};
INSTANTIATE_TEST_SUITE_P(Values, NewcomersMistake, ::testing::ValuesIn(kValues), name_of);

constexpr Spoilt kProtocols[]{
    {"an_input_of_joystick", 2, "protocol = \"joystick\"",
     "t.toml:2:12: \"protocol\" is \"joystick\", which is for outputs only; did you mean "
     "\"gamepad\"? Allowed: INPUTS"},
    {"an_input_of_pwm_with_its_keys", 2, "protocol = \"pwm\"\noutputs = { 1 = 0 }",
     "t.toml:2:12: \"protocol\" is \"pwm\", which is for outputs only; did you mean \"ppm\"? "
     "Allowed: INPUTS"},
    {"an_input_of_telemetry", 2, "protocol = \"crsf-telemetry\"",
     "t.toml:2:12: \"protocol\" is \"crsf-telemetry\", which is for outputs and [values.NAME] "
     "only; allowed: INPUTS"},
    {"an_input_of_values", 2, "protocol = \"mavlink-telemetry\"",
     "t.toml:2:12: \"protocol\" is \"mavlink-telemetry\", which is for [values.NAME] only; "
     "allowed: INPUTS"},
    {"an_output_of_dsm", 5, "protocol = \"dsm\"",
     "t.toml:5:12: \"protocol\" is \"dsm\", which is for inputs only; allowed: OUTPUTS"},
    {"an_output_of_fport", 5, "protocol = \"fport\"",
     "t.toml:5:12: \"protocol\" is \"fport\", which is for inputs only; did you mean \"sbus\"? "
     "Allowed: OUTPUTS"},
    {"an_output_of_ibus2", 5, "protocol = \"ibus2\"",
     "t.toml:5:12: \"protocol\" is \"ibus2\", which is for inputs only; did you mean \"ibus\"? "
     "Allowed: OUTPUTS"},
    {"an_output_of_gamepad", 5, "protocol = \"gamepad\"",
     "t.toml:5:12: \"protocol\" is \"gamepad\", which is for inputs only; did you mean "
     "\"joystick\"? Allowed: OUTPUTS"},
    {"an_output_of_the_sensor_bus", 5, "protocol = \"ibus-sensor\"",
     "t.toml:5:12: \"protocol\" is \"ibus-sensor\", which is for [sensor_bus.NAME] only; allowed: "
     "OUTPUTS"},
    {"the_name_of_a_link", 2, "protocol = \"elrs\"",
     "t.toml:2:12: \"protocol\" is \"elrs\"; did you mean \"crsf\"? Allowed: INPUTS"},
    {"the_name_of_a_link_in_large_letters", 5, "protocol = \"ExpressLRS\"",
     "t.toml:5:12: \"protocol\" is \"ExpressLRS\"; did you mean \"crsf\"? Allowed: OUTPUTS"},
    {"a_maker_with_two_protocols", 2, "protocol = \"flysky\"",
     "t.toml:2:12: \"protocol\" is \"flysky\"; did you mean \"ibus\" or \"ibus2\"? Allowed: "
     "INPUTS"},
    {"a_maker_with_three_protocols", 2, "protocol = \"FrSky\"",
     "t.toml:2:12: \"protocol\" is \"FrSky\"; did you mean \"sbus\", \"fport\" or \"fbus\"? "
     "Allowed: INPUTS"},
    {"a_receiver", 2, "protocol = \"FS-iA6B\"",
     "t.toml:2:12: \"protocol\" is \"FS-iA6B\"; did you mean \"ibus\"? Allowed: INPUTS"},
    {"spektrum", 2, "protocol = \"spektrum\"",
     "t.toml:2:12: \"protocol\" is \"spektrum\"; did you mean \"dsm\" or \"srxl\"? Allowed: "
     "INPUTS"},
    {"spektrum_as_an_output", 5, "protocol = \"spektrum\"",
     "t.toml:5:12: \"protocol\" is \"spektrum\"; did you mean \"srxl\"? Allowed: OUTPUTS"},
    {"futaba", 5, "protocol = \"futaba\"",
     "t.toml:5:12: \"protocol\" is \"futaba\"; did you mean \"sbus\"? Allowed: OUTPUTS"},
    {"a_maker_without_an_output", 5, "protocol = \"jeti\"",
     "t.toml:5:12: \"protocol\" is \"jeti\", and \"exbus\" is for inputs only; allowed: OUTPUTS"},
    {"a_name_with_other_punctuation", 2, "protocol = \"S.BUS\"",
     "t.toml:2:12: \"protocol\" is \"S.BUS\"; did you mean \"sbus\"? Allowed: INPUTS"},
};
INSTANTIATE_TEST_SUITE_P(Protocols, NewcomersMistake, ::testing::ValuesIn(kProtocols), name_of);

constexpr Spoilt kKeys[]{
    {"a_number_of_channels_of_an_output", 6, "device = \"/dev/ttyB\"\nchannels = 8",
     "t.toml:7:1: unknown key \"channels\" in [output.servos]; frames of \"sbus\" always have the "
     "same number of channels; leave it out, or say in [pipeline.NAME.channels] what is in them"},
    {"a_number_of_channels_of_an_input", 2, "protocol = \"crsf\"\nchannels = 8",
     "t.toml:3:1: unknown key \"channels\" in [input.receiver]; the sender of \"crsf\" decides how "
     "many channels come; leave it out, or say with \"map\" which ones are used"},
    {"a_number_of_channels_in_quotes", 6, "device = \"/dev/ttyB\"\nchannels = \"8\"",
     "t.toml:7:1: unknown key \"channels\" in [output.servos]; it belongs in [output.NAME] with "
     "protocol \"ibus\"; allowed: \"protocol\", \"device\", \"period\", \"force\", \"schedule\", "
     "\"phase\", \"baud\", \"scale\", \"inverted\""},
    {"a_rate_of_values_at_an_address", 10,
     "[values.pack]\nprotocol = \"crsf-telemetry\"\naddress = \"[::1]:5502\"\nbitrate = 115200",
     "t.toml:13:1: unknown key \"bitrate\" in [values.pack]; allowed: \"constant\", \"unit\", "
     "\"interface\", \"dbc\", \"message\", \"dronecan\", \"node\", \"instance\", \"fd\", "
     "\"protocol\", "
     "\"device\", \"address\", \"public\", \"sender\", \"baud\", \"key\", \"signals\", "
     "\"timeout\""},
    {"the_parity_of_an_address", 6, "address = \"127.0.0.1:5501\"\nparity = \"even\"",
     "t.toml:7:1: unknown key \"parity\" in [output.servos]; allowed: \"protocol\", \"address\", "
     "\"period\", \"force\", \"schedule\", \"phase\", \"public\", \"scale\""},
    {"the_rate_of_a_line_by_another_name", 6, "device = \"/dev/ttyB\"\nbitrate = 200000",
     "t.toml:7:1: unknown key \"bitrate\" in [output.servos]; did you mean \"baud\"? Allowed: "
     "\"protocol\", \"device\", \"period\", \"force\", \"schedule\", \"phase\", \"baud\", "
     "\"scale\", \"inverted\""},
    {"the_rate_of_a_line_that_has_only_one", 2, "protocol = \"dsm\"\nbaudrate = 9600",
     "t.toml:3:1: unknown key \"baudrate\" in [input.receiver]; protocol \"dsm\" always has 115200 "
     "baud; leave it out"},
    {"the_parity_of_a_line", 6, "device = \"/dev/ttyB\"\nparity = \"even\"",
     "t.toml:7:1: unknown key \"parity\" in [output.servos]; protocol \"sbus\" sets it; leave it "
     "out"},
    {"a_table_of_channels_in_an_input", 3, "device = \"/dev/ttyA\"\n[input.receiver.channels]",
     "t.toml:4:17: unknown table \"channels\" in [input.receiver]; what is in the channels of an "
     "output stands in [pipeline.NAME.channels]"},
    {"a_number_of_channels_of_a_protocol_that_says_them", 2, "protocol = \"sbus\"\nchannels = 8",
     "t.toml:3:1: unknown key \"channels\" in [input.receiver]; \"sbus\" says which channels come; "
     "leave it out, or say with \"map\" which ones are used"},
    {"the_rate_of_a_line_of_values", 10,
     "[values.pack]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\nbaudrate = 115200",
     "t.toml:13:1: unknown key \"baudrate\" in [values.pack]; did you mean \"baud\"? Allowed: "
     "\"constant\", \"unit\", \"interface\", \"dbc\", \"message\", \"dronecan\", \"node\", "
     "\"instance\", \"fd\", \"protocol\", \"device\", \"address\", \"public\", \"sender\", "
     "\"baud\", \"key\", \"signals\", \"timeout\""},
    {"an_address_that_is_a_number", 6, "address = \"5600\"",
     "t.toml:6:11: \"address\" is \"5600\": the port is missing; allowed: an IP address in digits "
     "and a port from 1 to 65535, such as \"127.0.0.1:5501\" or \"[::1]:5501\""},
    {"a_grave_accent_as_quote", 5, "protocol = `sbus`",
     "t.toml:5:12: ` (U+0060) is a typographic quote; allowed: \" or '"},
    {"a_port_beyond_the_range", 6, "address = \"127.0.0.1:70000\"",
     "t.toml:6:11: \"address\" is \"127.0.0.1:70000\": port 70000 is out of range; allowed: an IP "
     "address in digits and a port from 1 to 65535, such as \"127.0.0.1:5501\" or "
     "\"[::1]:5501\""},
    {"an_address_without_a_port", 3, "address = \"127.0.0.1\"",
     "t.toml:3:11: \"address\" is \"127.0.0.1\": the port is missing; allowed: an IP address in "
     "digits and a port from 1 to 65535, such as \"127.0.0.1:5501\" or \"[::1]:5501\""},
    {"a_port_of_values_beyond_the_range", 10,
     "[values.pack]\nprotocol = \"crsf-telemetry\"\naddress = \"127.0.0.1:65536\"",
     "t.toml:12:11: \"address\" is \"127.0.0.1:65536\": port 65536 is out of range; allowed: an IP "
     "address in digits and a port from 1 to 65535, such as \"127.0.0.1:5501\" or \"[::1]:5501\""},
};
INSTANTIATE_TEST_SUITE_P(Keys, NewcomersMistake, ::testing::ValuesIn(kKeys), name_of);

/// A mistake in the table of an output "bus".
struct InOutput {
    std::string_view name;
    std::string_view lines;
    std::string_view expected;
};

class NewcomersMistakeInOutput : public ::testing::TestWithParam<InOutput> {};

TEST_P(NewcomersMistakeInOutput, IsToldWithWhatToWrite) {
    const std::string text =
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"bus\"\n" +
        std::string(GetParam().lines);
    EXPECT_EQ(told_about(text), GetParam().expected);
}

constexpr InOutput kInOutput[]{
    {"bit_rate", "[output.bus]\nprotocol = \"can\"\ninterface = \"can1\"\nbitrate = 250000",
     "t.toml:10:1: unknown key \"bitrate\" in [output.bus]; a CAN interface gets it from Linux: "
     "sudo ip link set can1 down; sudo ip link set can1 up type can bitrate 250000"},
    {"bit_rate_without_an_interface", "[output.bus]\nprotocol = \"can\"\nbitrate = 250000",
     "t.toml:7:1: [output.bus] lacks \"interface\"; required: CAN interface, such as \"can0\"\n"
     "t.toml:9:1: unknown key \"bitrate\" in [output.bus]; a CAN interface gets it from Linux: "
     "sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 250000"},
    {"bit_rate_of_an_empty_interface",
     "[output.bus]\nprotocol = \"can\"\ninterface = \"\"\nbitrate = 250000",
     "t.toml:9:13: \"interface\" is \"\"; allowed: the name of an interface, 1 to 15 characters "
     "without blanks, \"/\" and \":\"\n"
     "t.toml:10:1: unknown key \"bitrate\" in [output.bus]; a CAN interface gets it from Linux: "
     "sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 250000"},
    {"sample_point", "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\nsample_point = 0.8",
     "t.toml:10:1: unknown key \"sample_point\" in [output.bus]; a CAN interface gets it from "
     "Linux: "
     "sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 500000 sample-point "
     "0.8"},
    {"loopback_that_is_off",
     "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\nloopback = false",
     "t.toml:10:1: unknown key \"loopback\" in [output.bus]; it is off unless Linux was told "
     "otherwise (ip -details link shows it); leave it out"},
    {"bit_rate_by_another_name",
     "[output.bus]\nprotocol = \"dronecan\"\ninterface = \"can0\"\nnode_id = 7\nbaud = \"1M\"",
     "t.toml:11:1: unknown key \"baud\" in [output.bus]; a CAN interface gets it from Linux: sudo "
     "ip link set can0 down; sudo ip link set can0 up type can bitrate 500000"},
    {"bit_rate_of_the_data",
     "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\nfd = true\ndata_bitrate = 5000000",
     "t.toml:11:1: unknown key \"data_bitrate\" in [output.bus]; a CAN interface gets it from "
     "Linux: sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 500000 dbitrate "
     "5000000 fd on"},
    {"bit_rate_of_a_node",
     "[output.bus]\nprotocol = \"dronecan\"\ninterface = \"can0\"\n"
     "[dronecan.node]\ninterface = \"can0\"\nnode_id = 7\nbitrate = 1000000",
     "t.toml:13:1: unknown key \"bitrate\" in [dronecan.node]; a CAN interface gets it from Linux: "
     "sudo ip link set can0 down; sudo ip link set can0 up type can bitrate 1000000"},
    {"id_in_quotes", "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\nid = \"0x300\"",
     "t.toml:10:6: \"id\" is \"0x300\"; leave the quotes out: id = 0x300"},
    {"id_with_a_large_x", "[output.bus]\nprotocol = \"can\"\ninterface = \"can0\"\nid = 0X200",
     "t.toml:10:6: 0X200 is not a valid value: 0x, 0o and 0b have small letters; write 0x200"},
    {"list_inside_a_key_of_the_protocol",
     "[output.bus]\nprotocol = \"joystick\"\nname = \"pad\"\n"
     "[[output.bus.buttons.1]]\nchannel = 5\nabove = 1500",
     "t.toml:10:1: [[output.bus.buttons.1]] makes a list of tables; write [output.bus.buttons.1]"},
    {"output_of_a_chip_in_quotes",
     "[output.bus]\nprotocol = \"pwm\"\nchip = \"pwmchip0\"\noutputs = { 1 = \"0\" }",
     "t.toml:10:17: allowed: an output of the chip, 0 to 63, without quotes"},
};
INSTANTIATE_TEST_SUITE_P(Outputs, NewcomersMistakeInOutput, ::testing::ValuesIn(kInOutput),
                         [](const auto& mistake) { return std::string(mistake.param.name); });

}  // namespace
}  // namespace tribus::test::expected_mistakes_test
