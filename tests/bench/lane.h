#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/cli/pty.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus::bench {

/// The frames that go in, and those expected at the far end for them.
enum class Carries : std::uint8_t {
    same,          ///< i.Bus of 18 channels; the same frame, byte by byte
    sbus,          ///< i.Bus of 18 channels; the same channels as SBUS
    sbus_of_14,    ///< i.Bus of 14 channels; the same channels as SBUS
    ibus_of_sbus,  ///< SBUS; the same channels as i.Bus of 18
};

/// The bytes of one frame.
struct WireFrame {
    std::array<std::uint8_t, kLongestSerialFrame> bytes{};
    std::size_t length = 0;

    bool operator==(const WireFrame&) const = default;
};

/// Channels that encode a number; each channel depends on it.
ChannelFrame numbered_channels(std::uint32_t number);
/// An i.Bus frame of 18 channels with that number; parts of two such frames are never a valid one.
WireFrame numbered_ibus_frame(std::uint32_t number);
/// The frame that goes in for that number, and the frame that must come out.
WireFrame numbered_frame_in(std::uint32_t number, Carries carries);
WireFrame numbered_frame_out(std::uint32_t number, Carries carries);

/// Counters of a lane. Only ever incremented.
struct LaneCounts {
    std::uint64_t sent = 0;
    std::uint64_t arrived = 0;
    std::uint64_t repeated = 0;  ///< the frame before once more
    std::uint64_t torn = 0;      ///< reads with bytes of no expected frame
};

/// One path through a subject: two ptys; the lane holds their far ends. Allocates nothing after
/// `open`.
class Lane {
  public:
    /// Opens both ptys. The error is a sentence.
    static tl::expected<Lane, std::string> open(Carries carries);

    const std::string& in_path() const { return in_.path; }
    const std::string& out_path() const { return out_.path; }
    /// Readable when something has come out.
    int out_descriptor() const { return out_.master.get(); }

    /// Sends the next frame. Returns false if the line does not take it.
    bool send();
    /// Sends bytes that are no frame, although some begin like one; made from `seed`.
    void send_garbage(std::size_t count, std::uint32_t seed);
    /// Reads what has come out. Returns true if this completed the frame that was sent last.
    bool receive();
    /// Just before the last frame was written.
    Instant sent_at() const { return sent_at_; }
    /// True while the last frame has not come out.
    bool outstanding() const { return outstanding_; }
    /// Stops waiting for the last frame.
    void give_up() { outstanding_ = false; }
    /// Discards what has come out.
    void drain();
    /// Resets the counters.
    void start_counting();

    const LaneCounts& counts() const { return counts_; }

  private:
    Lane(Pty in, Pty out, Carries carries);
    bool take_frame(const WireFrame& frame);

    Pty in_;
    Pty out_;
    Carries carries_;
    std::uint32_t number_ = 0;
    Instant sent_at_{};
    WireFrame expected_;
    WireFrame before_;
    std::array<std::uint8_t, 8 * kLongestSerialFrame> pending_{};
    std::size_t pending_count_ = 0;
    bool outstanding_ = false;
    LaneCounts counts_;
};

}  // namespace tribus::bench
