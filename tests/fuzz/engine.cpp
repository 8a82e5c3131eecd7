#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/load.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/heap_trap.h"
#include "transports/codecs/line_pauses.h"

namespace tribus::fuzz::engine_target {
namespace {

constexpr Duration kTimeout = std::chrono::milliseconds(100);
constexpr Duration kHold = std::chrono::milliseconds(200);
constexpr Duration kPeriod = std::chrono::milliseconds(10);

/// Inputs of three kinds. Each output may follow any of them. Only the selection mode differs. No
/// test sends the values of the presets.
std::string configuration_text(std::string_view mode) {
    return R"(
[input.ibus]
protocol = "ibus"
device = "/dev/a"
timeout = "100ms"
[input.sbus]
protocol = "sbus"
device = "/dev/b"
timeout = "100ms"
[input.can]
protocol = "can"
interface = "can0"
timeout = "100ms"
[output.sbus]
protocol = "sbus"
device = "/dev/c"
period = "10ms"
[output.ibus]
protocol = "ibus"
device = "/dev/d"
period = "10ms"
[output.can]
protocol = "can"
interface = "can1"
period = "10ms"
[pipeline.main]
from = ["ibus", "sbus", "can"]
to = ["sbus", "ibus", "can"]
mode = ")" +
           std::string(mode) +
           R"("
[pipeline.main.failsafe]
hold = "200ms"
recover = "50ms"
power_on = "20ms"
preset = { 1 = 1111, 3 = 999, other = 1333 }
)";
}

std::vector<Configuration> configurations() {
    std::vector<Configuration> loaded;
    for (const std::string_view mode : {"priority", "sticky", "freshest", "median"}) {
        auto configuration = load_configuration(configuration_text(mode), "fuzz.toml");
        require(configuration.has_value(), "the target's own configuration is valid");
        loaded.push_back(std::move(*configuration));
    }
    return loaded;
}

bool is_preset(const ChannelFrame& frame) {
    return frame.channel(0) == Pulse::from_microseconds(1111) &&
           frame.channel(2) == Pulse::from_microseconds(999);
}

constexpr std::size_t kMostSteps = 400;
constexpr std::size_t kMostBytesOfStep = 64;

/// Reads what outputs write, and records when inputs last received good values, both with decoders
/// of its own.
class Witness final : public StationObserver {
  public:
    explicit Witness(const Configuration& configuration) : configuration_(configuration) {
        for (const InputConfig& input : configuration.inputs) {
            ears_.push_back(make_ear(*input.protocol, input.settings));
            if (ears_.back().serial) {
                ears_.back().pauses.emplace(input.port.line.bytes_time(1));
            }
        }
        for (const OutputConfig& output : configuration.outputs) {
            readers_.push_back(make_ear(*output.protocol, {}));
        }
    }

    void heard(std::size_t input, std::span<const std::uint8_t> bytes, Instant at) {
        Ear& ear = ears_[input];
        if (ear.pauses->before(bytes.size(), at, ear.serial->waiting())) {
            listen_to_pause(ear);
        }
        ear.read_at.insert(ear.read_at.end(), bytes.size(), at);
        listen(ear, bytes, at);
    }
    /// A frame that waited for the bytes after it may come out after the damage.
    void damaged(std::size_t input, Instant at) {
        Ear& ear = ears_[input];
        if (ear.pauses->before(1, at, ear.serial->waiting())) {
            listen_to_pause(ear);
        }
        ear.read_at.push_back(at);
        ear.serial->damaged_byte();
        listen(ear, {}, at);
    }
    void lost(std::size_t input) {
        if (ears_[input].serial) {
            ears_[input].serial->reset();
            ears_[input].pauses->forget();
        }
    }
    void heard(std::size_t input, const CanFrame& frame, Instant at) {
        const auto snapshot = ears_[input].can->next(frame, at);
        if (snapshot && snapshot->good()) {
            note_good(at);
        }
    }

    void wrote(Station station, Instant at, const Transmission& sent) override {
        if (station.kind != StationKind::output) {
            return;
        }
        const std::size_t output = station.index;
        std::optional<ChannelFrame> frame;
        if (!sent.bytes().empty()) {
            frame = latest_of(readers_[output], sent.bytes(), at);
            // A reader that is in step finds each frame. The first frames bring it into step.
            readers_[output].frames += frame ? 1U : 0U;
            require(frame || readers_[output].frames == 0, "every frame that is written is valid");
        }
        for (const CanFrame& part : sent.can_frames()) {
            if (const auto whole = readers_[output].can->next(part, at)) {
                frame = whole;
            }
        }
        if (frame && frame->good() && !is_preset(*frame)) {
            const bool marks = configuration_.outputs[output].protocol->name != "ibus";
            const Duration bound = kTimeout + (marks ? Duration::zero() : kHold) + 2 * kPeriod;
            require(good_at_ && at - *good_at_ <= bound,
                    "no output says as good what no input has said for longer than it may");
        }
    }
    void polled(Instant /*at*/) override { ++turns_; }
    std::size_t turns() const { return turns_; }

  private:
    struct Ear {
        std::unique_ptr<ByteDecoder> serial;
        std::unique_ptr<CanDecoder> can;
        std::optional<LinePauses> pauses;  ///< pauses of an input's line
        std::size_t frames = 0;
        std::vector<Instant> read_at;  ///< when each byte was read
    };
    static Ear make_ear(const Protocol& protocol, const SettingValues& settings) {
        Ear ear;
        if (protocol.shape == WireShape::bytes) {
            ear.serial = make_byte_decoder(protocol, settings);
            ear.read_at.reserve(kMostSteps * kMostBytesOfStep);
        } else {
            ear.can = make_can_decoder(protocol, settings);
        }
        return ear;
    }
    /// A frame is as old as its last byte, whatever it waited for.
    void listen(Ear& ear, std::span<const std::uint8_t> bytes, Instant at) {
        DecodedFrame frame;
        while (ear.serial->next(bytes, at, frame)) {
            note(ear, frame);
        }
    }
    void listen_to_pause(Ear& ear) {
        DecodedFrame frame;
        while (ear.serial->silence(frame)) {
            note(ear, frame);
        }
    }
    void note(Ear& ear, const DecodedFrame& frame) {
        if (ear.pauses) {
            ear.pauses->frame_came(frame.first_byte, frame.length);
        }
        if (frame.channels.good()) {
            note_good(ear.read_at[frame.first_byte + frame.length - 1]);
        }
    }
    static std::optional<ChannelFrame> latest_of(Ear& ear, std::span<const std::uint8_t> bytes,
                                                 Instant at) {
        std::optional<ChannelFrame> latest;
        DecodedFrame frame;
        while (ear.serial->next(bytes, at, frame)) {
            if (!latest || frame.channels.good()) {
                latest = frame.channels;
            }
        }
        return latest;
    }
    void note_good(Instant at) { good_at_ = std::max(good_at_.value_or(at), at); }

    const Configuration& configuration_;
    std::vector<Ear> ears_;
    std::vector<Ear> readers_;
    std::optional<Instant> good_at_;
    std::size_t turns_ = 0;
};

struct OneDamaged {
    bool operator[](std::size_t /*position*/) const { return true; }
};

/// Performs the steps in the input on one engine. Each step is an operation, its time and its data.
class Play {
  public:
    Play(const Configuration& configuration, Input& script)
        : configuration_(configuration),
          script_(script),
          witness_(configuration),
          engine_(build_engine(configuration)) {
        for (const InputConfig& input : configuration.inputs) {
            encoders_.emplace_back(input.protocol->make_encoder(input.settings));
        }
        loop_.emplace(*engine_, witness_, Instant(std::chrono::seconds(1)));
    }

    void run() {
        for (std::size_t step = 0; step < kMostSteps && !script_.empty(); ++step) {
            const std::size_t input = script_.below(configuration_.inputs.size());
            const std::uint8_t operation = script_.byte();
            advance(script_.byte());
            if (operation < 150) {
                say_frame(input, operation);
            } else if (operation < 200) {
                say_bytes(input);
            } else if (operation < 220) {
                damage(input);
            } else if (operation < 230) {
                witness_.lost(input);
                engine_->device_lost(input);
            } else if (operation < 240) {
                be_silent();
            } else {
                say_can_frame();
            }
        }
        be_silent();
    }

  private:
    /// Advances time by up to 64 ms.
    void advance(std::uint8_t quarters_of_ms) {
        const std::size_t before = witness_.turns();
        const Duration time = std::chrono::microseconds(quarters_of_ms) * 250;
        loop_->run_until(later(loop_->now(), time));
        // Three outputs, each at most once in a period, and twice at its start.
        constexpr std::size_t kTurnsOfPeriod = 3;
        const auto periods = static_cast<std::size_t>(time / kPeriod) + 2;
        require(witness_.turns() - before <= periods * kTurnsOfPeriod,
                "no more turns than periods have passed");
    }

    /// Lasts twice as long as timeout and hold.
    void be_silent() {
        for (int i = 0; i < 10; ++i) {
            advance(0xFF);
        }
    }

    ChannelFrame sticks(std::uint8_t kind) {
        ChannelFrame frame;
        frame.frame_lost = kind % 16 == 1;
        frame.failsafe = kind % 16 == 2;
        const std::uint8_t base = script_.byte();
        for (std::size_t channel = 0; channel < 16; ++channel) {
            frame.set(channel,
                      Pulse::from_microseconds(1400 + static_cast<std::int64_t>(base) % 100 +
                                               static_cast<std::int64_t>(channel)));
        }
        return frame;
    }
    void say_frame(std::size_t input, std::uint8_t kind) {
        ChannelFrame frame = sticks(kind);
        frame.received = loop_->now();
        const Transmission sent = encoders_[input].encode(frame, loop_->now());
        if (!sent.bytes().empty()) {
            say(input, sent.bytes());
        }
        for (const CanFrame& part : sent.can_frames()) {
            say(input, part);
        }
    }
    void say_bytes(std::size_t input) {
        const auto bytes = script_.take(script_.byte() % 40);
        if (!encoders_[input].on_can()) {
            say(input, bytes);
        }
    }
    void say_can_frame() {
        CanFrame frame;
        frame.id = 0x300 + script_.byte() % 8;
        const auto content = script_.take(kMostClassicBytes);
        std::ranges::copy(content, frame.data.begin());
        frame.length = static_cast<std::uint8_t>(content.size());
        say(configuration_.inputs.size() - 1, frame);
    }
    void damage(std::size_t input) {
        if (!encoders_[input].on_can()) {
            witness_.damaged(input, loop_->now());
            constexpr std::array<std::uint8_t, 1> kByte{0};
            loop_->receive(input_station(input), kByte, OneDamaged{}, loop_->now());
        }
    }
    /// The witness receives it first, because the engine may write its values at once.
    void say(std::size_t input, std::span<const std::uint8_t> bytes) {
        witness_.heard(input, bytes, loop_->now());
        loop_->receive(input_station(input), bytes, loop_->now());
    }
    void say(std::size_t input, const CanFrame& frame) {
        witness_.heard(input, frame, loop_->now());
        loop_->receive(input_station(input), frame, loop_->now());
    }

    const Configuration& configuration_;
    Input& script_;
    Witness witness_;
    std::unique_ptr<Engine> engine_;
    std::vector<FrameEncoder> encoders_;
    std::optional<VirtualLoop> loop_;
};

}  // namespace

/// Whatever reaches the inputs at any time: outputs write only valid frames, mark values as stale
/// once no input has sent them for too long, take no turn too many, and allocate nothing.
FUZZ_TARGET(engine) {
    static const auto loaded = configurations();
    Input script({data, size});
    Play play(loaded[script.below(loaded.size())], script);
    const tribus::test::HeapTrap trap;
    play.run();
    require(trap.allocations() == 0, "nothing is allocated after the start");
    return 0;
}

}  // namespace tribus::fuzz::engine_target
