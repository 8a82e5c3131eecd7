#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/time.h"
#include "transports/codecs/codec.h"

/// Streams of bytes for a decoder: how they are cut into reads, and faults in them.
namespace tribus::test {

using Bytes = std::vector<std::uint8_t>;

/// Converts text like "0f e0 03": two hexadecimal digits a byte, blanks anywhere between bytes.
inline Bytes from_hex(std::string_view text) {
    Bytes bytes;
    for (std::size_t at = 0; at + 1 < text.size();) {
        if (text[at] == ' ' || text[at] == '\n') {
            ++at;
            continue;
        }
        bytes.push_back(
            static_cast<std::uint8_t>(std::stoul(std::string(text.substr(at, 2)), nullptr, 16)));
        at += 2;
    }
    return bytes;
}

inline void append(Bytes& bytes, std::span<const std::uint8_t> more) {
    std::copy(more.begin(), more.end(), std::back_inserter(bytes));
}

/// A small, fast random generator (xorshift32) with the same sequence on every machine.
class Random {
  public:
    explicit Random(std::uint32_t seed) : state_(seed * 2654435761U | 1U) {}
    std::uint32_t operator()() {
        state_ ^= state_ << 13U;
        state_ ^= state_ >> 17U;
        state_ ^= state_ << 5U;
        return state_;
    }
    std::uint32_t below(std::uint32_t limit) { return (*this)() % limit; }
    std::uint8_t byte() { return static_cast<std::uint8_t>((*this)() >> 8U); }

  private:
    std::uint32_t state_;
};

/// How a stream is cut into reads: pieces of `longest` bytes, or of random length up to `longest`.
struct Split {
    std::size_t longest = SIZE_MAX;
    std::uint32_t seed = 0;  ///< 0: every piece is as long as allowed
};
inline constexpr Split kOneRead{};
inline constexpr Split kByteByByte{.longest = 1};

enum class FaultKind : std::uint8_t { none, lost, added, replaced, damaged };

/// A fault at one place of a line. `damaged` is a byte with a parity or framing error.
struct Fault {
    FaultKind kind = FaultKind::none;
    std::size_t position = 0;
    std::uint8_t value = 0;
};

inline std::ostream& operator<<(std::ostream& out, const Fault& fault) {
    constexpr std::string_view kNames[] = {"no fault", "lost", "added", "replaced", "damaged"};
    return out << kNames[static_cast<std::size_t>(fault.kind)] << " at " << fault.position
               << ", value " << static_cast<int>(fault.value);
}

inline Bytes with_fault(Bytes bytes, const Fault& fault) {
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(fault.position);
    switch (fault.kind) {
        case FaultKind::lost:
            bytes.erase(place);
            break;
        case FaultKind::added:
            bytes.insert(place, fault.value);
            break;
        case FaultKind::replaced:
            *place = fault.value;
            break;
        case FaultKind::damaged:
        case FaultKind::none:
            break;
    }
    return bytes;
}

/// Gives `bytes` to the decoder and collects the frames.
inline void feed_into(std::vector<DecodedFrame>& frames, ByteDecoder& decoder,
                      std::span<const std::uint8_t> bytes, Split split = kOneRead,
                      Instant received = {}) {
    Random random(split.seed);
    while (!bytes.empty()) {
        const std::size_t wanted =
            split.seed == 0 ? split.longest
                            : 1 + random.below(static_cast<std::uint32_t>(split.longest));
        std::span<const std::uint8_t> piece = bytes.first(std::min(wanted, bytes.size()));
        bytes = bytes.subspan(piece.size());
        DecodedFrame frame;
        while (decoder.next(piece, received, frame)) {
            frames.push_back(frame);
        }
        if (!piece.empty()) {
            ADD_FAILURE() << "the decoder returned nothing and left " << piece.size() << " bytes";
        }
    }
}

inline std::vector<DecodedFrame> feed(ByteDecoder& decoder, std::span<const std::uint8_t> bytes,
                                      Split split = kOneRead, Instant received = {}) {
    std::vector<DecodedFrame> frames;
    feed_into(frames, decoder, bytes, split, received);
    return frames;
}

/// Feeds the decoder over a line with a fault.
inline std::vector<DecodedFrame> feed(ByteDecoder& decoder, const Bytes& bytes, const Fault& fault,
                                      Split split) {
    if (fault.kind != FaultKind::damaged) {
        return feed(decoder, with_fault(bytes, fault), split);
    }
    const auto all = std::span<const std::uint8_t>(bytes);
    std::vector<DecodedFrame> frames;
    feed_into(frames, decoder, all.first(fault.position), split);
    decoder.damaged_byte();
    feed_into(frames, decoder, all.subspan(fault.position + 1), split);
    return frames;
}

/// The frames in `bytes`, also those that the decoder holds back until the pause behind them.
inline std::vector<DecodedFrame> all_frames(ByteDecoder& decoder,
                                            std::span<const std::uint8_t> bytes,
                                            Split split = kOneRead, const Fault& fault = {}) {
    auto frames = feed(decoder, Bytes(bytes.begin(), bytes.end()), fault, split);
    for (DecodedFrame late; decoder.silence(late);) {
        frames.push_back(late);
    }
    return frames;
}

/// A decoder that gets each frame at its time.
template <class Decoder>
class HeardLine {
  public:
    static constexpr Instant kStart{std::chrono::hours(1)};

    /// Returns what the frame made, if anything.
    std::optional<ChannelFrame> hear(const Bytes& bytes, Duration at) {
        const auto frames = feed(decoder_, bytes, kOneRead, kStart + at);
        EXPECT_LE(frames.size(), 1U);
        return frames.empty() ? std::nullopt : std::optional(frames[0].channels);
    }
    Decoder& decoder() { return decoder_; }

  private:
    Decoder decoder_;
};

inline std::uint64_t count_of(const ByteDecoder& decoder, std::string_view cause) {
    for (const NamedCount& rejected : decoder.rejected()) {
        if (rejected.name == cause) {
            return rejected.count;
        }
    }
    ADD_FAILURE() << "no reject count is called " << cause;
    return 0;
}

inline bool same_frames(std::span<const DecodedFrame> one, std::span<const DecodedFrame> other) {
    return std::equal(one.begin(), one.end(), other.begin(), other.end(),
                      [](const DecodedFrame& a, const DecodedFrame& b) {
                          return a.first_byte == b.first_byte && a.length == b.length &&
                                 a.channels.same_content(b.channels);
                      });
}

/// Consecutive frames, possibly with other bytes between them, and the start of each frame.
struct FrameStream {
    Bytes bytes;
    std::vector<std::size_t> starts;

    void add_frame(std::span<const std::uint8_t> frame) {
        starts.push_back(bytes.size());
        append(bytes, frame);
    }
    void add_other(std::span<const std::uint8_t> other) { append(bytes, other); }
    /// Returns where frame `index` starts in the stream with the fault.
    std::size_t shifted_start(std::size_t index, const Fault& fault) const {
        std::size_t start = starts[index];
        if (fault.kind == FaultKind::added && start >= fault.position) {
            ++start;
        }
        if (fault.kind == FaultKind::lost && start > fault.position) {
            --start;
        }
        return start;
    }
};

/// Effect of one fault on a stream.
struct Damage {
    std::vector<std::size_t> missing;  ///< frames that did not come, or came with other content
    std::size_t invented = 0;          ///< frames at places where none was sent
};

/// Compares with `clean`, the frames of the same stream without the fault, one for each start.
inline Damage compare(const FrameStream& stream, const Fault& fault,
                      std::span<const DecodedFrame> clean, std::span<const DecodedFrame> decoded) {
    Damage damage;
    std::size_t at = 0;
    for (std::size_t index = 0; index < stream.starts.size(); ++index) {
        const std::size_t start = stream.shifted_start(index, fault);
        while (at < decoded.size() && decoded[at].first_byte < start) {
            ++damage.invented;
            ++at;
        }
        const bool here = at < decoded.size() && decoded[at].first_byte == start;
        if (!here || !decoded[at].channels.same_content(clean[index].channels)) {
            damage.missing.push_back(index);
        }
        at += here ? 1 : 0;
    }
    damage.invented += decoded.size() - at;
    return damage;
}

/// Feeds `bytes` in random pieces and damages some of the bytes. No frame may contain a damaged
/// byte.
inline void expect_no_frame_over_damage(ByteDecoder& decoder, const Bytes& bytes, Random& random,
                                        std::uint32_t longest_piece) {
    std::vector<DecodedFrame> frames;
    std::vector<bool> damaged(bytes.size());
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t piece =
            std::min<std::size_t>(random.below(longest_piece), bytes.size() - at);
        feed_into(frames, decoder, std::span(bytes).subspan(at, piece));
        at += piece;
        for (std::uint32_t count = random.below(3); count > 0 && at < bytes.size(); --count) {
            decoder.damaged_byte();
            damaged[at++] = true;
            std::span<const std::uint8_t> nothing;
            DecodedFrame frame;
            while (decoder.next(nothing, {}, frame)) {
                frames.push_back(frame);
            }
        }
    }
    for (const DecodedFrame& frame : frames) {
        for (std::uint64_t at = frame.first_byte; at < frame.first_byte + frame.length; ++at) {
            ASSERT_FALSE(damaged[static_cast<std::size_t>(at)]) << "byte " << at;
        }
    }
}

}  // namespace tribus::test
