#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include <tl/expected.hpp>

#include "transports/links/link.h"
#include "transports/links/link_worker.h"
#include "transports/links/pulse_line/waveform.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Makes pulses with the data line (MOSI) of an SPI port: one bit is one microsecond, and the
/// hardware times them. The kernel keeps a writer waiting for a whole frame, so a thread of the
/// link hands frames to it; it takes the newest only. `write` neither waits nor uses the heap.
/// Thread-bound.
class SpiLink final : public ByteLink {
  public:
    /// `calibration`: how much faster than it should the port's clock is. The error begins with the
    /// device and says what to do.
    static tl::expected<std::unique_ptr<SpiLink>, std::string> open(const std::string& device,
                                                                    double calibration,
                                                                    const WorkerSettings& worker);
    /// Ends after the frame that is on the line.
    ~SpiLink() override = default;

    /// Nothing arrives.
    ReadStatus read(Reception& reception) override;
    /// Takes the records of one frame (core/edge_records.h). Records without an edge withdraw a
    /// frame that waits. `busy`: the thread is taking the frame before, or dropped it because it
    /// was too old; `unavailable` while the kernel refuses frames or does not send them, or the
    /// thread gets no processor time; `lost` when the device is gone.
    WriteStatus write(std::span<const std::uint8_t> frame) override {
        return write_asked(frame, worker_.life_from_now());
    }
    WriteStatus write_asked(std::span<const std::uint8_t> frame, FrameLife life) override;
    bool stands(Instant now) const override { return worker_.stands(now); }
    void discard_unread() override {}
    int descriptor() const override { return -1; }

  private:
    SpiLink(UniqueFd port, double calibration);
    bool keep_frame(std::span<const std::uint8_t> frame, FrameLife life);
    bool take_frame(Instant& valid_until);
    WriteStatus send_newest();

    static constexpr std::size_t kMostFrameBytes = 96;

    UniqueFd port_;
    double calibration_;
    std::mutex mutex_;  ///< the data thread only tries it
    std::array<std::uint8_t, kMostFrameBytes> waiting_{};
    std::size_t waiting_bytes_ = 0;
    Instant waiting_until_{};
    WriteStatus outcome_ = WriteStatus::written;  ///< of the thread
    Waveform waveform_;                           ///< of the thread
    LinkWorker worker_;
};

}  // namespace tribus
