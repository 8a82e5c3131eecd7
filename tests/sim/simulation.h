#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "config/schema/schema.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/links/twins/faulty_link.h"

namespace tribus::test {

/// Reads the configuration in `text`, which must be free of mistakes.
Configuration configuration_of(const std::string& text);

/// The nine lines of the README with these output lines.
std::string main_job(const std::string& output_lines = "period = \"7ms\"");

/// What a sender does for a while instead of sending fresh frames.
enum class SpellKind : std::uint8_t {
    silence,
    frozen,          ///< the last fresh frame again and again
    frame_lost,      ///< the same, marked frame-lost; frozen where the protocol has no flag
    failsafe,        ///< the same, marked failsafe
    garbage,         ///< bytes that are no frame
    fewer_channels,  ///< fresh frames with the first few channels; silence where impossible
    unplugged,       ///< silence from the middle of a frame on; the device is lost and comes back
};
/// How a serial port delivers the bytes of its line.
enum class Delivery : std::uint8_t {
    frames,  ///< all bytes of a frame after its last one
    bytes,   ///< each byte as soon as it has come
    lumps,   ///< eight bytes at a time, the rest after a frame's last byte (a FIFO)
};
struct Spell {
    Instant from;
    Instant until;
    SpellKind kind = SpellKind::silence;
    std::size_t channels = 3;  ///< number of channels of `fewer_channels`
};

/// A transmitter and receiver that send numbered frames: i.Bus or SBUS over a faulty wire, or the
/// native format over a bus where `drop_frame` is the probability that a CAN frame is lost.
struct Sender {
    std::size_t input = 0;
    std::string protocol = "ibus";
    Delivery delivery = Delivery::frames;
    Duration period = std::chrono::microseconds(7700);
    Instant first{};
    Instant last{};  ///< no frame from here on
    Instant faults_end = kNever;
    FaultSettings faults{};
    std::vector<Spell> spells{};  ///< in the order of time
    std::uint32_t first_number = 0;
};

/// One frame that an output wrote.
struct Written {
    Instant at;
    ChannelFrame frame;
    /// Number of the sender's frame that has these values, if there is one.
    std::optional<std::uint32_t> number;
};

/// One snapshot that an output wrote to a CAN interface.
struct WrittenToCan {
    Instant at;
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    std::size_t count = 0;
};

/// Returns a frame with its number in the first three channels. The third is a check of the other
/// two, so that faults do not make up a number. Channels 4 to 18 also differ from frame to frame,
/// so a mix of two frames is noticed.
ChannelFrame numbered_frame(std::uint32_t number);
std::optional<std::uint32_t> number_of(const ChannelFrame& frame);

/// Runs the whole engine under virtual time. All memory is allocated before the start.
class Simulation final : public StationObserver {
  public:
    Simulation(const Configuration& configuration, std::vector<Sender> senders, std::uint64_t seed);

    void run_until(Instant until);
    /// Reads the same configuration again: a new engine goes on where this one stops.
    void reload(const Configuration& unchanged, Instant at);
    /// Stops the data thread from `since` to `until`. Bytes that arrive meanwhile wait until the
    /// thread runs again.
    void stall(Instant since, Instant until);
    /// Delivers a CAN frame to an input after everything that comes before `at`.
    void receive(std::size_t input, const CanFrame& frame, Instant at);

    /// Returns whether the thread was stopped at some time in between.
    bool stalled_between(Instant from, Instant until) const;
    const Engine& engine() const { return *engine_; }
    const std::vector<Written>& written(std::size_t output = 0) const { return written_[output]; }
    const std::vector<WrittenToCan>& written_to_can(std::size_t output = 0) const {
        return written_to_can_[output];
    }
    /// Returns when the last byte of a sender's frame arrived, or nothing if it was dropped or not
    /// yet sent. On CAN, where a reader that doubts the sender ignores whole snapshots: when a
    /// reader without doubt first had its values.
    std::optional<Instant> arrived_at(std::size_t sender, std::uint32_t number) const;
    /// Returns when the first undamaged frame with these values arrived, or nothing if none did. A
    /// frozen sender sends the same values again.
    std::optional<Instant> arrived_whole_at(std::size_t sender, std::uint32_t number) const;
    std::uint32_t frames_sent(std::size_t sender) const { return wires_[sender].next_number; }
    /// Allocations inside the engine since it started.
    std::uint64_t allocations() const { return allocations_; }

    void wrote(Station station, Instant at, const Transmission& sent) override;

  private:
    struct Wire {
        Sender sender;
        FrameEncoder encoder;
        std::unique_ptr<CanDecoder> can_witness;  ///< receives what the input receives
        LineSettings line;
        FaultInjector faults;
        std::uint32_t next_number = 0;
        std::uint32_t latest_number = 0;
        /// When the next piece of the frame on the wire is delivered, and when its last piece is.
        Instant next_arrival = kNever;
        Instant frame_begins{};
        Instant frame_ends{};
        Instant latest_arrival{};
        Reception reception{};
        std::size_t handed_over = 0;
        /// The device was unplugged in the middle of the frame on the wire, and is not back yet.
        bool pulled = false;
        bool unplugged = false;
        std::array<CanFrame, kMostSnapshotFrames> can_frames{};
        std::size_t can_count = 0;
        bool dropped = false;
        bool hurt = false;
        std::vector<Instant> arrivals{};
        std::vector<Instant> whole_arrivals{};
    };
    struct NextFrame {
        ChannelFrame frame;
        std::optional<SpellKind> spell{};
    };
    void plan(Wire& wire);
    static std::optional<NextFrame> next_frame(Wire& wire, Instant at);
    static Duration put_on_line(Wire& wire, const std::optional<NextFrame>& next, Instant at);
    static Duration put_on_bus(Wire& wire, const std::optional<NextFrame>& next, Instant at);
    static std::size_t next_piece(const Wire& wire);
    static void plan_piece(Wire& wire);
    void deliver(Wire& wire);
    void deliver_frames(Wire& wire);
    void deliver_piece(Wire& wire);
    void deliver_until(Instant until);
    bool discards(const Wire& wire) const;
    void lose_device(Wire& wire);
    static void witness(Wire& wire, const CanFrame& frame);
    Wire* next_wire();
    std::optional<ChannelFrame> heard(std::size_t output, Instant at, const Transmission& sent);

    std::unique_ptr<Engine> engine_;
    std::vector<std::unique_ptr<ByteDecoder>> readers_;
    std::vector<std::unique_ptr<CanDecoder>> can_readers_;  ///< readers of the native format
    std::vector<std::vector<Written>> written_;
    std::vector<std::vector<WrittenToCan>> written_to_can_;
    std::vector<Wire> wires_;
    std::uint64_t allocations_ = 0;
    std::optional<VirtualLoop> loop_;
    /// Start and length of the time in which the thread does not run.
    std::optional<Instant> away_since_;
    Duration away_for_{};
    struct Absence {
        Instant since;
        Instant until;
    };
    std::vector<Absence> absences_;
};

/// Returns a command that runs the current test again with this seed.
std::string replay_command(std::uint64_t seed);

/// The first and the last seed.
struct Seeds {
    std::uint64_t first = 1;
    std::uint64_t last = 1;
};
/// Returns 1 to `usual`, or the seeds in the environment's TRIBUS_SEED: one seed, or FIRST-LAST.
Seeds seeds_or(std::uint64_t usual);

/// Calls `check` for each seed until the test fails.
template <class Check>
void for_each_seed(std::uint64_t usual, Check check) {
    const Seeds seeds = seeds_or(usual);
    for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
        SCOPED_TRACE(replay_command(seed));
        check(seed);
        if (testing::Test::HasFailure()) {
            return;
        }
    }
}

}  // namespace tribus::test
