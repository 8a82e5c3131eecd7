#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/links/link.h"

namespace tribus {

/// Direction in which something passed a port.
enum class Direction : std::uint8_t { read, written };

/// Flags of a piece of a capture.
struct CaptureMarks {
    static constexpr std::uint8_t kWritten = 1;
    static constexpr std::uint8_t kCan = 2;
    static constexpr std::uint8_t kExtended = 4;
    static constexpr std::uint8_t kRemote = 8;
    static constexpr std::uint8_t kFd = 16;
    static constexpr std::uint8_t kBitRateSwitch = 32;
    static constexpr std::uint8_t kErrorState = 64;
    /// Continues the piece before: the same read, write or frame.
    static constexpr std::uint8_t kContinued = 128;
};

/// A piece of what passed a port. One frame of i.Bus, SBUS or classic CAN fits into one. Trivially
/// copyable, the size of a cache line.
struct CapturePiece {
    static constexpr std::size_t kMostBytes = 40;

    std::int64_t at_ns = 0;     ///< time of the read or hand-over on kClock
    std::uint64_t damaged = 0;  ///< one bit for each byte with a parity or framing error
    std::uint32_t can_id = 0;
    std::uint8_t marks = 0;
    std::uint8_t count = 0;  ///< remote frame: the length that it requests
    std::uint16_t unused = 0;
    std::array<std::uint8_t, kMostBytes> bytes{};

    Instant at() const { return Instant(Duration(at_ns)); }
    bool has(std::uint8_t mark) const { return (marks & mark) != 0; }
    Direction direction() const {
        return has(CaptureMarks::kWritten) ? Direction::written : Direction::read;
    }
    std::span<const std::uint8_t> data() const { return {bytes.data(), count}; }
};
static_assert(sizeof(CapturePiece) == 64);

/// The latest pieces of what passed one port; the newest one replaces the oldest. The data thread
/// writes without waiting. Another thread may read at the same time and never sees a partly
/// overwritten piece. All of it lies in the given memory: if that outlives the process, it shows
/// what happened last. Pure.
class CaptureRing {
  public:
    /// Size of the memory for this number of pieces. One of them is always being written.
    static constexpr std::size_t bytes_for(std::size_t pieces) {
        return sizeof(Header) + pieces * sizeof(CapturePiece);
    }
    static constexpr std::size_t kLeastBytes = 64 + 16 * sizeof(CapturePiece);

    /// Creates an empty ring. `memory` is aligned to 64 bytes, has at least kLeastBytes and
    /// outlives it.
    static CaptureRing create(std::span<std::byte> memory);
    /// The ring that another process left in `memory`. `nullopt` if there is none. Its pieces may
    /// be damaged: see `can_be_recorded`.
    static std::optional<CaptureRing> adopt(std::span<std::byte> memory);

    /// Records the bytes of one read, with their damage. Data thread.
    void record(const Reception& reception, Instant at);
    /// Records the bytes of one write. Data thread.
    void record(std::span<const std::uint8_t> written, Instant at);
    /// Records one CAN frame. Data thread.
    void record(Direction direction, const CanFrame& frame, Instant at);

    /// Number of the next piece, counted from the creation of the ring. Thread-safe, as all below.
    std::uint64_t end() const;
    /// Number of the oldest piece that can be read.
    std::uint64_t begin() const;
    struct Batch {
        std::uint64_t first = 0;  ///< number of the first piece
        std::size_t count = 0;    ///< 0: there is none yet
    };
    /// Copies whole pieces from number `from` on, or from the oldest one that is left.
    Batch read(std::uint64_t from, std::span<CapturePiece> pieces) const;

  private:
    /// Unit that the processor writes atomically. A piece consists of several, and `end` tells
    /// which pieces are whole.
    using Word = std::uintptr_t;
    static constexpr std::size_t kWords = sizeof(CapturePiece) / sizeof(Word);
    struct alignas(64) Header {
        std::uint64_t magic;
        std::uint64_t places;
        std::uint64_t end;
    };

    CaptureRing(Header* header, Word* words, std::size_t places, std::uint64_t end)
        : header_(header),
          words_(words),
          places_(places),
          end_(end),
          place_(static_cast<std::size_t>(end % places)) {}
    void put(const CapturePiece& piece);
    std::uint64_t begin_for(std::uint64_t end) const {
        return end < places_ ? 0 : end - places_ + 1;
    }

    Header* header_;
    Word* words_;
    std::size_t places_;
    /// Copies that only the writer uses.
    std::uint64_t end_;
    std::size_t place_;
};

/// Whether `record` can have written such a piece for that kind of port. A ring that another
/// process left may be damaged, so check each of its pieces before use.
bool can_be_recorded(const CapturePiece& piece, bool can);

/// The CAN frame that starts with this piece, with the bytes of this piece. Requires
/// `can_be_recorded`.
CanFrame can_frame_of(const CapturePiece& piece);

}  // namespace tribus
