#include "app/inspect/diff.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "tests/unit/config/main_job.h"

namespace tribus::test::diff_test {
namespace {

const std::string kJob = main_job_with(0, "");

std::string difference(std::string_view fresh) {
    return configuration_difference(loaded(kJob), loaded(fresh));
}

TEST(Diff, SaysNothingWhereNothingChanges) {
    EXPECT_EQ(difference("# a remark\n" + kJob), "");
}

TEST(Diff, SaysChannelByChannelHowTheMapChanges) {
    EXPECT_EQ(difference(kJob + "[pipeline.main.channels]\n"
                                "1 = 2\n"
                                "2 = { from = 1, reverse = true, expo = 0.3 }\n"
                                "16 = { fixed = 1500 }\n"),
              "pipeline main:\n"
              "  channel 1: channel 1 before, now channel 2\n"
              "  channel 2: channel 2 before, now channel 1, reverse, expo 0.3\n"
              "  channel 16: channel 16 before, now fixed 1500 us\n"
              "  (applies from the next frame of its outputs)\n");
}

TEST(Diff, SaysWhatIsSetOtherwiseAndThatAnInputGoesOn) {
    EXPECT_EQ(difference(main_job_with(3, "device = \"/dev/ttyA\"\ntimeout = \"200ms\"")),
              "input receiver:\n"
              "  timeout: 100ms before, now 200ms\n"
              "  (it goes on; nothing is lost)\n");
}

TEST(Diff, SaysThatAnInputOnAnotherDeviceBeginsAnew) {
    EXPECT_EQ(difference(main_job_with(3, "device = \"/dev/ttyC\"")),
              "input receiver:\n"
              "  device: /dev/ttyA before, now /dev/ttyC\n"
              "  (it starts again, as never seen)\n");
}

TEST(Diff, NamesWhatIsNewAndWhatIsRemoved) {
    const std::string tail =
        "[output.tail]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyD\"\n"
        "[pipeline.tail]\nfrom = \"receiver\"\nto = \"tail\"\n";
    EXPECT_EQ(difference(kJob + tail), "output tail: new\npipeline tail: new\n");
    EXPECT_EQ(configuration_difference(loaded(kJob + tail), loaded(kJob)),
              "output tail: removed; it sends its last frames as at the end\n"
              "pipeline tail: removed\n");
}

TEST(Diff, NamesWhatChangesOfTheRecorder) {
    const std::string recorder = "[recorder]\ndirectory = \"/var/lib/x\"\n";
    EXPECT_EQ(difference(kJob + recorder), "recorder: new\n");
    EXPECT_EQ(configuration_difference(loaded(kJob + recorder), loaded(kJob)),
              "recorder: removed\n");
    EXPECT_EQ(
        configuration_difference(loaded(kJob + recorder), loaded(kJob + recorder + "keep = 3\n")),
        "recorder:\n  keep: 20 before, now 3\n");
}

TEST(Diff, TellsARenamedInputFromANewOne) {
    std::string renamed = kJob;
    renamed.replace(renamed.find("[input.receiver]"), 16, "[input.rx]");
    renamed.replace(renamed.find("from = \"receiver\""), 17, "from = \"rx\"");
    EXPECT_EQ(difference(renamed).substr(0, 53),
              "input receiver: is now called rx, and goes on\npipelin");
}

TEST(Diff, SaysWhatAReloadCannotDoWithoutAStop) {
    EXPECT_EQ(difference(kJob + "[runtime]\npriority = 70\n"),
              "runtime:\n  priority: 80 before, now 70\na reload stops all outputs for a moment: "
              "[runtime] changes the scheduling of the data thread\n");
}

}  // namespace
}  // namespace tribus::test::diff_test
