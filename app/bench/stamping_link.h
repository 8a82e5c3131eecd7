#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/time.h"
#include "pipelines/engine/output.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/link.h"

namespace tribus::bench {

/// A link that accepts every frame and records its time and first bytes. Allocates only in its
/// constructor. Thread-bound; the stamps may be read when the writing thread has ended.
class StampingLink final : public ByteLink {
  public:
    struct Stamp {
        Instant at{};
        std::uint64_t beginning = 0;  ///< first eight bytes of the frame
        Instant due_next{};           ///< the output's next deadline
    };
    /// Records frames of `output`, at most `most`.
    StampingLink(const Output& output, std::vector<Stamp>& stamps, std::size_t most)
        : output_(output), stamps_(stamps), most_(most) {
        stamps_.reserve(most);
    }
    ReadStatus read(Reception&) override { return ReadStatus::nothing; }
    WriteStatus write(std::span<const std::uint8_t> frame) override {
        if (stamps_.size() < most_) {
            const Instant now = monotonic_now();
            stamps_.push_back({now, beginning_of(frame), output_.due()});
        }
        return WriteStatus::written;
    }
    void discard_unread() override {}
    int descriptor() const override { return -1; }

    /// The first eight bytes as a number, the first one lowest.
    static std::uint64_t beginning_of(std::span<const std::uint8_t> frame) {
        std::uint64_t beginning = 0;
        for (std::size_t i = 0; i < sizeof beginning && i < frame.size(); ++i) {
            beginning |= std::uint64_t{frame[i]} << (8 * i);
        }
        return beginning;
    }

  private:
    const Output& output_;
    std::vector<Stamp>& stamps_;
    std::size_t most_;
};

}  // namespace tribus::bench
