#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace tribus::test {

/// A simulated GPIO chip of eight lines (gpio-sim). It is removed with its object.
class GpioBank {
  public:
    struct Settings {
        std::string name = "lab";                 ///< different for each bank
        std::map<unsigned, std::string> names{};  ///< names of lines by offset
        std::optional<unsigned> hogged{};         ///< a line that the kernel reserves as "lab-hog"
    };

    GpioBank() : GpioBank(Settings{}) {}
    explicit GpioBank(const Settings& settings);
    GpioBank(const GpioBank&) = delete;
    GpioBank& operator=(const GpioBank&) = delete;
    ~GpioBank();

    /// Name of the chip, such as "gpiochip0".
    const std::string& chip() const { return chip_; }
    std::string path() const { return "/dev/" + chip_; }
    /// Level of the line as an oscilloscope would show it.
    std::string level(unsigned line) const;
    /// Drives a line that is an input.
    void pull(unsigned line, bool up) const;
    /// The file that drives it: "pull-up" or "pull-down".
    std::filesystem::path pull_file(unsigned line) const { return line_folder(line) / "pull"; }
    /// Removes the chip. `put_back` puts it back, perhaps as another one.
    void remove();
    void put_back();

  private:
    std::filesystem::path line_folder(unsigned line) const;

    std::filesystem::path device_;
    std::filesystem::path bank_;
    std::map<unsigned, std::string> names_;
    std::optional<unsigned> hogged_;
    std::string chip_;
    std::string platform_device_;
    bool live_ = false;
};

}  // namespace tribus::test
