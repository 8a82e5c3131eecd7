#include "app/demo/demo_peers.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// As an FS-iA6B (docs/protocols/ibus.md, "Period and gaps").
constexpr Duration kReceiverPeriod = std::chrono::microseconds(7700);
/// The radio link is up for kUp, then down for kDown, again and again.
constexpr Duration kUp = std::chrono::seconds(6);
constexpr Duration kDown = std::chrono::milliseconds(1500);

bool link_up(Duration since_start) {
    return since_start % (kUp + kDown) < kUp;
}

bool same_sticks(const ChannelFrame& a, const ChannelFrame& b) {
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        if (a.channel_or(channel, kCentrePulse).whole_microseconds() !=
            b.channel_or(channel, kCentrePulse).whole_microseconds()) {
            return false;
        }
    }
    return true;
}

}  // namespace

ChannelFrame demo_sticks(Duration since_start) {
    const double seconds = std::chrono::duration<double>(since_start).count();
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        constexpr double kSlowestHertz = 0.11;
        constexpr double kHertzStep = 0.023;
        const double number = static_cast<double>(channel);
        const double turn =
            seconds * (kSlowestHertz + kHertzStep * number) + number / kChannelCount;
        const double wave = std::sin(2 * std::numbers::pi * turn);
        // Channels 17 and 18 are two-state on SBUS.
        const double us = channel < kSbusChannels ? 1500 + 480 * wave : (wave > 0 ? 2000 : 1000);
        frame.set(channel, Pulse::from_microseconds(std::lround(us)));
    }
    return frame;
}

DemoPeers::DemoPeers(UniqueFd receiver, UniqueFd servos)
    : receiver_(std::move(receiver)),
      servos_(std::move(servos)),
      start_(monotonic_now()),
      next_send_(start_),
      thread_([this] { main(); }) {}

PeerReport DemoPeers::report() {
    const std::lock_guard lock(mutex_);
    return report_;
}

void DemoPeers::stop_receiver() {
    const std::lock_guard lock(mutex_);
    receiver_stopped_ = true;
}

void DemoPeers::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    if (thread_.joinable()) {
        thread_.join();
    }
}

void DemoPeers::main() {
    while (true) {
        const Duration sleep = std::max(next_send_ - monotonic_now(), Duration::zero());
        const timespec timeout = as_timespec(sleep);
        pollfd servos{.fd = servos_.get(), .events = POLLIN, .revents = 0};
        ::ppoll(&servos, 1, &timeout, nullptr);
        const Instant now = monotonic_now();
        const std::lock_guard lock(mutex_);
        if (stopping_) {
            return;
        }
        read_servos(now);
        send_due(now);
    }
}

void DemoPeers::send_due(Instant now) {
    if (now < next_send_) {
        return;
    }
    while (next_send_ <= now) {
        next_send_ += kReceiverPeriod;
    }
    const bool was_up = report_.link_up;
    report_.link_up = link_up(now - start_);
    if (was_up && !report_.link_up && !receiver_stopped_) {
        report_.drops.emplace_back();
    }
    if (!was_up && report_.link_up) {
        back_at_ = now;
    }
    if (!report_.link_up || receiver_stopped_) {
        return;
    }
    report_.sent = demo_sticks(now - start_);
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = encoder_.write(report_.sent, wire, Instant{});
    if (::write(receiver_.get(), wire.data(), length) == static_cast<ssize_t>(length)) {
        ++report_.frames_sent;
        latest_sent_at_ = now;
        remembered_[report_.frames_sent % kRemembered] = {report_.sent, now, report_.frames_sent};
    }
}

void DemoPeers::read_servos(Instant now) {
    std::array<std::uint8_t, 256> buffer{};
    const ssize_t count = ::read(servos_.get(), buffer.data(), buffer.size());
    if (count <= 0) {
        return;
    }
    std::span<const std::uint8_t> bytes(buffer.data(), static_cast<std::size_t>(count));
    DecodedFrame frame;
    while (decoder_.next(bytes, now, frame)) {
        note(frame.channels, now);
    }
}

void DemoPeers::note(const ChannelFrame& frame, Instant now) {
    ++report_.frames_received;
    report_.received = frame;
    note_drop(frame, now);
    if (!frame.good()) {
        return;
    }
    for (std::uint64_t number = report_.frames_sent;
         number > latest_fresh_ && number + kRemembered > report_.frames_sent; --number) {
        const Sent& sent = remembered_[number % kRemembered];
        if (sent.number == number && same_sticks(sent.frame, frame)) {
            latest_fresh_ = number;
            ++report_.frames_fresh;
            report_.latencies.push_back(now - sent.at);
            return;
        }
    }
}

void DemoPeers::note_drop(const ChannelFrame& frame, Instant now) {
    if (report_.drops.empty()) {
        return;
    }
    DropRecord& drop = report_.drops.back();
    if (frame.frame_lost && !drop.frame_lost_after) {
        drop.frame_lost_after = now - latest_sent_at_;
    }
    if (frame.failsafe && !drop.failsafe_after) {
        drop.failsafe_after = now - latest_sent_at_;
    }
    if (frame.good() && drop.failsafe_after && !drop.control_after) {
        drop.control_after = now - back_at_;
    }
}

}  // namespace tribus
