#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tribus {

/// Most bytes that one read takes from one link: 22 ms of an i.Bus line at full speed.
inline constexpr std::size_t kBytesPerRead = 256;

/// What one read brought. `damaged` marks the bytes that had a parity or framing error; their
/// value means nothing.
struct Reception {
    std::array<std::uint8_t, kBytesPerRead> bytes{};
    std::size_t count = 0;
    std::bitset<kBytesPerRead> damaged{};
    bool full = false;  ///< it took as much as one read takes: more may wait

    std::span<const std::uint8_t> view() const { return {bytes.data(), count}; }
};

enum class ReadStatus : std::uint8_t {
    received,  ///< at least one byte
    nothing,   ///< none there now
    lost,      ///< the device is gone; it stays lost until it is opened again
};

enum class WriteStatus : std::uint8_t {
    written,      ///< with the kernel, whose queue had nothing of this sender before
    busy,         ///< not written, or not wholly: dropped, something newer follows
    unavailable,  ///< the line takes nothing now (a bus is down or off): dropped; it may come back
    lost,         ///< the device is gone; it stays lost until it is opened again
};

class ByteLink;
class CanLink;

/// A way in and out that knows nothing of protocols. Never blocks, never throws, never retries in
/// a loop. Thread-bound: one thread at a time.
class Link {
  public:
    virtual ~Link() = default;
    /// For epoll; -1 where there is none.
    virtual int descriptor() const = 0;
    /// Its kind, the other one null.
    virtual ByteLink* as_bytes() { return nullptr; }
    virtual CanLink* as_can() { return nullptr; }
};

/// For protocols that are a stream of bytes.
class ByteLink : public Link {
  public:
    virtual ReadStatus read(Reception& reception) = 0;
    virtual WriteStatus write(std::span<const std::uint8_t> frame) = 0;
    /// The same in two steps, for a look at the clock between them: a thread that is stopped stops
    /// at the end of a call of the kernel. `ask` makes all calls but that of `write_asked`, which
    /// follows at once if `ask` returns `written`, or not at all.
    virtual WriteStatus ask() { return WriteStatus::written; }
    virtual WriteStatus write_asked(std::span<const std::uint8_t> frame) { return write(frame); }
    /// Throws away all that waits to be read.
    virtual void discard_unread() = 0;
    ByteLink* as_bytes() final { return this; }
};

}  // namespace tribus
