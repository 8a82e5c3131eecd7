#include "transports/links/pulse_line/edge_link.h"

#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <span>
#include <utility>

#include "core/edge_records.h"

namespace tribus {
namespace {

using edge_records::EdgeKind;
using edge_records::kRecordBytes;

constexpr std::uint64_t kNanosecondsAnEighth = 125;
constexpr std::uint64_t kNanosecondsASecond = 1'000'000'000;
constexpr std::uint64_t kQuietNanoseconds = edge_records::kFrameGapEighths * kNanosecondsAnEighth;
/// How often a quiet line is asked whether its chip is still there: Linux 6.1 wakes nobody when it
/// goes.
constexpr time_t kPresenceSeconds = 1;
/// Of the monotonic clock, in nanoseconds.
constexpr std::uint64_t kInThePast = 1;

static_assert((kEdgesPerRead + 1) * kRecordBytes <= kBytesPerRead);

/// Rounds both ends, so that the rounding of many distances does not add up.
std::uint32_t eighths_between(std::uint64_t from, std::uint64_t to) {
    const auto rounded = [](std::uint64_t nanoseconds) {
        return (nanoseconds + kNanosecondsAnEighth / 2) / kNanosecondsAnEighth;
    };
    const std::uint64_t eighths = rounded(std::max(from, to)) - rounded(from);
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>(eighths, edge_records::kLongestEighths));
}

void add_record(Reception& reception, edge_records::EdgeRecord record) {
    edge_records::put(std::span(reception.bytes).subspan(reception.count, kRecordBytes), record);
    reception.count += kRecordBytes;
}

}  // namespace

/// A timer that is set to the past expires at once, and then each second.
EdgeLink::EdgeLink(std::unique_ptr<GpioHeldLine> line, UniqueFd timer)
    : line_(std::move(line)), timer_(std::move(timer)) {
    set_timer(kInThePast);
}

EdgeLink::~EdgeLink() = default;

void EdgeLink::set_timer(std::uint64_t at_nanoseconds) {
    timer_at_ = at_nanoseconds;
    const itimerspec at{
        .it_interval = {.tv_sec = kPresenceSeconds, .tv_nsec = 0},
        .it_value = {.tv_sec = static_cast<time_t>(at_nanoseconds / kNanosecondsASecond),
                     .tv_nsec = static_cast<long>(at_nanoseconds % kNanosecondsASecond)}};
    ::timerfd_settime(timer_.get(), TFD_TIMER_ABSTIME, &at, nullptr);
}

/// Returns whether there were any.
bool EdgeLink::take_edges(Reception& reception) {
    std::array<GpioEdge, kEdgesPerRead> edges{};
    const auto count = line_->read_edges(edges);
    gone_ = !count.has_value();
    for (const GpioEdge& edge : std::span(edges).first(count.value_or(0))) {
        const bool lost = edge.after_loss || after_loss_;
        add_record(reception, {lost ? EdgeKind::edge_after_loss : EdgeKind::edge,
                               lost ? edge_records::kLongestEighths
                                    : eighths_between(latest_edge_, edge.nanoseconds)});
        latest_edge_ = edge.nanoseconds;
        after_loss_ = false;
    }
    reception.full = count == edges.size();
    return count.value_or(0) > 0;
}

/// No edge came until the timer expired.
void EdgeLink::stay_without_edge(Reception& reception) {
    const std::uint64_t quiet_at = latest_edge_ + kQuietNanoseconds;
    if (is_quiet_) {
        gone_ = !line_->get().has_value();
    } else if (timer_at_ < quiet_at) {
        set_timer(quiet_at);
    } else {
        is_quiet_ = true;
        add_record(reception, {EdgeKind::quiet, edge_records::kFrameGapEighths});
    }
}

ReadStatus EdgeLink::read(Reception& reception) {
    reception.damaged.reset();
    reception.count = 0;
    reception.full = false;
    reception.goes_on = false;
    // Before the edges: one that comes in between shows that the line is not quiet.
    std::uint64_t expirations = 0;
    const bool expired =
        ::read(timer_.get(), &expirations, sizeof expirations) == sizeof expirations;
    if (!gone_ && take_edges(reception)) {
        if (is_quiet_ || expired) {
            set_timer(latest_edge_ + kQuietNanoseconds);
        }
        is_quiet_ = false;
        return ReadStatus::received;
    }
    if (!gone_ && expired) {
        stay_without_edge(reception);
    }
    if (gone_) {
        return ReadStatus::lost;
    }
    return reception.view().empty() ? ReadStatus::nothing : ReadStatus::received;
}

WriteStatus EdgeLink::write(std::span<const std::uint8_t> /*frame*/) {
    return WriteStatus::unavailable;
}

void EdgeLink::discard_unread() {
    std::array<GpioEdge, kEdgesPerRead> edges{};
    while (line_->read_edges(edges) == edges.size()) {
    }
    after_loss_ = true;
}

}  // namespace tribus
