#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/kernel_files.h"
#include "app/init/attachment.h"
#include "core/line_settings.h"
#include "core/time.h"

namespace tribus::init {

/// Access to serial ports, SPI ports and CAN interfaces. Calls may block. Thread-bound.
class Ports {
  public:
    Ports() = default;
    Ports(const Ports&) = delete;
    Ports& operator=(const Ports&) = delete;
    virtual ~Ports() = default;

    /// All of them. Opens none.
    virtual std::vector<ExaminedPlace> all() = 0;
    /// The one with this path or name. Opens nothing.
    virtual ExaminedPlace look(const std::string& place) = 0;
    /// Like `look`, but listens to a serial device.
    virtual ExaminedPlace listen(const std::string& place) = 0;
    /// Opens a serial device with these settings for a moment. Returns why it does not accept them;
    /// empty if it does. If it cannot be opened at all, adds a finding.
    virtual std::string try_line(ExaminedPlace& examined, const LineSettings& line) = 0;
};

/// The ports of this machine. Never writes to one.
class MachinePorts : public Ports {
  public:
    /// `listening`: time to listen to a port; zero: opens no port. Passes progress messages to
    /// `says`.
    MachinePorts(Duration listening, std::function<void(std::string_view)> says)
        : listening_(listening), says_(std::move(says)) {}

    std::vector<ExaminedPlace> all() override;
    ExaminedPlace look(const std::string& place) override;
    ExaminedPlace listen(const std::string& place) override;
    std::string try_line(ExaminedPlace& examined, const LineSettings& line) override;

  private:
    doctor::KernelFiles files_{"/"};
    Duration listening_;
    std::function<void(std::string_view)> says_;
};

}  // namespace tribus::init
