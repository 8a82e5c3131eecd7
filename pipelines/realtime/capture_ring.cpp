#include "pipelines/realtime/capture_ring.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <new>

namespace tribus {
namespace {

/// Change it with the layout, so that no version reads the ring of another one.
constexpr std::uint64_t kMagic = 0x3130'7370'6163'7274;

static_assert(std::atomic_ref<std::uint64_t>::is_always_lock_free);

}  // namespace

CaptureRing CaptureRing::create(std::span<std::byte> memory) {
    assert(memory.size() >= kLeastBytes);
    static_assert(std::atomic_ref<Word>::is_always_lock_free);
    auto* header = new (memory.data()) Header{};
    const std::size_t places = (memory.size() - sizeof(Header)) / sizeof(CapturePiece);
    auto* words = new (memory.data() + sizeof(Header)) Word[places * kWords]{};
    header->places = places;
    header->magic = kMagic;
    return {header, words, places, 0};
}

std::optional<CaptureRing> CaptureRing::adopt(std::span<std::byte> memory) {
    if (memory.size() < kLeastBytes) {
        return std::nullopt;
    }
    // The other process created objects of implicit-lifetime types there.
    auto* header = static_cast<Header*>(static_cast<void*>(memory.data()));
    const std::size_t places = (memory.size() - sizeof(Header)) / sizeof(CapturePiece);
    if (header->magic != kMagic || header->places != places) {
        return std::nullopt;
    }
    auto* words = static_cast<Word*>(static_cast<void*>(memory.data() + sizeof(Header)));
    return CaptureRing(header, words, places, header->end);
}

void CaptureRing::put(const CapturePiece& piece) {
    const auto words = std::bit_cast<std::array<Word, kWords>>(piece);
    Word* place = words_ + place_ * kWords;
    // Readers learn from `end_` that the old piece is lost before they can see a word of the new
    // one.
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < kWords; ++i) {
        std::atomic_ref(place[i]).store(words[i], std::memory_order_relaxed);
    }
    place_ = place_ + 1 == places_ ? 0 : place_ + 1;
    std::atomic_ref(header_->end).store(++end_, std::memory_order_release);
}

void CaptureRing::record(const Reception& reception, Instant at) {
    const bool clean = reception.damaged.none();
    CapturePiece piece;
    piece.at_ns = at.time_since_epoch().count();
    for (std::size_t start = 0; start < reception.count; start += CapturePiece::kMostBytes) {
        piece.count =
            static_cast<std::uint8_t>(std::min(CapturePiece::kMostBytes, reception.count - start));
        std::memcpy(piece.bytes.data(), reception.bytes.data() + start, piece.count);
        piece.damaged = 0;
        for (std::size_t i = 0; !clean && i < piece.count; ++i) {
            piece.damaged |= std::uint64_t{reception.damaged.test(start + i)} << i;
        }
        put(piece);
        piece.marks = CaptureMarks::kContinued;
    }
}

void CaptureRing::record(std::span<const std::uint8_t> written, Instant at) {
    CapturePiece piece;
    piece.at_ns = at.time_since_epoch().count();
    piece.marks = CaptureMarks::kWritten;
    while (!written.empty()) {
        const std::size_t count = std::min(CapturePiece::kMostBytes, written.size());
        piece.count = static_cast<std::uint8_t>(count);
        std::memcpy(piece.bytes.data(), written.data(), count);
        put(piece);
        written = written.subspan(count);
        piece.marks = CaptureMarks::kWritten | CaptureMarks::kContinued;
    }
}

void CaptureRing::record(Direction direction, const CanFrame& frame, Instant at) {
    using Marks = CaptureMarks;
    const auto mark = [](bool set, std::uint8_t bit) { return set ? bit : std::uint8_t{0}; };
    CapturePiece piece;
    piece.at_ns = at.time_since_epoch().count();
    piece.can_id = frame.id;
    piece.marks = static_cast<std::uint8_t>(
        Marks::kCan | mark(direction == Direction::written, Marks::kWritten) |
        mark(frame.extended, Marks::kExtended) | mark(frame.remote, Marks::kRemote) |
        mark(frame.fd, Marks::kFd) | mark(frame.bit_rate_switch, Marks::kBitRateSwitch) |
        mark(frame.error_state_indicator, Marks::kErrorState));
    const std::size_t first = std::min<std::size_t>(frame.length, CapturePiece::kMostBytes);
    piece.count = static_cast<std::uint8_t>(first);
    std::memcpy(piece.bytes.data(), frame.data.data(), first);
    put(piece);
    if (frame.length > first) {
        piece.marks |= Marks::kContinued;
        piece.count = static_cast<std::uint8_t>(frame.length - first);
        std::memcpy(piece.bytes.data(), frame.data.data() + first, piece.count);
        put(piece);
    }
}

std::uint64_t CaptureRing::end() const {
    return std::atomic_ref(header_->end).load(std::memory_order_acquire);
}

std::uint64_t CaptureRing::begin() const {
    return begin_for(end());
}

CaptureRing::Batch CaptureRing::read(std::uint64_t from, std::span<CapturePiece> pieces) const {
    const std::uint64_t last = end();
    const std::uint64_t first = std::max(from, begin_for(last));
    const std::size_t count =
        first >= last
            ? 0
            : static_cast<std::size_t>(std::min<std::uint64_t>(last - first, pieces.size()));
    for (std::size_t i = 0; i < count; ++i) {
        Word* place = words_ + static_cast<std::size_t>((first + i) % places_) * kWords;
        std::array<Word, kWords> words;
        for (std::size_t word = 0; word < kWords; ++word) {
            words[word] = std::atomic_ref(place[word]).load(std::memory_order_relaxed);
        }
        pieces[i] = std::bit_cast<CapturePiece>(words);
    }
    // Discard pieces that the writer has started to overwrite meanwhile.
    std::atomic_thread_fence(std::memory_order_acquire);
    const std::uint64_t whole =
        begin_for(std::atomic_ref(header_->end).load(std::memory_order_relaxed));
    if (whole <= first) {
        return {first, count};
    }
    const auto lost = static_cast<std::size_t>(std::min<std::uint64_t>(whole - first, count));
    std::copy(pieces.begin() + static_cast<std::ptrdiff_t>(lost),
              pieces.begin() + static_cast<std::ptrdiff_t>(count), pieces.begin());
    return {first + lost, count - lost};
}

bool can_be_recorded(const CapturePiece& piece, bool can) {
    constexpr std::uint8_t kCanOnly = CaptureMarks::kExtended | CaptureMarks::kRemote |
                                      CaptureMarks::kFd | CaptureMarks::kBitRateSwitch |
                                      CaptureMarks::kErrorState;
    constexpr std::uint8_t kFdOnly =
        CaptureMarks::kContinued | CaptureMarks::kBitRateSwitch | CaptureMarks::kErrorState;
    if (piece.at_ns < 0 || piece.count > CapturePiece::kMostBytes ||
        piece.has(CaptureMarks::kCan) != can) {
        return false;
    }
    if (!can) {
        return piece.count > 0 && !piece.has(kCanOnly);
    }
    const bool fd = piece.has(CaptureMarks::kFd);
    const std::uint32_t last_id =
        piece.has(CaptureMarks::kExtended) ? kMostExtendedId : kMostStandardId;
    return piece.can_id <= last_id && !(fd && piece.has(CaptureMarks::kRemote)) &&
           (fd || (piece.count <= kMostClassicBytes && !piece.has(kFdOnly)));
}

CanFrame can_frame_of(const CapturePiece& piece) {
    CanFrame frame;
    frame.id = piece.can_id;
    frame.extended = piece.has(CaptureMarks::kExtended);
    frame.remote = piece.has(CaptureMarks::kRemote);
    frame.fd = piece.has(CaptureMarks::kFd);
    frame.bit_rate_switch = piece.has(CaptureMarks::kBitRateSwitch);
    frame.error_state_indicator = piece.has(CaptureMarks::kErrorState);
    frame.length = piece.count;
    std::memcpy(frame.data.data(), piece.bytes.data(), piece.count);
    return frame;
}

}  // namespace tribus
