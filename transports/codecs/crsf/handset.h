#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/crsf/frames.h"
#include "transports/codecs/sbus/scale.h"

namespace tribus {

/// Writes channels to a transmitter module, as a handset does, and obeys the timing that the module
/// asks for (docs/protocols/crsf.md, "Towards a transmitter module"). 16 channels; an absent one is
/// sent as 1500 us. Nothing says failsafe: on loss the channels stop.
class CrsfHandsetEncoder final : public ByteEncoder {
  public:
    /// The module gets `model_id` in the place of a frame of channels when it is heard for the
    /// first time, and again after it was silent for kModuleGone. Nothing: it gets none.
    explicit CrsfHandsetEncoder(std::optional<std::uint8_t> model_id) : model_id_(model_id) {}

    bool marks_frame_lost() const override { return false; }
    std::uint32_t needed_channels(const ChannelFrame& frame) const override;
    std::size_t write(const ChannelFrame& frame, std::span<std::uint8_t, kLongestSerialFrame> wire,
                      Instant now) override;
    std::optional<AskedTiming> hear(std::span<const std::uint8_t> bytes, Instant now) override;
    void forget_heard() override;
    void continue_from(const Encoder& before) override;
    Hearing hearing(Instant now) const override;

    /// Modules send several frames a second. EdgeTX waits 2 s before it forgets their timing.
    static constexpr Duration kModuleGone = std::chrono::seconds(2);
    /// A module that looks for the rate of its handset answers within so long a time.
    static constexpr Duration kFirstWordWait = std::chrono::seconds(3);
    /// Longer than every period: channels that come after such a pause begin anew.
    static constexpr Duration kStoppedSending = std::chrono::seconds(1);

  private:
    /// Finds the timing that a module asks for. On one wire it hears its own frames, too.
    class FromModule final : public CrsfFrames {
      public:
        /// How many bytes and frames were none.
        std::uint64_t refused() const;

        AskedTiming timing{};
        std::optional<Instant> heard_at{};
        /// The module was heard for the first time, or after it was gone.
        bool appeared = false;

      private:
        bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) override;
    };

    std::size_t write_model_id(std::span<std::uint8_t, kLongestSerialFrame> wire) const;
    void note_sending(Instant now);

    std::optional<std::uint8_t> model_id_;
    FromModule heard_;
    /// When channels were sent first without a pause since, and last.
    std::optional<Instant> sends_since_;
    Instant sent_at_{};
    /// When bytes came back last that are no frame, and whether some came since the latest frame
    /// was written.
    std::optional<Instant> unread_at_;
    bool unread_ = false;
    SbusScale scale_ = *SbusScale::named("betaflight");
};

}  // namespace tribus
