#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/streams.h"
#include "transports/codecs/codec.h"

/// A fast decoder and its plain form read the same line. Any difference that a caller can see is an
/// error.
namespace tribus::reference {

/// One byte of a line. `value` counts only if the byte is not damaged.
struct LineByte {
    std::uint8_t value = 0;
    bool damaged = false;
};

inline std::vector<LineByte> on_a_line(std::span<const std::uint8_t> bytes) {
    std::vector<LineByte> line;
    for (const std::uint8_t byte : bytes) {
        line.push_back({byte, false});
    }
    return line;
}

/// A line with `bytes` that loses, damages and changes some of them, and adds some of `telling`.
inline std::vector<LineByte> with_random_faults(std::span<const std::uint8_t> bytes,
                                                std::span<const std::uint8_t> telling,
                                                test::Random& random) {
    std::vector<LineByte> line;
    const std::uint32_t rarity = 5 + random.below(100);
    for (const std::uint8_t byte : bytes) {
        switch (random.below(4 * rarity)) {
            case 0:
                break;
            case 1:
                line.push_back(
                    {telling[random.below(static_cast<std::uint32_t>(telling.size()))], false});
                line.push_back({byte, false});
                break;
            case 2:
                line.push_back({static_cast<std::uint8_t>(byte ^ 1U << random.below(8)), false});
                break;
            case 3:
                line.push_back({byte, true});
                break;
            default:
                line.push_back({byte, false});
                break;
        }
    }
    return line;
}

/// Ascending positions, near each other or far apart.
inline std::vector<std::size_t> random_cuts(test::Random& random, std::size_t length) {
    std::vector<std::size_t> cuts;
    const std::uint32_t longest = 1 + random.below(1U << random.below(9));
    for (std::size_t at = random.below(longest); at < length; at += 1 + random.below(longest)) {
        cuts.push_back(at);
    }
    return cuts;
}

template <class Quick, class Plain>
class SideBySide {
  public:
    template <class Option>
    explicit SideBySide(Option option) : quick_(option), plain_(option) {}

    /// Reads undamaged bytes in one call.
    void read(std::span<const std::uint8_t> bytes) {
        const Instant received(Duration(++reads_));
        std::span<const std::uint8_t> rest = bytes;
        std::span<const std::uint8_t> plain_rest = bytes;
        DecodedFrame frame = left_over();
        while (quick_.next(rest, received, frame)) {
            compare(frame, plain_.next(plain_rest, received));
            frame = left_over();
        }
        if (plain_.next(plain_rest, received)) {
            differs("a frame is missing");
        }
        if (!rest.empty()) {
            differs("bytes are left");
        }
        compare_counts();
    }

    void damaged_byte() {
        quick_.damaged_byte();
        plain_.damaged_byte();
    }

    /// Cuts the line at the ascending positions in `ends` and at damaged bytes.
    void read(std::span<const LineByte> line, std::span<const std::size_t> ends) {
        std::vector<std::uint8_t> piece;
        std::size_t cut = 0;
        for (std::size_t at = 0; at < line.size(); ++at) {
            if (line[at].damaged) {
                read(piece);
                piece.clear();
                damaged_byte();
                read({});
            } else {
                piece.push_back(line[at].value);
            }
            while (cut < ends.size() && ends[cut] <= at) {
                read(piece);
                piece.clear();
                ++cut;
            }
        }
        read(piece);
    }

    /// Tells both decoders that the line pauses.
    void silence() {
        DecodedFrame frame = left_over();
        while (quick_.silence(frame)) {
            frame.channels.received = Instant{};
            compare(frame, plain_.silence());
            frame = left_over();
        }
        if (plain_.silence()) {
            differs("a frame is missing before a pause");
        }
        compare_counts();
    }

    /// Resets both decoders, as when the line is taken away.
    void reset() {
        quick_.reset();
        plain_.reset();
        compare_counts();
    }

    /// Reads the line in pieces, with a pause or a reset after each.
    void read_with_pauses(std::span<const LineByte> line, std::span<const std::size_t> ends,
                          test::Random& random) {
        std::size_t begin = 0;
        while (begin < line.size()) {
            const std::size_t length =
                std::min<std::size_t>(1 + random.below(120), line.size() - begin);
            const std::size_t whole = random.below(3) == 0 ? 25 : length;
            const std::size_t taken = std::min(whole, line.size() - begin);
            read(line.subspan(begin, taken), ends);
            begin += taken;
            random.below(12) == 0 ? reset() : silence();
        }
    }

    void finish() {
        for (int count = 0; count < 10; ++count) {
            const auto frame = quick_.finish();
            const auto plain = plain_.finish();
            if (frame.has_value() != plain.has_value()) {
                differs("only one of them finishes a frame");
            }
            if (!frame || !plain) {
                break;
            }
            compare(*frame, plain);
        }
        compare_counts();
    }

    /// Describes the first difference; empty while the decoders agree.
    const std::string& difference() const { return difference_; }
    std::size_t frames() const { return frames_; }

  private:
    /// A frame full of old values, none of which may remain after decoding.
    static DecodedFrame left_over() {
        DecodedFrame frame{.first_byte = 12345, .length = 7};
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            frame.channels.set(channel, Pulse::from_microseconds(777));
        }
        frame.channels.source = 3;
        frame.channels.sequence = 99;
        frame.channels.link_quality = 50;
        return frame;
    }

    void differs(const std::string& how) {
        if (difference_.empty()) {
            difference_ = "read " + std::to_string(reads_) + ": " + how;
        }
    }

    void compare(const DecodedFrame& frame, const std::optional<DecodedFrame>& plain) {
        ++frames_;
        if (!plain) {
            differs("a frame too many at byte " + std::to_string(frame.first_byte));
            return;
        }
        const ChannelFrame& a = frame.channels;
        const ChannelFrame& b = plain->channels;
        if (frame.first_byte != plain->first_byte || frame.length != plain->length) {
            differs("frames at " + std::to_string(frame.first_byte) + " and " +
                    std::to_string(plain->first_byte));
        }
        if (!a.same_content(b) || a.source != b.source || a.origin != b.origin ||
            a.link_quality != b.link_quality || a.sequence != b.sequence ||
            a.received != b.received) {
            differs("other content at byte " + std::to_string(frame.first_byte));
        }
        const auto details = quick_.details();
        const auto plain_details = plain_details_of(plain_);
        for (std::size_t i = 0; i < details.size(); ++i) {
            if (!std::ranges::equal(details[i].values, plain_details[i].values)) {
                differs("other details at byte " + std::to_string(frame.first_byte));
            }
        }
    }

    static std::span<const FrameDetail> plain_details_of(const Plain& plain) {
        if constexpr (requires { plain.details(); }) {
            return plain.details();
        }
        return {};
    }

    void compare_counts() {
        if (quick_.skipped_bytes() != plain_.skipped_bytes()) {
            differs(std::to_string(quick_.skipped_bytes()) + " bytes skipped instead of " +
                    std::to_string(plain_.skipped_bytes()));
        }
        const auto counts = quick_.rejected();
        const auto plain_counts = plain_.rejected();
        for (std::size_t i = 0; i < counts.size(); ++i) {
            if (counts[i].count != plain_counts[i].count) {
                differs(std::string(counts[i].name) + " counted " +
                        std::to_string(counts[i].count) + " times instead of " +
                        std::to_string(plain_counts[i].count));
            }
        }
    }

    Quick quick_;
    Plain plain_;
    std::int64_t reads_ = 0;
    std::size_t frames_ = 0;
    std::string difference_;
};

/// Both decoders, which `both_of` makes for a seed, read the same on random lines, which `line_of`
/// makes, however these are cut into reads.
template <class MakeBoth, class MakeLine>
void expect_the_same_on_any_line_cut_anywhere(const MakeBoth& both_of, const MakeLine& line_of) {
    std::size_t frames = 0;
    for (std::uint32_t seed = 1; seed <= 4000; ++seed) {
        test::Random random(seed);
        const auto line = line_of(random, 1500);
        auto both = both_of(seed);
        both.read(line, random_cuts(random, line.size()));
        both.finish();
        ASSERT_EQ(both.difference(), "") << "seed " << seed;
        frames += both.frames();
    }
    EXPECT_GT(frames, 10000U);
}

/// The same with pauses and resets anywhere.
template <class MakeBoth, class MakeLine>
void expect_the_same_with_pauses_anywhere(const MakeBoth& both_of, const MakeLine& line_of) {
    std::size_t frames = 0;
    for (std::uint32_t seed = 1; seed <= 4000; ++seed) {
        test::Random random(seed);
        const auto line = line_of(random, 1500);
        auto both = both_of(seed);
        both.read_with_pauses(line, random_cuts(random, 60), random);
        both.finish();
        ASSERT_EQ(both.difference(), "") << "seed " << seed;
        frames += both.frames();
    }
    EXPECT_GT(frames, 10000U);
}

/// The same on lines of a few of the bytes in `telling`, some of them damaged.
template <class MakeBoth>
void expect_the_same_on_telling_bytes(const MakeBoth& both_of,
                                      std::span<const std::uint8_t> telling) {
    for (std::uint32_t seed = 1; seed <= 3000; ++seed) {
        test::Random random(seed);
        std::vector<LineByte> line(1000);
        const std::uint32_t kinds = 1 + random.below(static_cast<std::uint32_t>(telling.size()));
        for (LineByte& byte : line) {
            byte = {telling[random.below(kinds)], random.below(60) == 0};
        }
        auto both = both_of(seed);
        both.read(line, random_cuts(random, line.size()));
        both.finish();
        ASSERT_EQ(both.difference(), "") << "seed " << seed;
    }
}

}  // namespace tribus::reference
