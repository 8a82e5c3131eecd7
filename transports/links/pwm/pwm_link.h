#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/link.h"
#include "transports/links/link_worker.h"
#include "transports/links/pwm/pwm_chip.h"

namespace tribus {

/// The outputs of a PWM chip. A chip on I2C takes a millisecond for some pulses, so a thread of the
/// link hands them to the kernel; it takes the newest only. No heap in `write`. Thread-bound.
class PwmLink final : public ByteLink {
  public:
    /// `period`: of the pulses. The error begins with the chip and says what to do.
    static tl::expected<std::unique_ptr<PwmLink>, std::string> open(
        const std::string& chip, Duration period, const WorkerSettings& worker,
        const std::filesystem::path& root = "/");
    /// Switches all outputs off. May block.
    ~PwmLink() override = default;

    /// Nothing arrives.
    ReadStatus read(Reception& reception) override;
    /// Takes records of core/pwm_pulses.h. `unavailable` while the kernel refuses them, the chip's
    /// bus hangs or the thread gets no processor time; `busy` after pulses that were dropped
    /// because they were too old; `lost` when the chip is gone.
    WriteStatus write(std::span<const std::uint8_t> frame) override {
        return write_asked(frame, worker_.life_from_now());
    }
    WriteStatus write_asked(std::span<const std::uint8_t> frame, FrameLife life) override;
    bool stands(Instant now) const override { return worker_.stands(now); }
    void discard_unread() override {}
    int descriptor() const override { return -1; }

  private:
    PwmLink(PwmChipFacts chip, Duration period);
    WriteStatus hand_on();
    WriteStatus hand_on(std::size_t output, Instant valid_until);

    /// No pulse was ever asked for.
    static constexpr std::uint32_t kNothing = 0xFFFFFFFF;

    PwmChipFacts chip_;
    std::array<std::atomic<std::uint32_t>, PwmOutputs::kMost> wanted_;
    PwmOutputs outputs_;  ///< of the thread
    LinkWorker worker_;
};

}  // namespace tribus
