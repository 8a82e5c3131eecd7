#include "transports/links/gpio/gpio_search.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstring>

#include "core/quotes.h"

namespace tribus {

namespace {

constexpr std::size_t kMostNames = 6;
/// The kernel's internal ENOTSUPP, which reaches programs but is not in their headers.
constexpr int kDriverCannot = 524;

constexpr const char* kNoChips =
    "this machine has no GPIO chips (/dev/gpiochip*): no driver for one is loaded, or its kernel "
    "is "
    "built without CONFIG_GPIO_CDEV";
constexpr const char* kNoPermission =
    "no permission to open it; GPIO chips belong to root alone unless a rule says otherwise: put "
    "SUBSYSTEM==\"gpio\", KERNEL==\"gpiochip*\", GROUP=\"gpio\", MODE=\"0660\" into "
    "/etc/udev/rules.d/60-gpio.rules, then `sudo groupadd --system gpio; sudo usermod -aG gpio "
    "$USER; sudo udevadm trigger`, and log in again";
constexpr const char* kForbidden =
    "this program may not open any GPIO chip, not even as root; does its service's unit lack "
    "`DeviceAllow=char-gpiochip rw`?";
constexpr const char* kOldKernel =
    "the kernel lacks the GPIO interface that this program is built for: version 2 of libgpiod "
    "needs Linux 5.10 or newer, version 1 needs CONFIG_GPIO_CDEV_V1";

std::string short_name(const GpioChip& chip) {
    return chip.path.substr(chip.path.rfind('/') + 1);
}

std::string short_names(std::span<const GpioChip> chips) {
    std::string text;
    for (const GpioChip& chip : chips) {
        text += (text.empty() ? "" : ", ") + short_name(chip);
    }
    return text;
}

std::string chip_problem(int error) {
    switch (error) {
        case EACCES:
            return kNoPermission;
        case EPERM:
            return kForbidden;
        case EINVAL:
            return kOldKernel;
        case ENODEV:
        case ENXIO:
        case ENOENT:
            return "it has just been removed";
        default:
            return std::string("the kernel does not describe its lines: ") + std::strerror(error);
    }
}

std::size_t common_start(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
    const auto same = [&](char x, char y) { return lower(x) == lower(y); };
    return static_cast<std::size_t>(std::ranges::mismatch(a, b, same).in1 - a.begin());
}

/// All names; those that begin most like `wrong` come first.
std::vector<std::string_view> names_like(std::string_view wrong, std::span<const GpioChip> chips) {
    std::vector<std::string_view> names;
    for (const GpioChip& chip : chips) {
        for (const GpioLineFacts& line : chip.lines) {
            if (!line.name.empty()) {
                names.push_back(line.name);
            }
        }
    }
    std::stable_sort(names.begin(), names.end(), [&](std::string_view a, std::string_view b) {
        return common_start(wrong, a) > common_start(wrong, b);
    });
    return names;
}

std::string no_such_name(const std::string& name, std::span<const GpioChip> chips) {
    std::string text = "no line of " + short_names(chips) + " has the name " + in_quotes(name);
    const auto names = names_like(name, chips);
    if (names.empty()) {
        text += "; no line has a name: give chip and offset, such as " + short_name(chips.front()) +
                ":0";
    } else {
        const std::size_t shown = std::min(names.size(), kMostNames);
        text += "; the names are: " + in_quotes_all(std::span(names).first(shown));
        text += shown < names.size() ? " and more, which `gpioinfo` (package gpiod) shows" : "";
    }
    for (const GpioChip& chip : chips) {
        if (chip.error != 0) {
            text +=
                "; the lines of " + short_name(chip) + " are unknown: " + chip_problem(chip.error);
        }
    }
    return text;
}

tl::expected<GpioFinding, std::string> find_name(const std::string& name,
                                                 std::span<const GpioChip> chips) {
    std::vector<GpioFinding> found;
    for (const GpioChip& chip : chips) {
        for (std::size_t offset = 0; offset < chip.lines.size(); ++offset) {
            if (chip.lines[offset].name == name) {
                found.push_back({chip, static_cast<unsigned>(offset)});
            }
        }
    }
    if (found.empty()) {
        return tl::unexpected(no_such_name(name, chips));
    }
    if (found.size() > 1) {
        std::string text = std::to_string(found.size()) + " lines have this name; give one of ";
        for (const GpioFinding& line : found) {
            text += &line == &found.front() ? "" : ", ";
            text += short_name(line.chip) + ":" + std::to_string(line.offset);
        }
        return tl::unexpected(text);
    }
    return found.front();
}

tl::expected<GpioFinding, std::string> find_offset(unsigned offset, const GpioChip& chip) {
    if (offset >= chip.lines.size()) {
        const std::string lines = std::to_string(chip.lines.size());
        return tl::unexpected(chip.lines.empty()
                                  ? "this chip has no lines"
                                  : "this chip has " + lines + " lines: give an offset from 0 to " +
                                        std::to_string(chip.lines.size() - 1));
    }
    return GpioFinding{chip, offset};
}

std::string in_use(const std::string& consumer) {
    if (consumer.empty()) {
        return "it is in use, the kernel does not say by what: another program, a driver, or "
               "another function of this pin (UART, SPI, ...); free it, or use another line";
    }
    return "it is in use by " + in_quotes(consumer) +
           ", a program, a driver or the device tree: end that, or use another line";
}

}  // namespace

tl::expected<GpioFinding, std::string> find_gpio_line(const GpioPlace& place,
                                                      std::string_view chip_path,
                                                      std::span<const GpioChip> chips) {
    if (chips.empty()) {
        return tl::unexpected(std::string(kNoChips));
    }
    std::span<const GpioChip> searched = chips;
    if (!chip_path.empty()) {
        const auto chip = std::find_if(chips.begin(), chips.end(), [&](const GpioChip& candidate) {
            return candidate.path == chip_path;
        });
        if (chip == chips.end()) {
            return tl::unexpected("there is no such GPIO chip; this machine has " +
                                  short_names(chips) +
                                  "; `gpiodetect` (package gpiod) describes them");
        }
        searched = {chip, 1};
    }
    const bool any_known = std::any_of(searched.begin(), searched.end(),
                                       [](const GpioChip& chip) { return chip.error == 0; });
    if (!any_known) {
        const std::string subject = chip_path.empty() ? short_names(searched) + ": " : "";
        return tl::unexpected(subject + chip_problem(searched.front().error));
    }
    if (const auto* name = std::get_if<std::string>(&place.line)) {
        return find_name(*name, searched);
    }
    if (chip_path.empty()) {
        return tl::unexpected("an offset needs a chip, such as " + short_name(chips.front()) + ":" +
                              to_text(place));
    }
    return find_offset(std::get<unsigned>(place.line), searched.front());
}

std::string gpio_refusal(int error, const GpioLineFacts& line, GpioUse use, GpioBias bias) {
    if (error == EBUSY || (error == EINVAL && line.used)) {
        return in_use(line.consumer);
    }
    if (error == EINVAL && bias != GpioBias::as_is) {
        return "the kernel refuses a bias for it: that needs Linux 5.5 or newer and a chip with "
               "such resistors; set no bias, and connect a resistor to the line";
    }
    if (use == GpioUse::input && (error == ENODEV || error == ENXIO)) {
        return "its chip does not report changes of this line (it has no interrupt), or is gone; "
               "use a line of another chip";
    }
    if (error == kDriverCannot || error == EOPNOTSUPP || error == EIO) {
        return use == GpioUse::output
                   ? "its chip cannot make an output of this line, or does not answer; use another"
                   : "its chip cannot make an input of this line, or does not answer; use another";
    }
    switch (error) {
        case EACCES:
        case EPERM:
        case EINVAL:
        case ENODEV:
        case ENXIO:
        case ENOENT:
            return chip_problem(error);
        default:
            return std::string("the kernel refuses it: ") + std::strerror(error);
    }
}

}  // namespace tribus
