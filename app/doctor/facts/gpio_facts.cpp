#include "app/doctor/facts/gpio_facts.h"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <numeric>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "core/quotes.h"
#include "transports/links/gpio/gpio_line.h"

namespace tribus::doctor {
namespace {

constexpr std::string_view kGpioChipNames = "gpiochip";
constexpr std::string_view kGpioLineNames = "GPIO";

std::string name_of_gpio(const std::string& device) {
    return std::filesystem::path(device).filename().string();
}

/// "gpiochip0", without a line.
bool names_whole_chip(const std::string& device) {
    return name_of_gpio(device).starts_with(kGpioChipNames) &&
           device.find(':') == std::string::npos;
}

GpioPlace place_of(const std::string& device) {
    if (names_whole_chip(device)) {
        return {.chip = device, .line = 0U};
    }
    return parse_gpio_place(device).value_or(GpioPlace{{}, device});
}

Severity severity_of(bool asked_for) {
    return asked_for ? Severity::problem : Severity::note;
}

Finding gpio_finding(bool asked_for, int error, const std::string& where, const std::string& what) {
    const bool refused = error == EACCES || error == EPERM;
    return {severity_of(asked_for),
            refused ? "gpio.permission" : "gpio.missing",
            where,
            what,
            asked_for ? "" : "Only PPM inputs and the lines of [gpio.NAME] need it.",
            ""};
}

const GpioChip* chip_at(const std::string& path, std::span<const GpioChip> chips) {
    const auto chip = std::ranges::find(chips, path, &GpioChip::path);
    return chip == chips.end() ? nullptr : &*chip;
}

}  // namespace

bool names_gpio(const std::string& device, std::span<const GpioChip> chips) {
    if (name_of_gpio(device).starts_with(kGpioChipNames) || device.starts_with(kGpioLineNames)) {
        return true;
    }
    // Lines without a name are named by their numbers.
    return !device.empty() && std::ranges::any_of(chips, [&device](const GpioChip& chip) {
        return std::ranges::count(chip.lines, device, &GpioLineFacts::name) != 0;
    });
}

std::optional<GpioFacts> look_at_gpio(const std::string& device, const std::string& chip_path,
                                      std::span<const GpioChip> chips) {
    if (names_whole_chip(device)) {
        const GpioChip* chip = chip_at(chip_path, chips);
        if (chip == nullptr || chip->error != 0) {
            return std::nullopt;
        }
        GpioFacts facts{*chip, std::vector<unsigned>(chip->lines.size())};
        std::iota(facts.asked.begin(), facts.asked.end(), 0U);
        return facts;
    }
    const auto found = find_gpio_line(place_of(device), chip_path, chips);
    return found ? std::optional(GpioFacts{found->chip, {found->offset}}) : std::nullopt;
}

std::vector<Finding> judge_gpio(const std::string& device, const std::string& chip_path,
                                std::span<const GpioChip> chips) {
    const auto found = find_gpio_line(place_of(device), chip_path, chips);
    if (!found) {
        const GpioChip* chip = chip_at(chip_path, chips);
        const bool all_refused = !chips.empty() && std::ranges::all_of(chips, &GpioChip::error);
        const int error = chip != nullptr ? chip->error : all_refused ? chips.front().error : 0;
        return {gpio_finding(true, error, device, found.error())};
    }
    const GpioLineFacts& line = found->chip.lines[found->offset];
    if (names_whole_chip(device) || !line.used) {
        return {};
    }
    return {{Severity::problem, "gpio.in_use", device,
             gpio_refusal(EBUSY, line, GpioUse::input, GpioBias::as_is), "", ""}};
}

std::vector<Finding> judge_gpio_chip(const GpioChip& chip) {
    if (chip.error == 0) {
        return {};
    }
    // The search knows what to say of a chip that was refused.
    const GpioPlace any{.chip = chip.path, .line = 0U};
    const auto refused = find_gpio_line(any, chip.path, std::span(&chip, 1));
    return {gpio_finding(false, chip.error, chip.path, refused.error())};
}

std::string describe(const GpioFacts& facts) {
    const std::size_t lines = facts.chip.lines.size();
    const auto used = std::ranges::count(facts.chip.lines, true, &GpioLineFacts::used);
    return fmt::format("GPIO chip with {} {}, {} of them in use", lines,
                       lines == 1 ? "line" : "lines", used);
}

std::vector<std::string> configuration_lines(const GpioFacts& facts) {
    if (facts.asked.size() != 1 || facts.chip.lines[facts.asked.front()].used) {
        return {};
    }
    const unsigned offset = facts.asked.front();
    const std::string& name = facts.chip.lines[offset].name;
    return {"[input.trainer]", "protocol = \"ppm\"",
            "line     = " +
                in_quotes(name.empty() ? fmt::format("{}:{}", name_of_gpio(facts.chip.path), offset)
                                       : name)};
}

std::string gpio_chip_path(const std::string& device) {
    return followed_chip_path(place_of(device));
}

}  // namespace tribus::doctor
