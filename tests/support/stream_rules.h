#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "tests/support/streams.h"

/// Rules for decoders of framed bytes. Each tries new decoders, which `make` returns, on reads of
/// any length and of single bytes.
namespace tribus::test {

using MakeDecoder = std::function<std::unique_ptr<ByteDecoder>()>;

template <class Decoder>
std::unique_ptr<ByteDecoder> make() {
    return std::make_unique<Decoder>();
}

/// `frame` with one bit changed is no frame, and does not keep the decoder from reading `next`
/// behind it.
void expect_each_flipped_bit_is_refused(const MakeDecoder& make,
                                        std::span<const std::uint8_t> frame,
                                        std::span<const std::uint8_t> next);

/// `next` is found behind the first bytes of `frame`, however many they are, and is the only one.
void expect_a_frame_behind_every_cut_one(const MakeDecoder& make,
                                         std::span<const std::uint8_t> frame,
                                         std::span<const std::uint8_t> next);

/// A pause anywhere in `frame` ends it: its two parts are no frame. `next` is one.
void expect_a_pause_ends_a_frame(const MakeDecoder& make, std::span<const std::uint8_t> frame,
                                 std::span<const std::uint8_t> next);

/// `bytes` contain `count` frames, the same ones however the bytes are cut into reads.
void expect_the_same_however_cut(const MakeDecoder& make, std::span<const std::uint8_t> bytes,
                                 std::size_t count);

/// Calls `check` with each fault of one byte anywhere in the stream, and ways to cut it into reads.
/// A byte that is added, or that replaces another one, has each of `values`.
void for_each_fault(const FrameStream& stream, std::span<const std::uint8_t> values,
                    const std::function<void(const Fault&, Split)>& check);

/// After each of these faults every frame that begins behind it is found once, in its place.
void expect_every_frame_behind_a_fault(const MakeDecoder& make, const FrameStream& stream,
                                       std::span<const std::uint8_t> values);

}  // namespace tribus::test
