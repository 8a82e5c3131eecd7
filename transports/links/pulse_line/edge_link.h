#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "transports/links/gpio/gpio_library.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// The edges of a GPIO line, each with the time at which the kernel's interrupt saw it, as records
/// of core/edge_records.h. 2.7 ms after the latest edge a record says that the line is quiet; then
/// nothing comes until the next edge. The first edge, and one behind edges that were lost, are
/// marked so. Thread-bound. No heap after `open`.
class EdgeLink final : public ByteLink {
  public:
    /// `line`: a place of transports/links/gpio/gpio_place.h. The error begins with the line and
    /// says what to do.
    static tl::expected<std::unique_ptr<EdgeLink>, std::string> open(const std::string& line,
                                                                     GpioEdges edges,
                                                                     GpioBias bias);
    /// The same for a line that is held, and whose descriptor does not block. The error is a value
    /// of errno.
    static tl::expected<std::unique_ptr<EdgeLink>, int> on(std::unique_ptr<GpioHeldLine> line);
    ~EdgeLink() override;

    ReadStatus read(Reception& reception) override;
    /// Nothing can be written.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override;
    int descriptor() const override { return line_->descriptor(); }
    int second_descriptor() const override { return timer_.get(); }

  private:
    EdgeLink(std::unique_ptr<GpioHeldLine> line, UniqueFd timer);
    void set_timer(std::uint64_t at_nanoseconds);
    bool take_edges(Reception& reception);
    void stay_without_edge(Reception& reception);

    std::unique_ptr<GpioHeldLine> line_;
    UniqueFd timer_;
    std::uint64_t timer_at_ = 0;     ///< in nanoseconds of the monotonic clock
    std::uint64_t latest_edge_ = 0;  ///< likewise; 0: none yet
    bool is_quiet_ = true;           ///< a record said so, or no edge came yet
    bool after_loss_ = true;
    bool gone_ = false;
};

}  // namespace tribus
