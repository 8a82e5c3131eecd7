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

#include "config/schema.h"
#include "core/can_frame.h"
#include "core/channel_frame.h"
#include "core/time.h"
#include "pipelines/engine.h"
#include "pipelines/virtual_loop.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/links/faulty_link.h"

namespace tribus::test {

/// The configuration in `text`, which must be free of mistakes.
Configuration configuration_of(const std::string& text);

/// The nine lines of the README with `period`.
std::string main_job(const std::string& output_lines = "period = \"7ms\"");

/// What a sender does for a while instead of sending fresh frames.
enum class SpellKind : std::uint8_t {
    silence,
    frozen,          ///< the frame before, again and again
    frame_lost,      ///< the same, marked frame-lost; where the wire has no flag: frozen
    failsafe,        ///< the same, marked failsafe
    garbage,         ///< bytes that are no frame
    fewer_channels,  ///< fresh frames of the first few; where the wire has no such frames: silence
    unplugged,       ///< nothing from within a frame on; the device is lost and comes back
};
/// How a serial port hands over what its line brings.
enum class Delivery : std::uint8_t {
    frames,  ///< all bytes of a frame behind its last one
    bytes,   ///< each byte when it has come
    lumps,   ///< eight bytes at a time, the rest behind a frame's last byte: the FIFO of a UART
};
struct Spell {
    Instant from;
    Instant until;
    SpellKind kind = SpellKind::silence;
    std::size_t channels = 3;  ///< of `fewer_channels`
};

/// A transmitter and receiver that send numbered frames of i.Bus or SBUS over a faulty wire, or of
/// the own format over a bus on which `drop_frame` is the chance of each CAN frame.
struct Sender {
    std::size_t input = 0;
    std::string protocol = "ibus";
    Delivery delivery = Delivery::frames;
    Duration period = std::chrono::microseconds(7700);
    Instant first{};
    Instant last{};  ///< no frame from here on
    Instant faults_end = kNever;
    FaultSettings faults{};
    std::vector<Spell> spells{};  ///< in order
    std::uint32_t first_number = 0;
};

/// One frame that an output wrote.
struct Written {
    Instant at;
    ChannelFrame frame;
    /// The number of the sender's frame whose values it carries, if it is one's.
    std::optional<std::uint32_t> number;
};

/// One snapshot that an output wrote to a CAN interface.
struct WrittenToCan {
    Instant at;
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    std::size_t count = 0;
};

/// A frame with its number in the first three channels, the third a check of the others, so that
/// a number that was made up by faults is not taken for one. Channels 4 to 18 differ from frame to
/// frame too, so that no part of one passes for that of another.
ChannelFrame numbered_frame(std::uint32_t number);
std::optional<std::uint32_t> number_of(const ChannelFrame& frame);

/// Runs the whole engine under virtual time. Everything is allocated before it starts.
class Simulation final : public OutputObserver {
  public:
    Simulation(const Configuration& configuration, std::vector<Sender> senders, std::uint64_t seed);

    void run_until(Instant until);
    /// The configuration that runs is read again: another engine goes on from this one.
    void reload(const Configuration& unchanged, Instant at);
    /// The thread does not run from `since` to `until`. What arrives meanwhile waits, and is read
    /// as the loop reads it.
    void stall(Instant since, Instant until);
    /// A CAN frame arrives at an input, after all that comes before `at`.
    void receive(std::size_t input, const CanFrame& frame, Instant at);

    /// The thread did not run at some time between these.
    bool stalled_between(Instant from, Instant until) const;
    const Engine& engine() const { return *engine_; }
    const std::vector<Written>& written(std::size_t output = 0) const { return written_[output]; }
    const std::vector<WrittenToCan>& written_to_can(std::size_t output = 0) const {
        return written_to_can_[output];
    }
    /// When the last byte of a sender's frame arrived; nothing if it was dropped or not yet sent.
    /// On CAN, where a reader that doubts the sender passes over whole snapshots, when one without
    /// doubt first had its values.
    std::optional<Instant> arrived_at(std::size_t sender, std::uint32_t number) const;
    /// When the first frame with its values arrived that nothing had hurt: a sender that froze says
    /// them again. Nothing where none did.
    std::optional<Instant> arrived_whole_at(std::size_t sender, std::uint32_t number) const;
    std::uint32_t frames_sent(std::size_t sender) const { return wires_[sender].next_number; }
    /// Allocations inside the engine since it started.
    std::uint64_t allocations() const { return allocations_; }

    void wrote(std::size_t output, Instant at, const Transmission& sent) override;

  private:
    struct Wire {
        Sender sender;
        std::unique_ptr<Encoder> encoder;
        std::unique_ptr<CanEncoder> can_encoder;
        std::unique_ptr<CanDecoder> can_witness;  ///< hears what the input hears
        LineSettings line;
        FaultInjector faults;
        std::uint32_t next_number = 0;
        std::uint32_t latest_number = 0;
        /// When the next piece of the frame on the wire is handed over, and its last one.
        Instant next_arrival = kNever;
        Instant frame_begins{};
        Instant frame_ends{};
        Instant latest_arrival{};
        Reception reception{};
        std::size_t handed_over = 0;
        /// The device was pulled within the frame on the wire, and is not back yet.
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
    std::vector<std::unique_ptr<Decoder>> readers_;
    std::vector<std::unique_ptr<CanDecoder>> can_readers_;  ///< of the own format
    std::vector<std::vector<Written>> written_;
    std::vector<std::vector<WrittenToCan>> written_to_can_;
    std::vector<Wire> wires_;
    std::uint64_t allocations_ = 0;
    std::optional<VirtualLoop> loop_;
    /// While the thread does not run: since when, and for how long.
    std::optional<Instant> away_since_;
    Duration away_for_{};
    struct Absence {
        Instant since;
        Instant until;
    };
    std::vector<Absence> absences_;
};

/// One command that runs the present test again with that seed.
std::string replay_command(std::uint64_t seed);

/// Both included.
struct Seeds {
    std::uint64_t first = 1;
    std::uint64_t last = 1;
};
/// 1 to `usual`, or what the environment's TRIBUS_SEED says: one seed, or FIRST-LAST.
Seeds seeds_or(std::uint64_t usual);

/// Until the first one with which the test fails.
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
