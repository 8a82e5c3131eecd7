#include "transports/links/pulse_line/pulse_line_medium.h"

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "transports/links/gpio/gpio_line.h"
#include "transports/links/pulse_line/edge_link.h"
#include "transports/links/pulse_line/waveform.h"
#include "transports/links/spi/spi_link.h"

namespace tribus {
namespace {

constexpr std::array<std::string_view, 2> kEdges{"rising", "falling"};
constexpr std::array<std::string_view, 3> kBiases{"pull_up", "pull_down", "none"};

constexpr std::array kPulseLineSettings{
    Setting{.key = "edge",
            .type = SettingType::choice,
            .fallback = "\"rising\"",
            .choices = kEdges,
            .scope = SettingScope::input,
            .help = "The edges that are measured. Either works; the one that begins a pulse "
                    "shakes less with some receivers",
            .example = "\"falling\""},
    Setting{.key = "bias",
            .type = SettingType::choice,
            .absent = "as the line is",
            .choices = kBiases,
            .scope = SettingScope::input,
            .help = "What holds the level while nothing drives the line",
            .example = "\"pull_up\""},
    Setting{
        .key = "calibration",
        .type = SettingType::number,
        .fallback = "1",
        .least = 0.95,
        .most = 1.05,
        .scope = SettingScope::output,
        .help =
            "By how much pulses are too short, though the clock of the SPI port was measured: the "
            "channel that was asked for, divided by the one that an instrument shows",
        .example = "1.02"},
};

bool is_spi_device(const std::string& place) {
    return place.starts_with("/dev/") && place.find("gpiochip") == std::string::npos;
}

std::vector<SettingMistake> check_pulse_line(const std::string& place,
                                             const SettingValues& /*settings*/, SettingScope way,
                                             KeyUse /*key*/) {
    const std::string begin = "\"line\" is \"" + place + "\"";
    if (way == SettingScope::output && !is_spi_device(place)) {
        return {{{"line"},
                 begin + "; allowed for an output: an SPI port, such as \"/dev/spidev0.0\", whose "
                         "data line (MOSI) makes the pulses"}};
    }
    if (way == SettingScope::input && is_spi_device(place)) {
        return {{{"line"}, begin + "; allowed for an input: a GPIO line, such as \"GPIO17\""}};
    }
    const auto line = parse_gpio_place(place);
    return is_spi_device(place) || line
               ? std::vector<SettingMistake>{}
               : std::vector<SettingMistake>{{{"line"}, begin + ": " + line.error()}};
}

bool is_pulse_line_missing(const std::string& place) {
    if (is_spi_device(place)) {
        std::error_code error;
        return !std::filesystem::exists(place, error);
    }
    const auto line = parse_gpio_place(place);
    return line && is_gpio_line_absent(*line);
}

GpioBias bias_of(const SettingValues& settings) {
    const std::string text = settings.get_or("bias", std::string());
    if (text.empty()) {
        return GpioBias::as_is;
    }
    return text == "pull_up"     ? GpioBias::pull_up
           : text == "pull_down" ? GpioBias::pull_down
                                 : GpioBias::none;
}

tl::expected<std::unique_ptr<Link>, std::string> open_pulse_line(const std::string& place,
                                                                 const LinkUse& use) {
    if (is_spi_device(place)) {
        const double calibration = use.settings.get_or("calibration", 1.0);
        return as_link(SpiLink::open(place, pulse_signal(calibration), use.worker));
    }
    const bool falling = use.settings.get_or("edge", std::string()) == "falling";
    return as_link(EdgeLink::open(place, falling ? GpioEdges::falling : GpioEdges::rising,
                                  bias_of(use.settings)));
}

}  // namespace

constinit const Medium kPulseLineMedium{
    .name = "a pulse line",
    .shape = WireShape::bytes,
    .only_own_protocols = true,
    .place = {.key = "line",
              .required = true,
              .help = "Input: the GPIO line that reads the pulses, by its name or as "
                      "`gpiochip0:17`. Output: the SPI port whose data line (MOSI) makes them, "
                      "such as `/dev/spidev0.0`",
              .example = "\"GPIO17\"",
              .output_example = "\"/dev/spidev0.0\""},
    .place_absent = "required on a pulse line",
    .settings = kPulseLineSettings,
    .check = check_pulse_line,
    .has_datagrams = true,
    .users = Users::one,
    .silence = {.nothing = "no pulse yet; check wire, ground and power of the receiver",
                .no_frame =
                    "pulses but no frame yet; check that the receiver's output is PPM, and that "
                    "its level fits the line",
                .doctor = "looks at the line"},
    .is_missing = is_pulse_line_missing,
    .open = open_pulse_line,
};

}  // namespace tribus
