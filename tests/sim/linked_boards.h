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

/// One box in virtual time. It keeps what its outputs sent since `take`. `epoch`: the file of its
/// link, if receivers do not answer; it is written at once.
class Board : StationObserver {
  public:
    Board(const Configuration& configuration, Instant start, StoredNumbers& epoch)
        : epoch_(epoch),
          engine_(build_engine(
              configuration, {},
              {.random = next_seed, .numbers = [&](const std::string&) { return &epoch; }})),
          loop_(*engine_, *this, start) {
        epoch.start(start);
    }

    void run_until(Instant until) {
        loop_.run_until(until);
        epoch_.store();
    }
    /// A datagram for an input arrives. Returns what its sender is answered.
    Bytes receive(const Bytes& datagram, Instant now, std::size_t input = 0) {
        loop_.receive({StationKind::input, input}, datagram, now);
        engine_->datagram_ended(input, now);
        const auto answer = engine_->answer(input, now).bytes();
        return {answer.begin(), answer.end()};
    }
    void hear(const Bytes& datagram, Instant now) {
        loop_.receive({StationKind::replies, 0}, datagram, now);
    }
    std::vector<Bytes> take(std::size_t output = 0) { return std::exchange(sent_[output], {}); }

  private:
    void wrote(Station station, Instant /*at*/, const Transmission& sent) override {
        sent_[station.index].emplace_back(sent.bytes().begin(), sent.bytes().end());
    }

    StoredNumbers& epoch_;
    std::unique_ptr<Engine> engine_;
    std::array<std::vector<Bytes>, 2> sent_;
    VirtualLoop loop_;
};

inline Configuration load(const std::string& text) {
    auto configuration = load_configuration(text, "boards.toml");
    EXPECT_TRUE(configuration) << text;
    return std::move(*configuration);
}

/// The line of a link whose receivers do not answer.
inline const std::string kEpochLine = "epoch = \"/of/the/board\"\n";

/// The configurations of both boards. `lines`: of both ends of the link between them.
struct Boards {
    explicit Boards(const std::string& lines) : epoch(lines.ends_with(kEpochLine)) {
        const std::string link = "protocol = \"network\"\naddress = \"127.0.0.1:5700\"\n" + lines;
        shore = load("[input.radio]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyA\"\n[output.boat]\n" +
                     link + "[pipeline.main]\nfrom = \"radio\"\nto = \"boat\"\n" + kSilence);
        boat = load("[input.shore]\n" + link + kServos);
    }

    /// Outputs and pipelines end in silence.
    inline static const std::string kSilence =
        "[pipeline.main.failsafe]\naction = \"silence\"\npower_on = \"0ms\"\nrecover = \"100ms\"\n";
    inline static const std::string kServos =
        "timeout = \"" + std::to_string(kTimeout) +
        "ms\"\n[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/ttyB\"\n"
        "[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n" +
        kSilence;
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
