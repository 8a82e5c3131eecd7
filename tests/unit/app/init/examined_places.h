#pragma once

#include <string>

#include "app/doctor/listening/line_heard.h"
#include "app/init/attachment.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/links/spi/spi_serial_medium.h"

/// Places for the tests of `tribus init`.
namespace tribus::init::test {

/// A USB adapter that runs every protocol.
inline ExaminedPlace free_port(const std::string& number) {
    ExaminedPlace examined{.medium = &kSerialMedium,
                           .name = "/dev/serial/by-id/usb-FTDI_" + number,
                           .node = "/dev/ttyUSB" + number,
                           .kind = "USB adapter, FTDI FT232R"};
    examined.facts.name = "ttyUSB" + number;
    examined.facts.node = examined.node;
    examined.facts.device = examined.name;
    examined.facts.driver = "ftdi_sio";
    doctor::UsbFacts& usb = examined.facts.usb.emplace();
    usb.vendor = 0x0403;
    usb.product = 0x6001;
    usb.release = 0x0600;
    return examined;
}

/// The mini UART of a Raspberry Pi, which has no parity bit.
inline ExaminedPlace mini_uart() {
    ExaminedPlace examined{.medium = &kSerialMedium,
                           .name = "/dev/ttyS0",
                           .node = "/dev/ttyS0",
                           .kind = "mini UART of a Raspberry Pi"};
    examined.facts.name = "ttyS0";
    examined.facts.node = examined.facts.device = examined.name;
    examined.facts.driver = "bcm2835-aux-uart";
    return examined;
}

inline ExaminedPlace interface_named(const std::string& name) {
    return {.medium = &kCanMedium, .name = name, .node = name, .kind = "CAN interface"};
}

inline ExaminedPlace spi_port() {
    return {.medium = &kSpiSerialMedium,
            .name = "/dev/spidev0.0",
            .node = "/dev/spidev0.0",
            .kind = "SPI port: SBUS without an inverter"};
}

inline ExaminedPlace with_problem(ExaminedPlace examined, std::string_view id,
                                  const std::string& what) {
    examined.findings.push_back(
        {doctor::Severity::problem, id, examined.node, what, "", "Correct it."});
    return examined;
}

inline doctor::LineStory heard_ibus(std::size_t channels = 14) {
    doctor::LineStory story;
    story.sound = doctor::LineSound::frames;
    story.protocol = "ibus";
    story.line = doctor::kIbusLine;
    story.listened = std::chrono::seconds(3);
    story.frames = 390;
    story.bytes = 390 * 32;
    story.period = std::chrono::microseconds(7700);
    story.channels = channels;
    return story;
}

inline doctor::LineStory heard_sbus() {
    doctor::LineStory story = heard_ibus(18);
    story.protocol = "sbus";
    story.line = doctor::kSbusLine;
    return story;
}

inline ExaminedPlace with_story(ExaminedPlace examined, const doctor::LineStory& story) {
    examined.story = story;
    return examined;
}

}  // namespace tribus::init::test
