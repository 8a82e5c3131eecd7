#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include <tl/expected.hpp>

#include "transports/links/link.h"
#include "transports/links/link_worker.h"
#include "transports/links/spi/spi_pace.h"
#include "transports/links/spi/waveform.h"

namespace tribus {

/// The demands of a protocol on the data line.
struct SpiSignal {
    /// So long a byte of the port must last: the rate is searched for when the port is opened
    /// (spi_clock.h).
    Duration byte_time{};
    /// Draws a frame. False: there is nothing to send. Only the thread of the link calls it.
    std::function<bool(std::span<const std::uint8_t> frame, SpiWaveform& waveform)> draw;
};

/// Draws frames with the data line (MOSI) of an SPI port; the hardware times them. The kernel keeps
/// a writer waiting for a whole frame, so a thread of the link hands frames to it; it takes the
/// newest only. `write` neither waits nor uses the heap. Thread-bound.
class SpiLink final : public ByteLink {
  public:
    /// As `open_spi_port`: the line stays down.
    static tl::expected<std::unique_ptr<SpiLink>, std::string> open(const std::string& device,
                                                                    SpiSignal signal,
                                                                    const WorkerSettings& worker);
    /// Ends after the frame that is on the line.
    ~SpiLink() override = default;

    /// Nothing arrives.
    ReadStatus read(Reception& reception) override;
    /// Takes one frame, of which `SpiSignal::draw` may make nothing: that withdraws a frame that
    /// waits. `busy`: the thread is taking the frame before, or dropped it because it
    /// was too old; `unavailable` while the kernel refuses frames or does not send them, or the
    /// thread gets no processor time; `lost` when the device is gone, or
    /// has no rate any more that fits.
    WriteStatus write(std::span<const std::uint8_t> frame) override {
        return write_asked(frame, worker_.life_from_now());
    }
    WriteStatus write_asked(std::span<const std::uint8_t> frame, FrameLife life) override;
    bool stands(Instant now) const override { return worker_.stands(now); }
    void discard_unread() override {}
    int descriptor() const override { return -1; }

  private:
    SpiLink(SpiPace pace, SpiSignal signal);
    bool keep_frame(std::span<const std::uint8_t> frame, FrameLife life);
    bool take_frame(Instant& valid_until);
    WriteStatus send_newest();

    static constexpr std::size_t kMostFrameBytes = 96;

    SpiPace pace_;  ///< of the thread
    SpiSignal signal_;
    std::mutex mutex_;  ///< the data thread only tries it
    std::array<std::uint8_t, kMostFrameBytes> waiting_{};
    std::size_t waiting_bytes_ = 0;
    Instant waiting_until_{};
    WriteStatus outcome_ = WriteStatus::written;  ///< of the thread
    SpiWaveform waveform_;                        ///< of the thread
    LinkWorker worker_;
};

}  // namespace tribus
