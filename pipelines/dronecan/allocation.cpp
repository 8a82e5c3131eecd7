#include "pipelines/dronecan/allocation.h"

#include <algorithm>
#include <chrono>

namespace tribus::dronecan {
namespace {

using std::chrono::milliseconds;

constexpr Duration kLeastPause = milliseconds(Allocation::kLeastRequestPeriodMs);
constexpr Duration kMostPause = milliseconds(Allocation::kMostRequestPeriodMs);
constexpr Duration kLeastFollowUpPause = milliseconds(Allocation::kLeastFollowupDelayMs);
constexpr Duration kMostFollowUpPause = milliseconds(Allocation::kMostFollowupDelayMs);

}  // namespace

AllocationClient::AllocationClient(UniqueId unique_id, NodeId preferred, std::uint64_t seed)
    : unique_id_(unique_id), preferred_(preferred), random_(seed | 1U) {}

void AllocationClient::start(Instant now) {
    confirmed_ = 0;
    id_.reset();
    next_ = now + random_pause(kLeastPause, kMostPause);
}

void AllocationClient::take(const Allocation& message, NodeId source, Instant at) {
    if (id_) {
        return;
    }
    // Another client's transfer: wait, so that it can finish first.
    next_ = at + random_pause(kLeastPause, kMostPause);
    const std::size_t length = message.unique_id.size();
    const bool mine =
        source != kNobody && length > 0 &&
        std::equal(message.unique_id.begin(), message.unique_id.end(), unique_id_.begin());
    confirmed_ = mine ? length : 0;
    if (!mine) {
        return;
    }
    if (length < unique_id_.size()) {
        next_ = at + random_pause(kLeastFollowUpPause, kMostFollowUpPause);
    } else if (message.node_id != kNobody) {
        id_ = message.node_id;
        next_ = kNever;
    } else {
        confirmed_ = 0;
    }
}

Allocation AllocationClient::run(Instant now) {
    Allocation message;
    message.node_id = preferred_;
    message.first_part_of_unique_id = confirmed_ == 0;
    const std::size_t end =
        std::min(confirmed_ + Allocation::kMostUniqueIdBytesInRequest, unique_id_.size());
    for (std::size_t i = confirmed_; i < end; ++i) {
        message.unique_id.push_back(unique_id_[i]);
    }
    // Without an answer the next request starts from the first part.
    confirmed_ = 0;
    next_ = now + random_pause(kLeastPause, kMostPause);
    return message;
}

/// xorshift64: the pauses only need to differ between two nodes.
Duration AllocationClient::random_pause(Duration least, Duration most) {
    random_ ^= random_ << 13U;
    random_ ^= random_ >> 7U;
    random_ ^= random_ << 17U;
    const auto span = static_cast<std::uint64_t>((most - least).count()) + 1;
    return least + Duration(static_cast<std::int64_t>(random_ % span));
}

}  // namespace tribus::dronecan
