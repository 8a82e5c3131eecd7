#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include <tl/expected.hpp>

#include "core/line_settings.h"
#include "transports/links/link.h"
#include "transports/links/link_worker.h"
#include "transports/links/spi/sampling_plan.h"
#include "transports/links/spi/spi_pace.h"
#include "transports/links/spi/uart_sampler.h"
#include "transports/links/spi/waveform.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// Hears a serial line with the data line into an SPI port (MISO), inverted or not, without an
/// inverter. The port takes samples all the time, in blocks that end in the pauses of the sender
/// (sampling_plan.h), on a thread of the link. Each read has the bytes of one burst, with the time
/// of its samples. Reading neither waits nor uses the heap. Thread-bound.
class SpiListener final : public ByteLink {
  public:
    /// As `open_spi_port`.
    static tl::expected<std::unique_ptr<SpiListener>, std::string> open(
        const std::string& device, const LineSettings& line, const WorkerSettings& worker);
    /// Ends after the block that is taken (41 ms at most), or after the port is measured (0.6 s).
    ~SpiListener() override;

    ReadStatus read(Reception& reception) override;
    /// Nothing can be sent.
    WriteStatus write(std::span<const std::uint8_t> /*frame*/) override {
        return WriteStatus::unavailable;
    }
    bool has_unread() const override { return taken_.load() != added_.load() || lost_.load(); }
    void discard_unread() override { taken_.store(added_.load()); }
    bool stands(Instant now) const override;
    int descriptor() const override { return arrived_.get(); }

  private:
    struct HeardByte {
        Instant end{};
        std::uint8_t value = 0;
        bool damaged = false;
        bool ends_burst = false;
    };

    SpiListener(SpiPace pace, const LineSettings& line, const WorkerSettings& worker);
    std::string start();
    void run();
    void take_block();
    void hand_over(Instant begin, Instant end, bool in_time);
    void add(std::span<const SampledByte> burst, Instant begin, Instant at_the_latest);
    void tell_plan(std::span<const SampledByte> burst, Instant begin, bool cut);
    void refused(int error);
    void lose();
    void note_progress();
    Instant time_of(Instant begin, std::size_t sample) const;
    void wait_for_the_port();
    void announce();

    /// Forty frames of SBUS: more than a data thread that runs leaves unread.
    static constexpr std::size_t kMostUnread = 1024;

    SpiPace pace_;  ///< of the thread
    UniqueFd arrived_;
    UniqueFd end_;
    LineSettings line_;
    WorkerSettings worker_;
    Duration bit_;
    std::atomic<bool> ends_ = false;
    std::atomic<bool> lost_ = false;
    std::atomic<bool> in_kernel_ = false;
    std::atomic<std::int64_t> progress_ns_ = 0;
    /// Counts of bytes; the thread adds, the owner takes.
    std::atomic<std::size_t> added_ = 0;
    std::atomic<std::size_t> taken_ = 0;
    std::array<HeardByte, kMostUnread> heard_{};
    /// Of the thread.
    SamplingPlan plan_;
    std::array<std::uint8_t, kMostWaveformBytes> samples_{};
    SampledBlock block_;
    std::thread thread_;
};

}  // namespace tribus
