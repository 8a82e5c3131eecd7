#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// Most bytes that one wake takes from one link: 22 ms of an i.Bus line at full speed. What is
/// left is read at the next wake, so one flooded port cannot hold up the others.
inline constexpr std::size_t kBytesPerWake = 256;

/// What one read brought. `damaged` marks the bytes that had a parity or framing error; their
/// value means nothing.
struct Reception {
    std::array<std::uint8_t, kBytesPerWake> bytes{};
    std::size_t count = 0;
    std::bitset<kBytesPerWake> damaged{};

    std::span<const std::uint8_t> view() const { return {bytes.data(), count}; }
};

enum class ReadStatus : std::uint8_t {
    received,  ///< at least one byte
    nothing,   ///< none there now
    lost,      ///< the device is gone; it stays lost until it is opened again
};

enum class WriteStatus : std::uint8_t {
    written,  ///< the whole frame is with the kernel, whose queue was empty before
    busy,     ///< not written, or not wholly: the frame is dropped, a newer one follows
    lost,     ///< the device is gone
};

/// A way for bytes in and out that knows nothing of protocols. Never blocks, never throws, never
/// retries in a loop. Thread-bound: one thread at a time.
class Link {
  public:
    virtual ~Link() = default;
    virtual ReadStatus read(Reception& reception) = 0;
    virtual WriteStatus write(std::span<const std::uint8_t> frame) = 0;
    /// For epoll; -1 where there is none.
    virtual int descriptor() const = 0;
};

}  // namespace tribus
