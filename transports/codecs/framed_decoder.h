#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "core/channel_frame.h"
#include "transports/codecs/codec.h"

namespace tribus {

/// Base of a decoder whose frames begin with a known byte, say how long they are, and carry a
/// check. The derived class says how a frame is laid out; this class finds frames in the stream.
/// It looks at a frame once all of its bytes are there. If the check fails, it searches on from the
/// second byte, so that a frame behind a false beginning is found. A pause on the line ends an
/// incomplete frame. Thread-bound; no heap.
class FramedDecoder : public ByteDecoder {
  public:
    void damaged_byte() override;
    bool silence(DecodedFrame& frame) override;
    /// A derived class that keeps what later frames need forgets it, too.
    void reset() override;
    std::optional<DecodedFrame> finish() final;
    std::span<const NamedCount> rejected() const final {
        return std::span(rejected_).first(causes_);
    }
    std::uint64_t skipped_bytes() const final { return skipped_bytes_; }

  protected:
    FramedDecoder() = default;
    /// With counts for frames that the derived class refuses itself: at most kMostOwnCauses.
    explicit FramedDecoder(std::span<const std::string_view> own_causes)
        : causes_(kOwn + own_causes.size()) {
        for (std::size_t i = 0; i < own_causes.size(); ++i) {
            rejected_[kOwn + i].name = own_causes[i];
        }
    }
    static constexpr std::size_t kMostOwnCauses = 8;
    /// Counts a frame that the derived class refuses, by the index of the cause.
    void refuse(std::size_t own_cause) { ++rejected_[kOwn + own_cause].count; }

    /// A derived class may handle its usual frame, whole in one read, on a shorter way.
    Taken decode(std::span<const std::uint8_t> bytes, Instant received,
                 DecodedFrame& frame) override;

  private:
    /// How many bytes of a frame that begins with `bytes`, at least one, must be there to judge it:
    /// 0 if none begins so; `bytes.size()` if it is whole; more if it is not whole or its length is
    /// not known yet, at most LineBuffer::kCapacity.
    virtual std::size_t needed_bytes(std::span<const std::uint8_t> bytes) const = 0;
    /// Whether the check of a whole frame is right.
    virtual bool check_holds(std::span<const std::uint8_t> frame) const = 0;
    /// Reads a frame whose check is right and sets channels and flags; the arrival is set. Returns
    /// false if the frame says nothing of channels: it is then passed over.
    virtual bool read(std::span<const std::uint8_t> frame, ChannelFrame& channels) = 0;

    enum RejectCause : std::size_t { kChecksum, kDamaged, kOwn };
    enum class Candidate : std::uint8_t { none, incomplete, whole };
    Candidate look(std::size_t& length);
    bool search(bool more_may_come, Instant received, DecodedFrame& frame);

    std::array<NamedCount, kOwn + kMostOwnCauses> rejected_{{{"checksum"}, {"damaged"}}};
    std::size_t causes_ = kOwn;
    std::uint64_t skipped_bytes_ = 0;
    /// When the latest bytes came that were looked at together with others. A frame that a pause
    /// shows came then.
    Instant read_at_{};
};

}  // namespace tribus
