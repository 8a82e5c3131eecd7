#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/kernel_files.h"
#include "app/doctor/facts/node_access.h"
#include "app/doctor/facts/serial_facts.h"
#include "transports/links/spi/spi_loopback.h"

namespace tribus::doctor {

/// An SPI port, whose data lines can be those of SBUS, and that out can make PPM.
struct SpiFacts {
    std::string device;
    NodeAccess access{};
    /// Why it could not be opened and set up, or an empty text; nothing if that was not tried.
    std::optional<std::string> refusal{};
    std::string no_output{};  ///< why it cannot draw a line, if that is so
    /// Who has it open. Then it is not opened.
    std::vector<PortUser> users{};
    /// The result of frames that a wire leads back; nothing if that was not tried.
    std::optional<SpiLoopback> loopback{};
};

/// All SPI ports. Opens nothing.
std::vector<SpiFacts> look_at_spi_ports(const KernelFiles& files);

/// The SPI port at a path; "spidev0.0" is enough. Opens nothing.
SpiFacts look_at_spi_port(const KernelFiles& files, const std::string& device);

/// Whether the name of a device is one of an SPI port, there or not.
bool names_spi_port(const std::string& device);

/// That result in words.
std::string describe(const SpiLoopback& loopback);

/// Says why a configuration cannot use it. A hindrance is a problem if the user `asked_for` this
/// port, else a note. Pure.
std::vector<Finding> judge_spi_port(const SpiFacts& facts, bool asked_for);

/// Lines for a configuration; none if it cannot be used.
std::vector<std::string> configuration_lines(const SpiFacts& facts);

}  // namespace tribus::doctor
