#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/few_descriptors.h"
#include "tests/support/sanitized.h"

/// The daemon on a machine that gives it too few descriptors. The laboratory has the same of other
/// media.
namespace tribus::test::descriptors_test {
namespace {

class Descriptors : public Loopback {};

TEST_F(Descriptors, AreAskedForAtTheStartOrItEndsWithAnErrorThatSaysSo) {
    if (kSanitized) {
        GTEST_SKIP() << "a sanitizer needs descriptors of its own";
    }
    device("receiver");
    const std::string file = write_config(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\n"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
        "[output.servos]\nprotocol = \"sbus\"\naddress = \"127.0.0.1:5598\"\n");
    const DescriptorTrials trials = run_with_few_descriptors(folder(), file);
    EXPECT_GT(trials.ended, 0);
    EXPECT_GT(trials.ran, 0);
}

}  // namespace
}  // namespace tribus::test::descriptors_test
