#pragma once

#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/load.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/reference/plain_sbus.h"
#include "tests/support/ibus_frames.h"
#include "tests/support/stored_numbers.h"
#include "tests/support/streams.h"
#include "tests/support/temporary_folder.h"

/// Two boards in virtual time, an i.Bus receiver at one and SBUS servos at the other, and a link
/// between them for others to attack. Sticks carry the time in ms, in two channels of 0 to 999
/// above 1000 us, and who sent them in a third one.
namespace tribus::test::linked_boards {

using namespace std::chrono_literals;

inline constexpr int kStickPeriod = 8;  ///< ms
inline constexpr int kTimeout = 500;    ///< ms
inline constexpr int kHonest = 1200;
inline constexpr int kForged = 1900;

inline Instant at(int milliseconds) {
    return Instant(1h) + std::chrono::milliseconds(milliseconds);
}

inline Bytes sticks(int time, int mark) {
    Bytes payload(28);
    const auto put = [&](std::size_t slot, int pulse) {
        payload[2 * slot] = static_cast<std::uint8_t>(pulse);
        payload[2 * slot + 1] = static_cast<std::uint8_t>(pulse >> 8);
    };
    for (std::size_t slot = 0; slot < 14; ++slot) {
        put(slot, 1500);
    }
    put(0, 1000 + time / 1000);
    put(1, 1000 + time % 1000);
    put(2, mark);
    return servo_frame(payload, 0x40);
}

/// One SBUS frame, as servos read it.
struct Seen {
    bool marked = false;
    int time = 0;
    int mark = 0;
};

inline Seen seen_in(std::span<const std::uint8_t> wire) {
    const SbusFrame frame = reference::plain_parse_sbus(wire.first<kSbusFrameLength>());
    // Betaflight's scale, docs/protocols/sbus.md.
    const auto pulse = [&](std::size_t channel) {
        return static_cast<int>(std::lround(880 + frame.raw[channel] * 0.625));
    };
    return {frame.failsafe || frame.frame_lost, 1000 * (pulse(0) - 1000) + pulse(1) - 1000,
            pulse(2)};
}

inline RandomSeed next_seed() {
    static std::uint32_t made = 0;
    ++made;
    return {static_cast<std::uint8_t>(made), static_cast<std::uint8_t>(made >> 8U),
            static_cast<std::uint8_t>(made >> 16U), 1};
}

/// What an output said: a datagram, or frames.
struct LinkMessage {
    Bytes datagram;
    std::vector<CanFrame> frames;
};

/// One box in virtual time. It keeps what its outputs sent since `take`. `epoch`: the file of its
/// link, if receivers do not answer; it is written at once.
class Board : StationObserver {
  public:
    Board(const Configuration& configuration, Instant start, StoredNumbers& epoch)
        : epoch_(epoch),
          configuration_(configuration),
          engine_(build(configuration)),
          loop_(*engine_, *this, start) {
        epoch.start(start);
    }

    void run_until(Instant until) {
        loop_.run_until(until);
        epoch_.store();
    }
    /// A datagram for an input arrives. Returns what its sender is answered.
    Bytes receive(const Bytes& datagram, Instant now, std::size_t input = 0) {
        loop_.receive(input_station(input), datagram, now);
        engine_->datagram_ended(input, now);
        return said_by(engine_->answer(input, now)).datagram;
    }
    /// The same for what another board said to its first input, on any medium.
    std::vector<LinkMessage> receive(const LinkMessage& said, Instant now) {
        std::vector<LinkMessage> answers;
        if (!said.datagram.empty()) {
            answers.push_back({receive(said.datagram, now), {}});
        }
        for (const CanFrame& frame : said.frames) {
            loop_.receive(input_station(0), frame, now);
            answers.push_back(said_by(engine_->answer(0, now)));
        }
        std::erase_if(answers, [](const LinkMessage& answer) {
            return answer.datagram.empty() && answer.frames.empty();
        });
        return answers;
    }
    /// Its first output is answered.
    void hear(const Bytes& datagram, Instant now) { loop_.receive(kReplies, datagram, now); }
    void hear(const LinkMessage& answer, Instant now) {
        if (!answer.datagram.empty()) {
            hear(answer.datagram, now);
        }
        for (const CanFrame& frame : answer.frames) {
            loop_.receive(kReplies, frame, now);
        }
    }
    std::vector<LinkMessage> take_all(std::size_t output = 0) {
        return std::exchange(sent_[output], {});
    }
    /// The same of an output that sends datagrams or bytes.
    std::vector<Bytes> take(std::size_t output = 0) {
        std::vector<Bytes> datagrams;
        for (LinkMessage& said : take_all(output)) {
            datagrams.push_back(std::move(said.datagram));
        }
        return datagrams;
    }

    /// Ends in order. Its last frames wait to be taken.
    void end(Instant now) {
        loop_.end(now);
        epoch_.stop();
    }
    void reload(const Configuration& fresh, Instant now) {
        auto next = build(fresh);
        const CarryOver plan = plan_carry_over(configuration_, fresh);
        next->start(now);
        next->continue_from(*engine_, plan.engine, now);
        loop_.go_on_with(*next, nullptr, now);
        engine_ = std::move(next);
        configuration_ = fresh;
    }
    /// It did not run since `since`; its machine's clock went on to `until` meanwhile.
    void wake(Instant since, Instant until) { loop_.come_back(since, until); }

  private:
    static constexpr Station kReplies{StationKind::replies, 0};

    static LinkMessage said_by(const Transmission& sent) {
        return {{sent.bytes().begin(), sent.bytes().end()},
                {sent.can_frames().begin(), sent.can_frames().end()}};
    }
    void wrote(Station station, Instant /*at*/, const Transmission& sent) override {
        sent_[station.index].push_back(said_by(sent));
    }
    std::unique_ptr<Engine> build(const Configuration& configuration) const {
        return build_engine(
            configuration, {},
            {.random = next_seed, .numbers = [this](const std::string&) { return &epoch_; }});
    }

    StoredNumbers& epoch_;
    Configuration configuration_;
    std::unique_ptr<Engine> engine_;
    std::array<std::vector<LinkMessage>, 2> sent_;
    VirtualLoop loop_;
};

inline Configuration load(const std::string& text) {
    auto configuration = load_configuration(text, "boards.toml");
    EXPECT_TRUE(configuration) << text;
    return std::move(*configuration);
}

/// The line of a link whose receivers do not answer.
inline const std::string kEpochLine = "epoch = \"/of/the/board\"\n";

/// The lines of a link over UDP, without its key.
inline constexpr const char* kUdp = "protocol = \"network\"\naddress = \"127.0.0.1:5700\"\n";

/// Outputs and pipelines end in silence.
inline const std::string kSilence =
    "[pipeline.main.failsafe]\naction = \"silence\"\npower_on = \"0ms\"\nrecover = \"100ms\"\n";

/// The configuration of the shore. `link`: the lines of its end. `failsafe`: of its pipeline.
inline Configuration shore_with(const std::string& link, const std::string& failsafe = "") {
    return load("[input.radio]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n[output.boat]\n" +
                link + "[pipeline.main]\nfrom = \"radio\"\nto = \"boat\"\n" + failsafe);
}
/// The same of the boat.
inline Configuration boat_with(const std::string& link, const std::string& failsafe = "") {
    return load("[input.shore]\n" + link + "timeout = \"" + std::to_string(kTimeout) +
                "ms\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
                "[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n" +
                failsafe);
}

/// Both boards with a link over UDP. `lines`: of both ends of it.
struct Boards {
    explicit Boards(const std::string& lines)
        : epoch(lines.ends_with(kEpochLine)),
          shore(shore_with(kUdp + lines, kSilence)),
          boat(boat_with(kUdp + lines, kSilence)) {}

    bool epoch;
    Configuration shore;
    Configuration boat;
};

/// A key of the boats and one of the attacker.
class KeyFiles {
  public:
    KeyFiles() {
        for (const auto& [name, digit] : {std::pair("boat.key", '7'), {"attacker.key", '8'}}) {
            std::filesystem::permissions(folder_.write(name, std::string(64, digit)),
                                         std::filesystem::perms::owner_read);
        }
    }
    /// The line of a configuration.
    std::string line(const std::string& name) const { return "key = \"" + folder_ / name + "\"\n"; }

  private:
    TemporaryFolder folder_;
};

}  // namespace tribus::test::linked_boards
