#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/stored_numbers.h"
#include "transports/codecs/authenticated/broadcast_ends.h"
#include "transports/codecs/authenticated/classic_ends.h"

/// An authenticated link, on CAN FD or in classic frames, and somebody who keeps, repeats, changes,
/// delays and invents its frames, while either end starts again.
namespace tribus::fuzz::authenticated_link_target {
namespace {

using std::chrono::milliseconds;
using namespace authenticated;
using test::StoredNumbers;

constexpr std::size_t kMostSteps = 300;
constexpr std::size_t kMostKept = 64;
constexpr std::uint32_t kFirstId = 0x300;
/// Snapshots that are sent at one instant have numbers ahead of the sender's clock, a step each. A
/// real output sends far less often. A start takes longer than all of them.
constexpr Duration kStartTime = kMostSteps * kTimeStep;

struct Kept {
    bool to_receiver = false;
    CanFrame frame;
};

class World {
  public:
    World(bool fd, bool epoch) : fd_(fd), epoch_(epoch) {
        restart_sender();
        restart_receiver();
    }

    void step(Input& input) {
        if (input.below(4) != 0) {
            sent_numbers_.store();
            received_numbers_.store();
        }
        switch (input.below(8)) {
            case 0:
                now_ += milliseconds(input.byte());
                break;
            case 1:
            case 2:
                send();
                break;
            case 3:
                deliver(chosen(input));
                break;
            case 4:
                deliver_all_since(input.byte());
                break;
            case 5:
                deliver_changed(input);
                break;
            case 6:
                invent(input);
                break;
            default:
                restart(input);
                break;
        }
    }

  private:
    void restart(Input& input) {
        const std::size_t way = input.byte();
        if (way % 2 != 0) {
            restart_receiver();
            return;
        }
        now_ += kStartTime;
        switch (way / 2 % 4) {
            case 1:
                sent_numbers_.stop();
                break;
            case 2:
                sent_numbers_.lose_clock(now_);
                break;
            case 3:
                // A suspend, after which it goes on.
                sent_numbers_.lose_clock(now_);
                return;
            default:
                break;
        }
        restart_sender();
    }
    void restart_sender() {
        if (fd_) {
            sender_ = make_fd_encoder(fd_link());
        } else {
            sender_ = std::make_unique<ClassicEncoder>(classic_link());
        }
        sender_->use_seed({++starts_});
        sent_numbers_.start(now_);
        sender_->use_numbers(sent_numbers_);
    }
    void restart_receiver() {
        if (fd_) {
            receiver_ = make_fd_decoder(fd_link());
        } else {
            receiver_ = std::make_unique<ClassicDecoder>(classic_link());
        }
        receiver_->use_seed({++starts_});
        received_numbers_.start(now_);
        receiver_->use_numbers(received_numbers_);
        receiver_started_ = now_;
    }
    LinkWithKey keys() const {
        return {.name = "can 768",
                .epoch = epoch_ ? std::optional<std::string>("/no/file") : std::nullopt};
    }
    FdLink fd_link() const {
        return {.keys = keys(), .sender_id = kFirstId + 5, .receiver_id = kFirstId};
    }
    ClassicLink classic_link() const { return {.keys = keys(), .first_id = kFirstId}; }

    /// The two first channels tell which snapshot it is.
    void send() {
        ChannelFrame sticks;
        const auto number = static_cast<std::int64_t>(sent_at_.size());
        sticks.set(0, Pulse::from_microseconds(1000 + number % 1000));
        sticks.set(1, Pulse::from_microseconds(1000 + number / 1000));
        sticks.failsafe = false;
        sticks.frame_lost = false;
        sticks.received = now_;
        sent_at_.push_back(now_);
        std::array<CanFrame, kMostSnapshotFrames> frames{};
        const std::size_t count = sender_->write(sticks, frames, now_);
        for (std::size_t i = 0; i < count; ++i) {
            keep({true, frames[i]});
        }
    }
    void keep(const Kept& one) {
        if (kept_.size() == kMostKept) {
            kept_.erase(kept_.begin());
        }
        kept_.push_back(one);
    }
    std::optional<Kept> chosen(Input& input) const {
        return kept_.empty() ? std::nullopt : std::optional(kept_[input.below(kept_.size())]);
    }

    void deliver(const std::optional<Kept>& one) {
        if (!one) {
            return;
        }
        if (!one->to_receiver) {
            sender_->hear(one->frame, now_);
            return;
        }
        if (const auto published = receiver_->next(one->frame, now_)) {
            judge(*published);
        }
        for (const CanFrame& frame : receiver_->answer(now_)) {
            keep({false, frame});
        }
    }
    void deliver_all_since(std::size_t back) {
        const std::vector<Kept> some(
            kept_.end() - static_cast<std::ptrdiff_t>(std::min(back, kept_.size())), kept_.end());
        for (const Kept& one : some) {
            deliver(one);
        }
    }
    void deliver_changed(Input& input) {
        auto one = chosen(input);
        if (!one || one->frame.length == 0) {
            return;
        }
        one->frame.data[input.below(one->frame.length)] ^= input.byte();
        one->frame.length = std::min<std::uint8_t>(one->frame.length, input.byte());
        deliver(one);
    }
    /// A frame of anybody, with one of the ids.
    void invent(Input& input) {
        Kept one{.to_receiver = input.below(2) == 0, .frame = {}};
        one.frame.id = kFirstId + static_cast<std::uint32_t>(input.below(kClassicIds));
        one.frame.fd = input.below(2) == 0;
        const auto bytes = input.take(one.frame.fd ? kMostFdBytes : kMostClassicBytes);
        std::ranges::copy(bytes, one.frame.data.begin());
        one.frame.length = static_cast<std::uint8_t>(bytes.size());
        deliver(one);
    }

    void judge(const ChannelFrame& published) {
        const auto thousandths = [&](std::size_t channel) {
            return published.channel_or(channel, Pulse()).whole_microseconds() - 1000;
        };
        const auto number = static_cast<std::size_t>(thousandths(0) + 1000 * thousandths(1));
        require(number < sent_at_.size(), "only what was sent is published");
        require(!latest_ || number > *latest_, "each snapshot once, and in its order");
        require(epoch_ || published.received <= sent_at_[number],
                "values are never younger than they are");
        require(epoch_ || sent_at_[number] >= receiver_started_,
                "nothing from before the receiver's start");
        latest_ = number;
    }

    bool fd_;
    /// The receiver does not answer.
    bool epoch_;
    StoredNumbers sent_numbers_{1000};
    StoredNumbers received_numbers_{0};
    std::uint8_t starts_ = 0;
    std::unique_ptr<CanEncoder> sender_;
    std::unique_ptr<CanDecoder> receiver_;
    Instant now_{std::chrono::hours(1)};
    Instant receiver_started_{};
    std::vector<Instant> sent_at_;
    std::vector<Kept> kept_;
    std::optional<std::size_t> latest_;
};

}  // namespace

FUZZ_TARGET(authenticated_link) {
    Input input({data, size});
    const bool fd = input.below(2) == 0;
    World world(fd, input.below(2) == 0);
    for (std::size_t step = 0; step < kMostSteps && !input.empty(); ++step) {
        world.step(input);
    }
    return 0;
}

}  // namespace tribus::fuzz::authenticated_link_target
