#include "tests/lab/gpio_bank.h"

#include <system_error>

#include "tests/lab/shell.h"

namespace tribus::test {

namespace {

namespace fs = std::filesystem;

fs::path line_settings(const fs::path& bank, unsigned line) {
    return bank / ("line" + std::to_string(line));
}

}  // namespace

GpioBank::GpioBank(const Settings& settings)
    : device_(fs::path("/sys/kernel/config/gpio-sim") / settings.name),
      bank_(device_ / "bank"),
      names_(settings.names),
      hogged_(settings.hogged) {
    shell(
        "modprobe gpio-sim && (mountpoint -q /sys/kernel/config || "
        "mount -t configfs configfs /sys/kernel/config)");
    fs::create_directories(bank_);
    write_kernel_file(bank_ / "num_lines", "8");
    for (const auto& [line, name] : names_) {
        fs::create_directory(line_settings(bank_, line));
        write_kernel_file(line_settings(bank_, line) / "name", name);
    }
    if (hogged_) {
        const fs::path hog = line_settings(bank_, *hogged_) / "hog";
        fs::create_directories(hog);
        write_kernel_file(hog / "name", "lab-hog");
        write_kernel_file(hog / "direction", "output-high");
    }
    put_back();
}

GpioBank::~GpioBank() {
    remove();
    std::error_code ignored;
    if (hogged_) {
        fs::remove(line_settings(bank_, *hogged_) / "hog", ignored);
        fs::remove(line_settings(bank_, *hogged_), ignored);
    }
    for (const auto& [line, name] : names_) {
        fs::remove(line_settings(bank_, line), ignored);
    }
    fs::remove(bank_, ignored);
    fs::remove(device_, ignored);
}

void GpioBank::put_back() {
    write_kernel_file(device_ / "live", "1");
    live_ = true;
    chip_ = read_file(bank_ / "chip_name");
    platform_device_ = read_file(device_ / "dev_name");
}

void GpioBank::remove() {
    if (live_) {
        live_ = false;
        write_kernel_file(device_ / "live", "0");
    }
}

std::string GpioBank::level(unsigned line) const {
    return read_file(line_folder(line) / "value");
}

void GpioBank::pull(unsigned line, bool up) const {
    write_kernel_file(pull_file(line), up ? "pull-up" : "pull-down");
}

fs::path GpioBank::line_folder(unsigned line) const {
    return fs::path("/sys/devices/platform") / platform_device_ / chip_ /
           ("sim_gpio" + std::to_string(line));
}

}  // namespace tribus::test
