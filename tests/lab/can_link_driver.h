#pragma once

#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/can_frame.h"
#include "core/time.h"
#include "tests/lab/raw_can.h"
#include "tests/loopback/program.h"
#include "transports/links/can/can_socket.h"

namespace tribus::test {

using namespace std::chrono_literals;

/// Ids that the link sends: 0x300 to 0x303.
inline constexpr std::uint32_t kFirstSent = 0x300;
inline constexpr std::size_t kSnapshotFrames = 4;

inline CanIdMatch standard_id(std::uint32_t id, std::uint32_t mask = kMostStandardId) {
    return {.id = id, .mask = mask, .extended = false};
}

/// Reads 0x123 and sends the four ids from kFirstSent on.
inline LinkUse usual_settings() {
    return {.wanted = {standard_id(0x123)}, .sent = {standard_id(kFirstSent, 0x7FC)}, .fd = false};
}

inline std::unique_ptr<CanSocket> open_link(const std::string& interface,
                                            const LinkUse& settings = usual_settings()) {
    auto link = CanSocket::open(interface, settings);
    EXPECT_TRUE(link) << link.error();
    return link ? std::move(*link) : nullptr;
}

inline Instant now() {
    return Instant(std::chrono::steady_clock::now().time_since_epoch());
}

/// Time when the frame of a snapshot was offered. The frame's data is this time.
inline Instant offered_at(const CanFrame& frame) {
    std::int64_t nanoseconds = 0;
    std::memcpy(&nanoseconds, frame.data.data(), sizeof nanoseconds);
    return Instant(Duration(nanoseconds));
}

/// Does for one link what the program's loop does for all links: waits, reads, polls.
class LinkDriver {
  public:
    explicit LinkDriver(CanSocket& link) : link_(link) {}

    /// Offers a snapshot that contains the present time.
    WriteStatus write(std::size_t frames = kSnapshotFrames, std::size_t lane = 0) {
        const Instant at = now();
        std::vector<CanFrame> snapshot;
        for (std::uint32_t index = 0; index < frames; ++index) {
            CanFrame frame = make_frame(kFirstSent + index, std::vector<std::uint8_t>(8));
            const std::int64_t nanoseconds = at.time_since_epoch().count();
            std::memcpy(frame.data.data(), &nanoseconds, sizeof nanoseconds);
            snapshot.push_back(frame);
        }
        return write(snapshot, lane);
    }
    WriteStatus write(std::span<const CanFrame> snapshot, std::size_t lane = 0) {
        const WriteStatus status = link_.write(lane, snapshot, now());
        due_ = now();
        return status;
    }

    /// Waits for one event, at most for `most`, and handles it.
    void step(Duration most) {
        const Instant limit = std::min(due_, now() + most);
        const auto wait = std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::max(limit - now(), Duration::zero()));
        const timespec timeout{.tv_sec = wait.count() / 1'000'000'000,
                               .tv_nsec = wait.count() % 1'000'000'000};
        std::array<pollfd, 2> ready{
            pollfd{.fd = link_.descriptor(), .events = POLLIN, .revents = 0},
            pollfd{.fd = link_.second_descriptor(), .events = POLLIN, .revents = 0}};
        ++wakes_;
        if (::ppoll(ready.data(), ready.size(), &timeout, nullptr) > 0) {
            const Duration wall = std::chrono::system_clock::now().time_since_epoch();
            latest_read_ = link_.read(*reception_, now(), wall);
            received_.insert(received_.end(), reception_->view().begin(), reception_->view().end());
        }
        due_ = link_.poll(now());
    }
    void run_for(Duration time) {
        const Instant end = now() + time;
        while (now() < end && latest_read_ != ReadStatus::lost) {
            step(end - now());
        }
    }
    template <class Done>
    bool run_until(Done done) {
        const Instant end = now() + kPatience;
        while (!done()) {
            if (now() > end) {
                return false;
            }
            step(5ms);
        }
        return true;
    }
    bool run_until_state(CanBusState state) {
        return run_until([&] { return link_.status().state == state; });
    }
    /// Offers a snapshot every 7 ms and returns the result of each.
    std::vector<WriteStatus> stream_for(Duration time, std::size_t frames = kSnapshotFrames) {
        std::vector<WriteStatus> fates;
        for (const Instant end = now() + time; now() < end;) {
            fates.push_back(write(frames));
            run_for(7ms);
        }
        return fates;
    }

    const std::vector<ReceivedCanFrame>& received() const { return received_; }
    void forget_received() { received_.clear(); }
    ReadStatus latest_read() const { return latest_read_; }
    CanLinkStatus status() const { return link_.status(); }
    CanCounts counts() const { return link_.status().counts; }
    int wakes() const { return wakes_; }

  private:
    CanSocket& link_;
    std::unique_ptr<CanReception> reception_ = std::make_unique<CanReception>();
    std::vector<ReceivedCanFrame> received_;
    ReadStatus latest_read_ = ReadStatus::nothing;
    Instant due_{};
    int wakes_ = 0;
};

/// Offers snapshots until one is accepted. Returns how long that took.
inline Duration time_to_next_written(LinkDriver& driver) {
    const Instant start = now();
    EXPECT_TRUE(driver.run_until([&] { return driver.write() == WriteStatus::written; }));
    return now() - start;
}

/// Records the time for the table of recovery times.
inline void record(Duration time) {
    testing::Test::RecordProperty("recovery_us", static_cast<int>(time / 1us));
}

}  // namespace tribus::test
