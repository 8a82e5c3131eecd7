#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "transports/links/link.h"

namespace tribus {

/// A link whose other end is the caller, for simulation and tests. No descriptor and no heap.
/// Thread-bound.
class MemoryLink : public ByteLink {
  public:
    /// Capacity of each direction in bytes: that of a terminal's input buffer.
    static constexpr std::size_t kCapacity = 4096;

    ReadStatus read(Reception& reception) override;
    /// Busy if `kCapacity` would be exceeded because the other end has not cleared the written
    /// bytes.
    WriteStatus write(std::span<const std::uint8_t> frame) override;
    void discard_unread() override { waiting_ = 0; }
    int descriptor() const override { return -1; }

    /// The other end sends. Returns how many bytes were accepted: none while the link is lost;
    /// bytes without room are lost, as in an overrun.
    std::size_t send(std::span<const std::uint8_t> bytes);
    /// Like `send`, with marks of parity or framing errors.
    std::size_t send(const Reception& bytes);
    /// Sends one byte with a parity or framing error.
    bool send_damaged(std::uint8_t byte);

    /// Bytes and frames written since the latest `clear_written`.
    std::span<const std::uint8_t> written() const { return {written_.data(), written_count_}; }
    std::size_t frames_written() const { return frames_written_; }
    void clear_written();

    /// While busy, every write is refused.
    void set_busy(bool busy) { busy_ = busy; }
    /// Removes the device, with all unread bytes, or returns it.
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
