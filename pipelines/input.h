#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/schedule.h"
#include "core/time.h"
#include "pipelines/settings.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"

namespace tribus {

struct InputSettings {
    std::string name;
    /// One of the two, as the protocol is.
    std::unique_ptr<Decoder> decoder;
    std::unique_ptr<CanDecoder> can_decoder{};
    /// No good frame for so long: this input is lost.
    Duration timeout = std::chrono::milliseconds(100);
    std::vector<LossRule> failsafe_when;
};

/// Events of one input since start. Only ever incremented.
struct InputCounts {
    std::uint64_t bytes = 0;  ///< of CAN: the data of the frames that it wants
    std::uint64_t frames = 0;
    std::uint64_t frame_lost_frames = 0;  ///< the sender marked them so
    std::uint64_t failsafe_frames = 0;    ///< the sender marked them so, or a rule did
    std::uint64_t device_losses = 0;
};

/// One source of frames: keeps the latest, and judges whether its link is up. Never a queue.
/// Thread-bound, no allocation after construction.
class Input {
  public:
    Input(InputSettings settings, std::uint8_t index);

    /// Takes bytes that were read at `now`. Returns whether a frame came out of them.
    bool receive(std::span<const std::uint8_t> bytes, Instant now) {
        counts_.bytes += bytes.size();
        return decode(bytes, now);
    }
    /// The same, with the positions of those that the line damaged.
    template <class DamagedMarks>
    bool receive(std::span<const std::uint8_t> bytes, const DamagedMarks& damaged, Instant now) {
        counts_.bytes += bytes.size();
        bool any = false;
        std::size_t start = 0;
        for (std::size_t position = 0; position < bytes.size(); ++position) {
            if (damaged[position]) {
                any = decode(bytes.subspan(start, position - start), now) || any;
                decoder_->damaged_byte();
                start = position + 1;
            }
        }
        return decode(bytes.subspan(start), now) || any;
    }
    /// Takes one CAN frame that arrived at `at`; false also if it is none that this input wants.
    bool receive(const CanFrame& frame, Instant at);
    void device_lost() { ++counts_.device_losses; }

    /// Whether its frames count at `at`, which may lie a little ahead.
    bool alive(Instant at) const { return ever_good_ && !failsafe_ && at < lost_at(); }
    /// When it was lost, or will be if nothing more comes. Only where it was ever good. A sender
    /// that says failsafe after the timeout tells nothing new.
    Instant lost_at() const {
        const Instant too_old = good_.received + timeout_;
        return failsafe_ ? std::min(failsafe_since_, too_old) : too_old;
    }
    bool ever_good() const { return ever_good_; }
    /// Start of the unbroken run of good frames.
    Instant run_start() const { return run_start_; }
    /// The run is the first one: it was never lost, so there is nothing to recover from.
    bool first_run() const { return runs_ <= 1; }

    /// The values of the latest good frame; marked frame-lost if the sender's newest frame is.
    const ChannelFrame& control() const { return good_; }
    /// The latest frame as it came, whatever its flags.
    const ChannelFrame& latest() const { return latest_; }
    const ArrivalClock& arrivals() const { return arrivals_; }
    const InputCounts& counts() const { return counts_; }
    const DecoderReport& decoder() const;
    /// The CAN ids that it listens to; empty where it is not on CAN.
    std::span<const CanIdMatch> wanted_ids() const;
    bool on_can() const { return can_decoder_ != nullptr; }
    bool uses_fd() const { return can_decoder_ && can_decoder_->uses_fd(); }
    const std::string& name() const { return name_; }

  private:
    bool decode(std::span<const std::uint8_t> bytes, Instant now);
    void take(ChannelFrame frame, Instant now);
    bool rule_says_loss(const ChannelFrame& frame) const;

    std::string name_;
    std::unique_ptr<Decoder> decoder_;
    std::unique_ptr<CanDecoder> can_decoder_;
    DecodedFrame decoded_;
    Duration timeout_;
    std::vector<LossRule> failsafe_when_;
    std::uint8_t index_;

    ChannelFrame latest_;
    ChannelFrame good_;
    bool ever_good_ = false;
    bool run_broken_ = true;
    bool failsafe_ = false;
    Instant failsafe_since_{};
    Instant run_start_{};
    std::uint64_t runs_ = 0;
    ArrivalClock arrivals_;
    InputCounts counts_;
};

}  // namespace tribus
