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

/// Which way something passed a port.
enum class Passage : std::uint8_t { read, written };

/// What one piece of a capture says beside its bytes.
struct CaptureMarks {
    static constexpr std::uint8_t kWritten = 1;
    static constexpr std::uint8_t kCan = 2;
    static constexpr std::uint8_t kExtended = 4;
    static constexpr std::uint8_t kRemote = 8;
    static constexpr std::uint8_t kFd = 16;
    static constexpr std::uint8_t kBitRateSwitch = 32;
    static constexpr std::uint8_t kErrorState = 64;
    /// It goes on with what the piece before began: the same read, write or frame.
    static constexpr std::uint8_t kContinued = 128;
};

/// A piece of what passed a port: one frame of i.Bus, SBUS or classic CAN fits into one. Trivially
/// copyable, as large as a line of the cache.
struct CapturePiece {
    static constexpr std::size_t kMostBytes = 40;

    std::int64_t at_ns = 0;     ///< when it was read or handed over, on the clock of the program
    std::uint64_t damaged = 0;  ///< a bit for each byte that came with a parity or framing error
    std::uint32_t can_id = 0;
    std::uint8_t marks = 0;
    std::uint8_t count = 0;  ///< of a remote frame: the length that it asks for
    std::uint16_t unused = 0;
    std::array<std::uint8_t, kMostBytes> bytes{};

    Instant at() const { return Instant(Duration(at_ns)); }
    bool has(std::uint8_t mark) const { return (marks & mark) != 0; }
    Passage passage() const {
        return has(CaptureMarks::kWritten) ? Passage::written : Passage::read;
    }
    std::span<const std::uint8_t> data() const { return {bytes.data(), count}; }
};
static_assert(sizeof(CapturePiece) == 64);

/// The latest pieces of what passed one port, the newest in the place of the oldest. The data
/// thread writes, wait-free; another thread reads at the same time and never sees a piece that is
/// half overwritten. All of it is in the memory that it is given, so that memory which outlives the
/// process tells what happened last, wherever the process ended. Pure.
class CaptureRing {
  public:
    /// Memory for so many pieces, one of which is always being written.
    static constexpr std::size_t bytes_for(std::size_t pieces) {
        return sizeof(Header) + pieces * sizeof(CapturePiece);
    }
    static constexpr std::size_t kLeastBytes = 64 + 16 * sizeof(CapturePiece);

    /// An empty ring. The memory is aligned to 64 bytes, has at least kLeastBytes, and outlives it.
    static CaptureRing create(std::span<std::byte> memory);
    /// The ring that another process left in this memory; nothing where there is none. Its pieces
    /// may be anything: see `can_be_recorded`.
    static std::optional<CaptureRing> adopt(std::span<std::byte> memory);

    /// What was read at once, with its damage. Data thread.
    void record(const Reception& reception, Instant at);
    /// Bytes that were handed over at once. Data thread.
    void record(std::span<const std::uint8_t> written, Instant at);
    /// Data thread.
    void record(Passage passage, const CanFrame& frame, Instant at);

    /// Pieces since it was made: the number of the next one. Thread-safe, as all below.
    std::uint64_t end() const;
    /// The number of the oldest piece that can still be read.
    std::uint64_t begin() const;
    struct Batch {
        std::uint64_t first = 0;  ///< number of the first piece
        std::size_t count = 0;    ///< 0: there is none yet
    };
    /// Copies whole pieces from number `from` on, or from the oldest that is left.
    Batch read(std::uint64_t from, std::span<CapturePiece> pieces) const;

  private:
    /// Where 64 bits are two words, their halves may come apart: whole pieces are counted.
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
    /// The writer's own.
    std::uint64_t end_;
    std::size_t place_;
};

/// Whether `record` can have written such a piece of a port of that kind. What another process left
/// may be damaged: no piece of it is used before it was asked for.
bool can_be_recorded(const CapturePiece& piece, bool can);

/// The CAN frame that begins with this piece, with as many bytes as are in it. Of a piece that can
/// be recorded.
CanFrame can_frame_of(const CapturePiece& piece);

}  // namespace tribus
