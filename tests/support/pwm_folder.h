#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace tribus::test {

/// PWM chips as a folder with the files of /sys/class/pwm.
class PwmFolder {
  public:
    /// A chip whose outputs are there already.
    void add(const std::string& name, const std::string& driver, std::size_t outputs) {
        const std::filesystem::path chip = chips() / name;
        std::filesystem::create_directories(chip / "device");
        std::filesystem::create_symlink("../../../bus/drivers/" + driver,
                                        chip / "device" / "driver");
        write(chip / "npwm", std::to_string(outputs));
        write(chip / "export", "");
        write(chip / "unexport", "");
        for (std::size_t output = 0; output < outputs; ++output) {
            add_output(name, output);
        }
    }
    void add_output(const std::string& chip, std::size_t output) {
        const std::filesystem::path folder = chips() / chip / ("pwm" + std::to_string(output));
        std::filesystem::create_directories(folder);
        for (const char* file : {"period", "duty_cycle", "enable"}) {
            write(folder / file, "");
        }
    }
    /// The root of all files.
    const std::filesystem::path& root() const { return folder_.path(); }
    std::filesystem::path chips() const { return root() / "sys/class/pwm"; }
    /// Returns the text that was written last.
    std::string text(const std::string& chip, std::size_t output, const std::string& file) const {
        std::ifstream stream(path_of(chip, output, file));
        std::string text;
        std::getline(stream, text);
        return text;
    }
    /// The same of a file of the chip.
    std::string read(const std::string& chip, const std::string& file) const {
        std::ifstream stream(chips() / chip / file);
        std::string text;
        std::getline(stream, text);
        return text;
    }
    /// Takes it away too. Nothing may write there meanwhile.
    std::string take(const std::string& chip, std::size_t output, const std::string& file) const {
        std::string taken = text(chip, output, file);
        write(path_of(chip, output, file), "");
        return taken;
    }
    static void write(const std::filesystem::path& path, const std::string& text) {
        std::ofstream(path) << text;
    }

  private:
    std::filesystem::path path_of(const std::string& chip, std::size_t output,
                                  const std::string& file) const {
        return chips() / chip / ("pwm" + std::to_string(output)) / file;
    }

    TemporaryFolder folder_;
};

}  // namespace tribus::test
