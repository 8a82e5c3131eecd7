#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/links/link.h"

namespace tribus {

/// A link whose far side is the caller: for simulation and tests. No descriptor and no heap.
class MemoryLink : public ByteLink {
  public:
    /// Bytes that may stand in each direction: as much as a terminal's input buffer holds.
    static constexpr std::size_t kCapacity = 4096;

    ReadStatus read(Reception& reception) override;
    /// Busy where `kCapacity` would be exceeded: the far side has not cleared what was written.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override { waiting_ = 0; }
    int descriptor() const override { return -1; }

    /// The far side sends. Returns how many bytes were taken: none while the link is lost; what
    /// does not fit is gone, as in an overrun.
    std::size_t send(std::span<const std::uint8_t> bytes);
    /// As `send`, with the marks of parity or framing errors.
    std::size_t send(const Reception& bytes);
    /// One byte with a parity or framing error.
    bool send_damaged(std::uint8_t byte);

    /// What was written since the last `clear_written`, and in how many frames.
    std::span<const std::uint8_t> written() const { return {written_.data(), written_count_}; }
    std::size_t frames_written() const { return frames_written_; }
    void clear_written();

    /// While busy, every write is refused.
    void set_busy(bool busy) { busy_ = busy; }
    /// The device vanishes, with all bytes that were not read, or is back.
    void set_lost(bool lost);

  private:
    bool push(std::uint8_t byte, bool damaged);

    std::array<std::uint8_t, kCapacity> sent_{};
    std::bitset<kCapacity> damaged_{};
    std::size_t first_ = 0;
    std::size_t waiting_ = 0;
    std::array<std::uint8_t, kCapacity> written_{};
    std::size_t written_count_ = 0;
    std::size_t frames_written_ = 0;
    bool busy_ = false;
    bool lost_ = false;
};

}  // namespace tribus
