#include "transports/links/gpio/gpio_place.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <system_error>

#include "core/quotes.h"

namespace tribus {

namespace {

constexpr std::string_view kChip = "gpiochip";
constexpr std::string_view kWhatAPlaceIs =
    "give a line's name, such as \"GPIO17\", or chip and offset, such as \"gpiochip0:17\"";

bool only_digits(std::string_view text) {
    return std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

tl::unexpected<std::string> refused(std::string_view text, const std::string& why) {
    return tl::unexpected(in_quotes(text) + " " + why + ": " + std::string(kWhatAPlaceIs));
}

}  // namespace

tl::expected<GpioPlace, std::string> parse_gpio_place(std::string_view text) {
    const bool path = text.starts_with('/');
    const bool chip = path || text.starts_with(kChip);
    // A line's name may contain a colon, and so may a path.
    const std::size_t colon = path ? text.rfind(':') : text.find(':');
    if (chip && colon == std::string_view::npos) {
        return refused(text, "names a chip but no line");
    }
    GpioPlace place;
    std::string_view line = text;
    if (chip) {
        place.chip = text.substr(0, colon);
        line = text.substr(colon + 1);
    }
    if (line.empty()) {
        return refused(text, "names no line");
    }
    if (!only_digits(line)) {
        place.line = std::string(line);
        return place;
    }
    if (!chip) {
        return refused(text, "is an offset without its chip");
    }
    unsigned offset = 0;
    if (std::from_chars(line.data(), line.data() + line.size(), offset).ec != std::errc()) {
        return refused(text, "has an offset that is too large");
    }
    place.line = offset;
    return place;
}

std::string to_text(const GpioPlace& place) {
    const auto* name = std::get_if<std::string>(&place.line);
    const std::string line = name ? *name : std::to_string(std::get<unsigned>(place.line));
    return place.chip.empty() ? line : place.chip + ":" + line;
}

std::string chip_path(const GpioPlace& place) {
    return place.chip.starts_with('/') ? place.chip : "/dev/" + place.chip;
}

}  // namespace tribus
