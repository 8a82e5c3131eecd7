#include "transports/links/spi/spi_serial_medium.h"

#include <filesystem>
#include <system_error>

#include "transports/links/spi/spi_link.h"
#include "transports/links/spi/uart_waveform.h"

namespace tribus {
namespace {

std::vector<SettingMistake> check_spi_port(const std::string& place,
                                           const SettingValues& /*settings*/, SettingScope /*way*/,
                                           KeyUse /*key*/) {
    if (place.starts_with("/dev/")) {
        return {};
    }
    return {{{"spi"},
             "\"spi\" is \"" + place + "\"; allowed: an SPI port, such as \"/dev/spidev0.0\""}};
}

bool is_port_missing(const std::string& place) {
    std::error_code error;
    return !std::filesystem::exists(place, error);
}

tl::expected<std::unique_ptr<Link>, std::string> open_port(const std::string& place,
                                                           const LinkUse& use) {
    return as_link(SpiLink::open(
        place,
        {.byte_time = use.line.bits_time(1),
         .draw = [line = use.line](
                     std::span<const std::uint8_t> frame,
                     SpiWaveform& waveform) { return draw_uart(frame, line, waveform); }},
        use.worker));
}

}  // namespace

constinit const Medium kSpiSerialMedium{
    .name = "an SPI port",
    .shape = WireShape::bytes,
    .draws_inverted = true,
    .place = {.key = "spi",
              .required = true,
              .help = "The SPI port whose data line (MOSI) draws the inverted signal, without an "
                      "inverter, such as `/dev/spidev0.0`",
              .example = "\"/dev/spidev0.0\""},
    .place_absent = "required on an SPI port",
    .check = check_spi_port,
    .has_line = true,
    .users = Users::one,
    .is_missing = is_port_missing,
    .open = open_port,
};

}  // namespace tribus
