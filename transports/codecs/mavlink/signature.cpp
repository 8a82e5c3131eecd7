#include "transports/codecs/mavlink/signature.h"

#include <nettle/memops.h>

#include <algorithm>
#include <chrono>
#include <ratio>

namespace tribus {

using namespace mavlink_wire;

namespace {

/// From 1970 to 2015, when time stamps begin.
constexpr Duration kStampsBegin = std::chrono::seconds(1420070400);
using StampUnits = std::chrono::duration<std::int64_t, std::ratio<1, 100000>>;
/// A stream may begin with a message that is so old.
constexpr std::uint64_t kOldestBeginning = StampUnits(std::chrono::minutes(1)).count();

/// 0 before 2015.
std::uint64_t stamp_of(Duration since_2015) {
    const auto units = std::chrono::floor<StampUnits>(since_2015).count();
    return static_cast<std::uint64_t>(std::max<std::int64_t>(units, 0));
}

std::uint64_t stamp_in(std::span<const std::uint8_t> bytes) {
    std::uint64_t stamp = 0;
    for (std::size_t byte = 0; byte < kStampBytes; ++byte) {
        stamp |= std::uint64_t{bytes[byte]} << (8 * byte);
    }
    return stamp;
}

}  // namespace

MavlinkHash::MavlinkHash(const SecretKey& secret) {
    sha256_init(&begun_);
    sha256_update(&begun_, secret.size(), secret.data());
    // The first hash brings the library's code into memory, before frames flow.
    static_cast<void>(of(secret));
}

std::array<std::uint8_t, kHashBytes> MavlinkHash::of(
    std::span<const std::uint8_t> signed_part) const {
    sha256_ctx hash = begun_;
    sha256_update(&hash, signed_part.size(), signed_part.data());
    std::array<std::uint8_t, kHashBytes> first{};
    sha256_digest(&hash, first.size(), first.data());
    return first;
}

void MavlinkSigner::sign(std::span<std::uint8_t> wire, std::size_t length, Instant now) {
    const Duration at = clock_ != nullptr ? clock_->at(now) - kStampsBegin : now.time_since_epoch();
    latest_ = std::max(latest_ + 1, stamp_of(at));
    wire[length] = link_id_;
    for (std::size_t byte = 0; byte < kStampBytes; ++byte) {
        wire[length + 1 + byte] = static_cast<std::uint8_t>(latest_ >> (8 * byte));
    }
    const std::size_t signed_bytes = length + 1 + kStampBytes;
    std::ranges::copy(hash_.of(wire.first(signed_bytes)), wire.subspan(signed_bytes).begin());
}

std::optional<SignatureFault> MavlinkVerifier::fault_of(std::span<const std::uint8_t> frame,
                                                        Instant received) {
    if (frame[0] == kVersion1 || (frame[2] & kSignedFlag) == 0) {
        return SignatureFault::no_signature;
    }
    const auto told = frame.last<kHashBytes>();
    const auto right = hash_.of(frame.first(frame.size() - kHashBytes));
    if (memeql_sec(told.data(), right.data(), right.size()) == 0) {
        return SignatureFault::wrong;
    }
    const auto signature = frame.last<kSignatureBytes>();
    return take({.system = frame[5],
                 .component = frame[6],
                 .link_id = signature[0],
                 .latest = stamp_in(signature.subspan(1))},
                received);
}

std::optional<SignatureFault> MavlinkVerifier::take(const Stream& message, Instant received) {
    const auto known = std::span(streams_).first(known_);
    const auto stream = std::ranges::find_if(known, [&](const Stream& one) {
        return one.system == message.system && one.component == message.component &&
               one.link_id == message.link_id;
    });
    if (stream != known.end()) {
        if (message.latest <= stream->latest) {
            return SignatureFault::replayed;
        }
        stream->latest = message.latest;
    } else {
        const std::uint64_t clock =
            clock_ != nullptr ? stamp_of(clock_->at(received) - kStampsBegin) : 0;
        if (message.latest + kOldestBeginning < std::max(newest_, clock)) {
            return SignatureFault::too_old;
        }
        if (known_ == kMostStreams) {
            return SignatureFault::no_room;
        }
        streams_[known_++] = message;
    }
    newest_ = std::max(newest_, message.latest);
    return std::nullopt;
}

}  // namespace tribus
