#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/guest.h"
#include "tests/lab/input_devices.h"
#include "tests/loopback/loopback.h"

/// What `tribus doctor` says of a gamepad of the kernel (uinput).
namespace tribus::test::input_doctor_test {
namespace {

class LabInputDoctor : public Loopback {
  protected:
    LabInputDoctor() {
        require_guest();
        shell("modprobe -a uinput evdev");
        pad_.emplace("pad of the laboratory");
        std::filesystem::create_symlink(pad().device(), path());
    }
    /// A name as a rule of udev makes one.
    std::string path() const { return folder() / "pad"; }
    const VirtualGamepad& pad() const { return *pad_; }
    std::string said(const std::vector<std::string>& devices, int status) {
        std::vector<std::string> words{"doctor"};
        words.insert(words.end(), devices.begin(), devices.end());
        Program& program = start(words);
        EXPECT_EQ(program.end(), status) << program.output() << program.errors();
        return program.output();
    }
    static bool says(const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    }

  private:
    std::optional<VirtualGamepad> pad_;
};

TEST_F(LabInputDoctor, FindsGamepadsAndUinputAmongAllDevices) {
    Program& program = start({"doctor"});
    program.end();
    const std::string all = program.output();
    EXPECT_TRUE(
        says(all, pad().device() + ": gamepad \"pad of the laboratory\", 4 axes, 3 buttons\n"))
        << all;
    EXPECT_TRUE(says(all, "/dev/uinput: virtual joysticks are possible\n")) << all;
    EXPECT_TRUE(says(all, "[input.no_stable_name]")) << all;
}

TEST_F(LabInputDoctor, PrintsTheLinesOfAGamepadsInput) {
    const std::string text = said({path(), "/dev/uinput"}, 0);
    EXPECT_TRUE(says(text, "    protocol = \"gamepad\"\n    device   = \"" + path() + "\"\n"))
        << text;
    // It is let go again.
    EXPECT_TRUE(InputReader(pad().device()).grab());
}

TEST_F(LabInputDoctor, SaysWhichProgramHasTakenAGamepad) {
    const InputReader other(pad().device());
    ASSERT_TRUE(other.grab());
    const std::string text = said({path()}, 1);
    EXPECT_TRUE(says(text, "another program has taken it for itself")) << text;
    EXPECT_TRUE(says(text, "[input.cannot_open]")) << text;
    EXPECT_TRUE(says(text, "[input.in_use]")) << text;
}

TEST_F(LabInputDoctor, SaysWhichGroupsMayUseThem) {
    shell("chmod 660 " + pad().device() + "; chmod 600 /dev/uinput");
    const ShellResult result =
        run_shell("setpriv --reuid nobody --regid nogroup --clear-groups " TRIBUS_PROGRAM
                  " doctor /dev/uinput " +
                  pad().device());
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(says(result.output, "[input.permission]")) << result.output;
    EXPECT_TRUE(says(result.output, "[uinput.permission]")) << result.output;
}

}  // namespace
}  // namespace tribus::test::input_doctor_test
