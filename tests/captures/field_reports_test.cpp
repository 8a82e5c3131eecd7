#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/cli/exit_status.h"
#include "tests/captures/recordings.h"
#include "tests/support/shell.h"

/// Inputs that were made from public reports, in the folder `field` of the recordings; its README
/// says what must come. Tests with literal bytes show each kind where the folder is missing.
namespace tribus::test::field_reports_test {
namespace {

std::filesystem::path field_folder() {
    return recordings_folder() / "field";
}

struct Report {
    std::string name;
    std::string command;
    int status = kExitFine;
    std::vector<std::string> says{};
};

void PrintTo(const Report& report, std::ostream* text) {
    *text << report.command;
}

std::vector<Report> reports() {
    const std::string control = "0.507 s  output o: under control of rx\n";
    const std::string cut = "the file ends in this line, as a loss of power leaves it";
    return {
        {"f01_elrs_50hz", "simulate f01.toml --in rx=f01_sbus_elrs_50hz.txt", 0, {control}},
        {"f02_marks", "simulate f01.toml --in rx=f02_sbus_marks_15_percent.txt", 0, {control}},
        {"f03_footer_14",
         "simulate f03.toml --in rx=f03_sbus2_footer14.txt",
         0,
         {"0.505 s  output o: under control of rx\n",
          "channel 12 is at 739.625 us, plausible are 800 to 2200 us"}},
        {"f06_can_log",
         "decode --protocol can f06_cut_last_line.log",
         0,
         {"f06_cut_last_line.log:30:32: ", cut, "3 frames in 29 CAN frames of 232 bytes"}},
        {"f06_timed_text",
         "decode --protocol sbus f06_cut_last_line.timed.txt",
         0,
         {"f06_cut_last_line.timed.txt:9:73: ", cut, "ok  footer=0x00"}},
        {"f06_simulate",
         "simulate f06_can.toml --in bus=f06_cut_last_line.log",
         0,
         {cut, "input bus: 232 bytes"}},
        {"f07_curly", "check f07_curly.toml", kExitWrongUse, {"is a typographic quote; allowed: "}},
        {"f07_leading_zero",
         "check f07_leading_zero.toml",
         kExitWrongUse,
         {"a number does not begin with 0; write 115200"}},
        {"f08_24_channels",
         "decode --protocol sbus f08_sbus24_centre.txt",
         0,
         {"0 frames in 2160 bytes",
          "it has 60 frames of FrSky's SBUS with 24 channels (36 bytes), which tribus does not "
          "read; set the receiver to 16 channels"}},
        {"f09_0x", "decode --protocol sbus f09_hex_0x.txt", 0, {"sbus     1510 1500 1000 1500"}},
        {"f09_without_spaces",
         "decode --protocol sbus f09_hex_without_spaces.txt",
         0,
         {"sbus     1510 1500 1000 1500"}},
        {"f10_short",
         "decode --as f10.toml:bus f10_short.log",
         0,
         {"message M: a frame has 7 bytes, but the DBC file gives it 8; signal X needs byte 2"}},
        {"f11_damaged_with_frames_inside",
         "decode --protocol crsf f11_crsf_damaged_frame_with_rc_inside.txt",
         0,
         {"20 frames in 900 bytes, 380 bytes skipped, rejected: 20 checksum"}},
        {"optional_signal",
         "simulate can_us/opt.toml --in bus=can_us/opt.log --out servos=/dev/null",
         0,
         {"0.500 s  output servos: under control of bus\n", "1 time into failsafe, 0 recoveries"}},
        {"multiplexed", "check can_us/mi.toml", 0, {"A1 = 2"}},
        {"multiplexed_simulate",
         "simulate can_us/mi.toml --in bus=can_us/mx.log",
         0,
         {"input bus: 40 bytes, 3 frames, 0 rejected"}},
        {"multiplexed_output", "check can_us/m.toml", 0, {"A0 = 1"}},
    };
}

class FieldReport : public testing::TestWithParam<Report> {};

TEST_P(FieldReport, IsAnsweredAsItsReadmeSays) {
    if (!std::filesystem::is_directory(field_folder())) {
        GTEST_SKIP() << field_folder() << " is missing";
    }
    const Ended ended =
        run_in_shell("cd '" + field_folder().string() + "'; \"$TRIBUS\" " + GetParam().command);
    EXPECT_EQ(ended.status, GetParam().status) << ended.output;
    for (const std::string& text : GetParam().says) {
        EXPECT_NE(ended.output.find(text), std::string::npos) << "not said: " << text << "\n"
                                                              << ended.output;
    }
}

INSTANTIATE_TEST_SUITE_P(Shared, FieldReport, testing::ValuesIn(reports()),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace tribus::test::field_reports_test
