#include "transports/codecs/mavlink/signature.h"

#include <nettle/memops.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ratio>

namespace tribus {

using namespace mavlink_wire;

namespace {

/// From 1970 to 2015, when time stamps begin.
constexpr Duration kStampsBegin = std::chrono::seconds(1420070400);
using StampUnits = std::chrono::duration<std::int64_t, std::ratio<1, 100000>>;
/// A stream may begin with a message that is so old, or so far ahead.
constexpr std::uint64_t kMostOff = StampUnits(std::chrono::minutes(1)).count();
constexpr std::uint64_t kClose =
    std::chrono::duration_cast<StampUnits>(MavlinkVerifier::kCloseTimes).count();

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

MavlinkHash::~MavlinkHash() {
    ::explicit_bzero(&begun_, sizeof begun_);
}

std::array<std::uint8_t, kHashBytes> MavlinkHash::of(
    std::span<const std::uint8_t> signed_part) const {
    sha256_ctx hash = begun_;
    sha256_update(&hash, signed_part.size(), signed_part.data());
    std::array<std::uint8_t, kHashBytes> first{};
    sha256_digest(&hash, first.size(), first.data());
    // The secret is in the first block.
    ::explicit_bzero(&hash, sizeof hash);
    return first;
}

void MavlinkSigner::sign(std::span<std::uint8_t> wire, std::size_t length, Instant now) {
    const Duration at = clock_ != nullptr ? time_at(now) : now.time_since_epoch();
    latest_ = std::max(latest_ + 1, stamp_of(at));
    wire[length] = link_id_;
    for (std::size_t byte = 0; byte < kStampBytes; ++byte) {
        wire[length + 1 + byte] = static_cast<std::uint8_t>(latest_ >> (8 * byte));
    }
    const std::size_t signed_bytes = length + 1 + kStampBytes;
    std::ranges::copy(hash_.of(wire.first(signed_bytes)), wire.subspan(signed_bytes).begin());
}

/// Receivers take a time that stands still, or goes on too slowly, for a delay.
Duration MavlinkSigner::time_at(Instant now) {
    const Instant unslewed = clock_->unslewed(now);
    const Duration of_clock = clock_->at(now) - kStampsBegin;
    const Duration passed = std::max(unslewed - latest_at_, Duration{});
    const Duration kept = latest_time_ + passed - passed / kReturnParts;
    const bool keeps = kept > of_clock && kept - of_clock < kMostAhead;
    latest_time_ = keeps ? kept : of_clock;
    latest_at_ = unslewed;
    return latest_time_;
}

void MavlinkSigner::continue_from(const MavlinkSigner& before) {
    latest_ = before.latest_;
    latest_time_ = before.latest_time_;
    latest_at_ = before.latest_at_;
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
                 .stamp = stamp_in(signature.subspan(1)),
                 .received = received,
                 .unslewed = clock_ != nullptr ? clock_->unslewed(received) : received});
}

std::optional<SignatureFault> MavlinkVerifier::take(const Message& message) {
    const auto known = std::span(streams_).first(known_);
    const auto stream = std::ranges::find_if(known, [&](const Stream& one) {
        return one.latest.system == message.system && one.latest.component == message.component &&
               one.latest.link_id == message.link_id;
    });
    return stream != known.end() ? go_on(*stream, message) : begin(message);
}

bool MavlinkVerifier::is_ahead(std::uint64_t stamp, Instant received) const {
    return clock_ != nullptr && clock_->is_set() &&
           stamp > stamp_of(clock_->at(received) - kStampsBegin) + kMostOff;
}

std::optional<SignatureFault> MavlinkVerifier::begin(const Message& message) {
    const std::uint64_t clock =
        clock_ != nullptr ? stamp_of(clock_->at(message.received) - kStampsBegin) : 0;
    if (message.stamp + kMostOff < std::max(newest_, clock)) {
        return SignatureFault::too_old;
    }
    if (is_ahead(message.stamp, message.received)) {
        return SignatureFault::ahead;
    }
    if (known_ == kMostStreams) {
        return SignatureFault::no_room;
    }
    streams_[known_++] = {.latest = message, .quickest = message};
    newest_ = std::max(newest_, message.stamp);
    delay_ = {};
    return std::nullopt;
}

std::optional<SignatureFault> MavlinkVerifier::go_on(Stream& stream, const Message& message) {
    if (message.stamp <= stream.latest.stamp) {
        return SignatureFault::replayed;
    }
    const auto passed = std::chrono::floor<StampUnits>(message.unslewed - stream.latest.unslewed);
    const auto expected = static_cast<std::int64_t>(stream.latest.stamp) + passed.count();
    // A clock that is ahead more and more cannot cost the control that there is.
    if (static_cast<std::int64_t>(message.stamp) > expected + std::int64_t{kMostOff} &&
        is_ahead(message.stamp, message.received)) {
        return SignatureFault::ahead;
    }
    const Duration delay = delay_in(stream, message);
    stream.latest = message;
    newest_ = std::max(newest_, message.stamp);
    if (delay > kMostDelay) {
        return SignatureFault::late;
    }
    delay_ = delay;
    return std::nullopt;
}

/// Of messages that were read together only the first tells how quick the way is: the thread may
/// not have run meanwhile.
Duration MavlinkVerifier::delay_in(Stream& stream, const Message& message) {
    stream.close = message.stamp - stream.latest.stamp <= kClose ? stream.close + 1 : 0;
    const bool counts = stream.close >= kCountedMessages;
    stream.close = counts ? kCountedMessages : stream.close;
    const Duration told = StampUnits(message.stamp - stream.quickest.stamp);
    const Duration passed = message.unslewed - stream.quickest.unslewed;
    const Duration delay = counts ? Duration{} : passed - told - passed / kDriftParts;
    if (delay > Duration{}) {
        return delay;
    }
    if (message.received > stream.latest.received) {
        stream.quickest = message;
    }
    return {};
}

}  // namespace tribus
