#include "transports/links/spi/spi_serial_medium.h"

#include <filesystem>
#include <system_error>

#include "transports/links/spi/spi_link.h"
#include "transports/links/spi/spi_listener.h"
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
    if (use.way == SettingScope::input) {
        return as_link(SpiListener::open(place, use.line, use.worker));
    }
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
    .inverts = true,
    .place = {.key = "spi",
              .required = true,
              .help = "An SPI port in place of a serial port with an inverter, such as "
                      "`/dev/spidev0.0`: of an output, its data line out (MOSI) is the signal; of "
                      "an input, its data line in (MISO)",
              .example = "\"/dev/spidev0.0\""},
    .place_absent = "required on an SPI port",
    .check = check_spi_port,
    .has_line = true,
    .users = Users::one,
    .why_one_way = ": a transfer that draws a frame cannot wait for one that listens",
    .silence = {.nothing = "no byte yet; check wire (the receiver's signal at MISO), ground and "
                           "power of the receiver",
                .no_frame = "but no frame yet; check protocol and rate, and that no inverter is in "
                            "the wire: an SPI port needs none",
                .counts = "byte",
                .doctor = "looks at the port"},
    .is_missing = is_port_missing,
    .open = open_port,
};

}  // namespace tribus
