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
    /// Whether its bytes have that duration. If they do not, it looks for a rate once a second,
    /// for a quarter of one.
    bool is_right();
    /// A transfer of so many bytes took so long. May send zeros: for 3 ms if the clock may have
    /// changed, and for up to 0.6 s if it has.
    void transferred(std::size_t bytes, Duration took);
    /// The port refused a transfer, with that errno.
    void refused(int error);

  private:
    void measure_anew();
    void warn(bool& told, const std::string& what);

    std::string device_;
    SpiPort port_;
    Duration byte_time_;
    WorkerSettings worker_;
    SpiClockWatch watch_;
    bool fits_ = true;
    bool told_change_ = false;
    bool told_no_rate_ = false;
    bool told_refusal_ = false;
    Instant measured_at_{};
};

}  // namespace tribus
