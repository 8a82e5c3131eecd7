#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/arrival_clock.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/link_cause.h"
#include "core/time.h"
#include "pipelines/channel_map.h"
#include "pipelines/link_supervisor.h"
#include "pipelines/settings.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/line_pauses.h"
#include "transports/codecs/read_times.h"

namespace tribus {

struct InputSettings {
    std::string name;
    /// One of the two, as the protocol is.
    std::unique_ptr<Decoder> decoder;
    std::unique_ptr<CanDecoder> can_decoder{};
    /// Of one byte on its wire; zero where the instants of reads say nothing of pauses on it.
    Duration byte_time{};
    SupervisionSettings supervision{};
    /// How its channels are made from those that the receiver sends.
    std::vector<ChannelRule> channels{};
};

/// Events of one input since start. Only ever incremented.
struct InputCounts {
    std::uint64_t bytes = 0;  ///< of CAN: the data of the frames that it wants
    std::uint64_t frames = 0;
    std::uint64_t frame_lost_frames = 0;  ///< the sender marked them so
    std::uint64_t failsafe_frames = 0;    ///< the sender marked them so, or a rule did
    std::uint64_t device_losses = 0;
    /// How often each cause began; by `LinkCause`.
    std::array<std::uint64_t, kLinkCauseCount> began{};
};

/// One source of frames: keeps the latest, and has its link judged. Never a queue.
/// Thread-bound, no allocation after construction.
class Input {
  public:
    Input(InputSettings settings, std::uint8_t index);

    /// Goes on at `now` as `before`, an input of the same protocol and settings, which is left
    /// without use: half a frame, what is known of the link, and the counters.
    void continue_from(Input& before, bool same_channels, Instant now);

    /// Takes bytes that were read at `now`. Returns whether a frame came out of them.
    bool receive(std::span<const std::uint8_t> bytes, Instant now) {
        const bool any = arrived(bytes.size(), now);
        return decode(bytes, now) || any;
    }
    /// The same, with the positions of those that the line damaged.
    template <class DamagedMarks>
    bool receive(std::span<const std::uint8_t> bytes, const DamagedMarks& damaged, Instant now) {
        bool any = arrived(bytes.size(), now);
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
    /// What came before does not belong to what comes when the device is back.
    void device_lost();
    /// Nobody read from `since` to `now`. What waited meanwhile has been given to `receive`, bytes
    /// as if they had been read at `since`, for so old they may be; or it was thrown away.
    void was_away(Instant since, Instant now) {
        supervisor_.was_away(since, now);
        forget_read_time();
    }
    /// Bytes behind those that came were thrown away: no frame goes on across them.
    void bytes_discarded() { start_anew(); }
    /// The time since the latest bytes says nothing of pauses on the line.
    void forget_read_time() { pauses_.forget(); }

    /// Whether its frames count, and since when, until when and why.
    const LinkSupervisor& link() const { return supervisor_; }
    /// The same in a word, as of the latest frame or look.
    const LinkState& state() const { return state_; }
    /// Brings `state` and its counters up to date.
    void look(Instant now);

    /// The values of the latest good frame, by the input's own channel rules; marked frame-lost if
    /// the sender's newest frame is not good.
    const ChannelFrame& control() const { return map_ ? mapped_ : supervisor_.control(); }
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
    void count_bytes(std::size_t count, Instant now) {
        counts_.bytes += count;
        supervisor_.bytes_came(now);
    }
    /// Before the bytes themselves. Returns whether a frame came out of it that they are behind.
    bool arrived(std::size_t count, Instant now) {
        count_bytes(count, now);
        read_times_.add(counts_.bytes, now);
        return pauses_.before(count, now, decoder_->waiting()) && pause(now);
    }
    bool pause(Instant now);
    void start_anew();
    bool decode(std::span<const std::uint8_t> bytes, Instant now);
    /// The decoder's frame.
    void take_decoded(Instant now);
    /// A frame that arrived at `arrival`, no later than `now`.
    void take(ChannelFrame frame, Instant arrival, Instant now);

    std::string name_;
    std::unique_ptr<Decoder> decoder_;
    std::unique_ptr<CanDecoder> can_decoder_;
    DecodedFrame decoded_;
    /// By the bytes that are counted, as the decoder places its frames.
    ReadTimes read_times_;
    LinePauses pauses_;
    std::uint8_t index_;

    LinkSupervisor supervisor_;
    /// None where the channels pass as they are.
    std::optional<ChannelMap> map_;
    LinkState state_;
    ChannelFrame latest_;
    ChannelFrame mapped_;
    ArrivalClock arrivals_;
    InputCounts counts_;
};

}  // namespace tribus
