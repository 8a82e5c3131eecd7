#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include <tl/expected.hpp>

#include "app/pty.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"

namespace tribus::bench {

/// What comes out at the far end for the i.Bus frame that went in.
enum class Carries : std::uint8_t {
    same,  ///< that frame, byte by byte
    sbus,  ///< the same channels as SBUS
};

/// The bytes of one frame.
struct WireFrame {
    std::array<std::uint8_t, kLongestSerialFrame> bytes{};
    std::size_t length = 0;

    bool operator==(const WireFrame&) const = default;
};

/// Channels that tell a number, and in each channel something of it.
ChannelFrame numbered_channels(std::uint32_t number);
/// An i.Bus frame of 18 channels that does, so that a frame made of two is none.
WireFrame numbered_ibus_frame(std::uint32_t number);
/// The same as it comes out.
WireFrame numbered_frame(std::uint32_t number, Carries carries);

/// What a lane has seen. Only ever incremented.
struct LaneCounts {
    std::uint64_t sent = 0;
    std::uint64_t arrived = 0;
    std::uint64_t repeated = 0;  ///< the frame before, once more
    std::uint64_t torn = 0;      ///< bytes that are neither
};

/// One way through a subject: two ptys, whose far ends it holds. Allocates nothing after `open`.
class Lane {
  public:
    static tl::expected<Lane, std::string> open(Carries carries);

    const std::string& in_path() const { return in_.path; }
    const std::string& out_path() const { return out_.path; }
    /// Becomes readable when something has come out.
    int out_descriptor() const { return out_.master.get(); }

    /// Sends the next frame. False where the line takes none.
    bool send();
    /// Sends bytes that are no frame, but now and then begin like one; made from `seed`.
    void send_garbage(std::size_t count, std::uint32_t seed);
    /// Reads what has come out. True when the frame that was sent last has now arrived whole.
    bool receive();
    /// Just before the bytes of the frame that was sent last were written.
    Instant sent_at() const { return sent_at_; }
    bool outstanding() const { return outstanding_; }
    /// The frame that was sent last is not waited for any longer.
    void give_up() { outstanding_ = false; }
    /// Throws away what has come out.
    void drain();
    /// Forgets the counts so far.
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
