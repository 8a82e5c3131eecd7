#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "core/write_status.h"

namespace tribus {

/// Most bytes that one read takes from one link: 22 ms of an i.Bus line at full speed.
inline constexpr std::size_t kBytesPerRead = 256;

/// Result of one read. `damaged` marks the bytes with a parity or framing error; their values are
/// meaningless.
struct Reception {
    std::array<std::uint8_t, kBytesPerRead> bytes{};
    std::size_t count = 0;
    std::bitset<kBytesPerRead> damaged{};
    bool full = false;  ///< the read was full: more bytes may be waiting
    /// The next read goes on with the same datagram. Always false on media without datagrams.
    bool goes_on = false;
    /// When the last byte came, where the link knows it. `kNever`: now.
    Instant at = kNever;

    std::span<const std::uint8_t> view() const { return {bytes.data(), count}; }
};

enum class ReadStatus : std::uint8_t {
    received,  ///< at least one byte
    nothing,   ///< no bytes now
    lost,      ///< the device is gone; the link stays lost until it is opened again
};

/// When a frame was made, and how old it may be when the kernel takes it.
struct FrameLife {
    Instant made{};
    Duration valid_for = Duration::max();
};

class ByteLink;
class CanLink;

/// Carries bytes or CAN frames in both directions and knows nothing of protocols. Never blocks,
/// never throws, never retries in a loop. Thread-bound.
class Link {
  public:
    virtual ~Link() = default;
    /// For epoll; -1 if there is none.
    virtual int descriptor() const = 0;
    /// Another one, if a read is needed for another reason too; else -1.
    virtual int second_descriptor() const { return -1; }
    /// Whether each arrival wakes epoll anew, and a read that was not full took all that was there:
    /// then the descriptor needs no look at its state after each read (EPOLLET). At a terminal that
    /// look waits for the kernel's worker that hands over arriving bytes (n_tty_poll calls
    /// tty_buffer_flush_work), and a real-time thread has just taken the processor from it.
    virtual bool wakes_at_each_arrival() const { return false; }
    /// Whether a thread of the link gets no processor time, or has died, so what it is to hand over
    /// stays. A thread that the kernel keeps does not count.
    virtual bool stands(Instant /*now*/) const { return false; }
    /// This link as its kind; the other function returns null.
    virtual ByteLink* as_bytes() { return nullptr; }
    virtual CanLink* as_can() { return nullptr; }
};

/// For protocols that are a stream of bytes.
class ByteLink : public Link {
  public:
    /// Reads the waiting bytes, at most kBytesPerRead.
    virtual ReadStatus read(Reception& reception) = 0;
    /// Writes one frame completely or drops it.
    virtual WriteStatus write(std::span<const std::uint8_t> frame) = 0;
    /// `write` in two steps, so that the caller can read the clock in between: a thread that is
    /// stopped stops at the end of a system call. `ask` makes all system calls except that of
    /// `write_asked`. Call `write_asked` directly after `ask` returned `written`, or not at all. A
    /// link that hands frames over later, on a thread of its own, drops them when `life` is over.
    virtual WriteStatus ask() { return WriteStatus::written; }
    virtual WriteStatus write_asked(std::span<const std::uint8_t> frame, FrameLife /*life*/) {
        return write(frame);
    }
    /// Whether bytes wait, by a look that waits for nothing. A link that can only read says true.
    virtual bool has_unread() const { return true; }
    /// Discards all bytes that wait to be read.
    virtual void discard_unread() = 0;
    ByteLink* as_bytes() final { return this; }
};

}  // namespace tribus
