#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/time.h"
#include "transports/links/link_worker.h"
#include "transports/links/spi/spi_clock_watch.h"
#include "transports/links/spi/spi_port.h"

namespace tribus {

/// An open SPI port whose bytes keep their duration: it is measured anew when its clock has
/// changed, and says that once. Thread-bound.
class SpiPace {
  public:
    SpiPace(std::string device, SpiPort port, Duration byte_time, const WorkerSettings& worker);

    int file() const { return port_.file.get(); }
    Instant now() const { return worker_.now(); }
    /// A transfer of so many bytes took so long, and for `pause` nothing else is to be sent or
    /// heard. Sends zeros in that time if the clock may have changed (3 ms), and for up to 0.6 s if
    /// it has. Returns false if no rate fits any more: then the port is of no use.
    bool transferred(std::size_t bytes, Duration took, Duration pause = Duration::max());
    /// The port refused a transfer, with that errno.
    void refused(int error);

  private:
    bool measure_anew();

    std::string device_;
    SpiPort port_;
    Duration byte_time_;
    WorkerSettings worker_;
    SpiClockWatch watch_;
    bool told_change_ = false;
    bool told_refusal_ = false;
};

}  // namespace tribus
