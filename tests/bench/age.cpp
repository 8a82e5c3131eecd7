#include "tests/bench/age.h"

#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "pipelines/realtime/clock.h"
#include "tests/bench/tester.h"
#include "transports/codecs/ibus/ibus.h"

namespace tribus::bench {
namespace {

/// As measured at a FlySky X6B. Not a whole number of milliseconds, so all phases occur.
constexpr Duration kReceiverPeriod = std::chrono::microseconds(7715);
/// More than an output's schedule needs to find its phase.
constexpr std::size_t kWarmUpFrames = 100;

struct Schedules {
    const char* name;
    const char* text;
};
constexpr std::array<Schedules, 3> kSchedules{{
    {"follow", "schedule = \"follow\"\n"},
    {"locked", "schedule = \"grid\"\nphase = \"locked\"\n"},
    {"free", "schedule = \"grid\"\nphase = \"free\"\n"},
}};

std::string configuration(const Pty& in, const std::vector<Pty>& outs,
                          const ApplianceSettings& settings) {
    std::string text = runtime_text(settings);
    text += fmt::format("[input.receiver]\nprotocol = \"ibus\"\ndevice = \"{}\"\n", in.path);
    for (std::size_t i = 0; i < kSchedules.size(); ++i) {
        text += fmt::format(
            "[output.{}]\nprotocol = \"ibus\"\nchannels = 18\nperiod = \"7ms\"\ndevice = "
            "\"{}\"\n{}",
            kSchedules[i].name, outs[i].path, kSchedules[i].text);
    }
    return text +
           "[pipeline.main]\nfrom = \"receiver\"\nto = [\"follow\", \"locked\", \"free\"]\n"
           "[pipeline.main.failsafe]\nrecover = \"0ms\"\n";
}

/// Receives and recognises the frames of one output.
class FrameReceiver {
  public:
    FrameReceiver(int descriptor, std::size_t most) : descriptor_(descriptor) {
        ages_.reserve(most);
    }

    int descriptor() const { return descriptor_; }

    /// Frames are recognised by channels 1 and 2, which encode the number.
    void receive(const std::vector<Instant>& sent_at) {
        std::array<std::uint8_t, 256> buffer{};
        const ssize_t count = ::read(descriptor_, buffer.data(), buffer.size());
        const Instant now = monotonic_now();
        std::span<const std::uint8_t> bytes(buffer.data(),
                                            count > 0 ? static_cast<std::size_t>(count) : 0);
        DecodedFrame frame;
        while (decoder_.next(bytes, now, frame)) {
            note(frame.channels, sent_at, now);
        }
    }

    Distribution ages() { return Distribution(std::move(ages_)); }

  private:
    void note(const ChannelFrame& frame, const std::vector<Instant>& sent_at, Instant now) {
        for (std::size_t number = sent_at.size(); number-- > seen_;) {
            const auto sticks = numbered_channels(static_cast<std::uint32_t>(number));
            if (sticks.channel(0) == frame.channel(0) && sticks.channel(1) == frame.channel(1)) {
                seen_ = number + 1;
                if (number >= kWarmUpFrames) {
                    ages_.push_back(now - sent_at[number]);
                }
                return;
            }
        }
    }

    int descriptor_;
    IbusDecoder decoder_;
    std::size_t seen_ = 0;
    std::vector<Duration> ages_;
};

void receive_until(std::array<std::optional<FrameReceiver>, 3>& receivers,
                   const std::vector<Instant>& sent_at, Instant end) {
    Instant now = monotonic_now();
    while (now < end) {
        std::array<pollfd, 3> waits{};
        for (std::size_t i = 0; i < waits.size(); ++i) {
            waits[i] = {.fd = receivers[i]->descriptor(), .events = POLLIN, .revents = 0};
        }
        const timespec timeout = as_timespec(end - now);
        ::ppoll(waits.data(), waits.size(), &timeout, nullptr);
        for (std::size_t i = 0; i < waits.size(); ++i) {
            if (waits[i].revents != 0) {
                receivers[i]->receive(sent_at);
            }
        }
        now = monotonic_now();
    }
}

}  // namespace

tl::expected<AgeResult, std::string> measure_age(const ApplianceSettings& settings,
                                                 Duration length) {
    auto in = Pty::open();
    std::vector<Pty> outs;
    for (std::size_t i = 0; i < kSchedules.size(); ++i) {
        auto out = Pty::open();
        if (!in || !out) {
            return tl::unexpected(in ? out.error() : in.error());
        }
        outs.push_back(std::move(*out));
    }
    auto process = run_configuration(configuration(*in, outs, settings), settings);
    if (!process) {
        return tl::unexpected(process.error());
    }
    if (auto started = wait_until_started(*process); !started) {
        return tl::unexpected(started.error());
    }
    const auto frames = kWarmUpFrames + static_cast<std::size_t>(length / kReceiverPeriod);
    std::array<std::optional<FrameReceiver>, 3> receivers;
    for (std::size_t i = 0; i < receivers.size(); ++i) {
        receivers[i].emplace(outs[i].master.get(), frames);
    }
    std::vector<Instant> sent_at;
    sent_at.reserve(frames);
    const TesterPriority priority;
    Instant next = monotonic_now() + kReceiverPeriod;
    while (sent_at.size() < frames && !interrupted()) {
        const WireFrame frame = numbered_ibus_frame(static_cast<std::uint32_t>(sent_at.size()));
        receive_until(receivers, sent_at, next);
        sent_at.push_back(monotonic_now());
        [[maybe_unused]] const auto taken =
            ::write(in->master.get(), frame.bytes.data(), frame.length);
        next += kReceiverPeriod;
    }
    receive_until(receivers, sent_at, next + kReceiverPeriod);
    return AgeResult{receivers[0]->ages(), receivers[1]->ages(), receivers[2]->ages()};
}

}  // namespace tribus::bench
