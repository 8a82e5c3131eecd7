#include "transports/links/pwm/pwm_chip.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kChipPrefix = "pwmchip";
/// Any period will do for an output that is switched off.
constexpr Duration kUsualPeriod = std::chrono::milliseconds(20);

std::string first_line(const fs::path& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// The decimal number at its beginning.
long number(std::string_view text) {
    return std::strtol(std::string(text).c_str(), nullptr, 10);
}

long number_in(const fs::path& path) {
    return number(first_line(path));
}

/// Empty, or why not.
std::string write_file(const fs::path& path, const std::string& text) {
    const UniqueFd fd(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
    if (fd.valid() &&
        ::write(fd.get(), text.data(), text.size()) == static_cast<ssize_t>(text.size())) {
        return {};
    }
    return path.string() + ": " + std::strerror(errno);
}

long number_of_chip(const PwmChipFacts& chip) {
    return number(std::string_view(chip.name).substr(kChipPrefix.size()));
}

fs::path folder_of(const PwmChipFacts& chip, std::size_t output) {
    return chip.folder / ("pwm" + std::to_string(output));
}

/// Why the kernel's folder of chips cannot be read; nothing if it can, or if there is none.
std::error_code hindrance(const fs::path& root) {
    std::error_code error;
    const fs::directory_iterator chips(root / kPwmFolder, error);
    return error == std::errc::no_such_file_or_directory ? std::error_code() : error;
}

std::string names_of(const std::vector<PwmChipFacts>& chips) {
    std::string names;
    for (const PwmChipFacts& chip : chips) {
        names += (names.empty() ? "" : ", ") + chip.name +
                 (chip.driver.empty() ? "" : " (" + chip.driver + ")");
    }
    return names.empty() ? "this machine has none now; a device-tree overlay, such as "
                           "dtoverlay=i2c-pwm-pca9685a on a Raspberry Pi, makes one"
                         : "this machine has " + names;
}

}  // namespace

std::vector<PwmChipFacts> find_pwm_chips(const fs::path& root) {
    std::vector<PwmChipFacts> chips;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(root / kPwmFolder, error)) {
        PwmChipFacts chip;
        chip.folder = entry.path();
        chip.name = entry.path().filename();
        if (!chip.name.starts_with(kChipPrefix)) {
            continue;
        }
        chip.outputs = static_cast<std::size_t>(number_in(chip.folder / "npwm"));
        const fs::path driver = fs::read_symlink(chip.folder / "device" / "driver", error);
        chip.driver = driver.filename();
        if (const fs::path device = root / kPwmDeviceFolder / chip.name;
            fs::exists(device, error)) {
            chip.device = device;
        }
        chips.push_back(std::move(chip));
    }
    std::ranges::sort(chips, {}, number_of_chip);
    return chips;
}

tl::expected<PwmChipFacts, std::string> find_pwm_chip(const std::string& name,
                                                      const fs::path& root) {
    if (const std::error_code error = hindrance(root)) {
        return tl::unexpected(name + ": " + (root / kPwmFolder).string() + ": " + error.message());
    }
    const auto chips = find_pwm_chips(root);
    std::vector<PwmChipFacts> meant;
    std::ranges::copy_if(chips, std::back_inserter(meant), [&name](const PwmChipFacts& chip) {
        return chip.name == name || chip.driver == name;
    });
    if (meant.empty()) {
        return tl::unexpected(name + ": there is no such PWM chip; " + names_of(chips));
    }
    if (meant.size() > 1) {
        return tl::unexpected(name +
                              ": several PWM chips have this driver, name one: " + names_of(meant));
    }
    return meant.front();
}

bool is_pwm_chip_missing(const std::string& name, const fs::path& root) {
    return !hindrance(root) && !find_pwm_chip(name, root);
}

PwmOutputs::PwmOutputs(PwmChipFacts chip, Duration period)
    : chip_(std::move(chip)), period_(period), device_(chip_.device) {}

PwmOutputs::~PwmOutputs() {
    for (std::size_t output = 0; output < states_.size(); ++output) {
        if (states_[output] != State::unused) {
            set(output, 0);
            give_back(output);
        }
    }
}

void PwmOutputs::give_back(std::size_t output) {
    if (by_device(output)) {
        device_.give_back(output);
    } else {
        write_file(chip_.folder / "unexport", std::to_string(output));
    }
    states_[output] = State::unused;
}

std::string PwmOutputs::write(std::size_t output, const char* file, const std::string& text) const {
    return write_file(folder_of(chip_, output) / file, text);
}

/// Another program may have taken it by its files, or this one, which then died: it is switched off
/// and given back before. What cannot be had is given back too, because where outputs share a
/// period, one that is held keeps the others from theirs.
///
/// On kernels with the device the files must not be used: what comes out then has another period,
/// without an error.
std::string PwmOutputs::take(std::size_t output) {
    by_device_[output] = device_.is_open();
    std::error_code error;
    if (fs::exists(folder_of(chip_, output), error)) {
        write(output, "enable", "0");
        write_file(chip_.folder / "unexport", std::to_string(output));
    }
    std::string problem = by_device(output) ? device_.take(output, period_) : take_by_files(output);
    if (!problem.empty()) {
        give_back(output);
    }
    return problem;
}

std::string PwmOutputs::take_by_files(std::size_t output) {
    std::error_code error;
    if (!fs::exists(folder_of(chip_, output), error)) {
        if (auto problem = write_file(chip_.folder / "export", std::to_string(output));
            !problem.empty()) {
            return problem;
        }
    }
    write(output, "enable", "0");
    // A period may not be shorter than the pulse.
    write(output, "duty_cycle", "0");
    return write(output, "period", std::to_string(period_ / std::chrono::nanoseconds(1)));
}

std::string PwmOutputs::set_by_files(std::size_t output, std::uint32_t nanoseconds) {
    if (nanoseconds == 0) {
        return write(output, "enable", "0");
    }
    std::string problem = write(output, "duty_cycle", std::to_string(nanoseconds));
    if (problem.empty() && states_[output] != State::on) {
        problem = write(output, "enable", "1");
    }
    return problem;
}

std::string PwmOutputs::set(std::size_t output, std::uint32_t nanoseconds) {
    if (output >= std::min(chip_.outputs, kMost)) {
        return chip_.name + " has outputs 0 to " + std::to_string(chip_.outputs - 1) + ", no " +
               std::to_string(output);
    }
    if (states_[output] == State::unused) {
        if (auto problem = take(output); !problem.empty()) {
            return problem;
        }
    }
    if (pulses_[output] == nanoseconds) {
        return {};
    }
    std::string problem = !by_device(output) ? set_by_files(output, nanoseconds)
                          : nanoseconds == 0 ? device_.switch_off(output)
                                             : device_.set(output, period_, nanoseconds);
    if (!problem.empty()) {
        give_back(output);
    } else {
        states_[output] = nanoseconds == 0 ? State::taken : State::on;
    }
    pulses_[output] = problem.empty() ? std::optional(nanoseconds) : std::nullopt;
    return problem;
}

bool PwmOutputs::gone() const {
    std::error_code error;
    return !fs::exists(chip_.folder, error) || device_.gone();
}

std::optional<PwmOutputFacts> look_at(const PwmChipFacts& chip, std::size_t output) {
    const fs::path folder = folder_of(chip, output);
    std::error_code error;
    if (!fs::exists(folder, error)) {
        return std::nullopt;
    }
    return PwmOutputFacts{.on = number_in(folder / "enable") != 0,
                          .pulse = std::chrono::nanoseconds(number_in(folder / "duty_cycle")),
                          .period = std::chrono::nanoseconds(number_in(folder / "period"))};
}

std::string switch_off(const PwmChipFacts& chip, std::size_t output) {
    std::error_code error;
    const fs::path folder = folder_of(chip, output);
    if (fs::exists(folder, error)) {
        return write_file(folder / "enable", "0");
    }
    if (chip.device.empty()) {
        return {};
    }
    const PwmDevice device(chip.device);
    if (!device.is_open()) {
        return chip.device.string() + ": " + std::strerror(errno);
    }
    std::string problem = device.take(output, kUsualPeriod);
    device.give_back(output);
    return problem;
}

}  // namespace tribus
