#include "tests/bench/lane.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <span>
#include <utility>

#include "pipelines/realtime/clock.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/sbus/sbus.h"

namespace tribus::bench {
namespace {

/// Without this, the line discipline would echo and wait for line ends until the subject sets the
/// terminal up.
bool make_raw(const std::string& path) {
    const UniqueFd near(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    termios settings{};
    if (!near.valid() || ::tcgetattr(near.get(), &settings) != 0) {
        return false;
    }
    ::cfmakeraw(&settings);
    return ::tcsetattr(near.get(), TCSANOW, &settings) == 0;
}

WireFrame encoded(ByteEncoder&& encoder, const ChannelFrame& channels) {
    WireFrame wire;
    wire.length = encoder.write(channels, wire.bytes, Instant{});
    return wire;
}

ChannelFrame first_14_of(ChannelFrame channels) {
    for (std::size_t channel = 14; channel < kChannelCount; ++channel) {
        channels.remove(channel);
    }
    return channels;
}

/// The channels as a reader of SBUS has them.
ChannelFrame read_from_sbus(const ChannelFrame& channels) {
    const WireFrame wire = encoded(SbusEncoder(), channels);
    std::span<const std::uint8_t> bytes(wire.bytes.data(), wire.length);
    SbusDecoder decoder;
    DecodedFrame decoded;
    decoder.next(bytes, Instant{}, decoded);
    // SBUS is decided by what follows.
    return decoder.finish().value_or(decoded).channels;
}

}  // namespace

ChannelFrame numbered_channels(std::uint32_t number) {
    // Two channels encode the number, in a range that every output carries.
    constexpr std::uint32_t kSteps = 1000;
    constexpr int kLeast = 1000;
    ChannelFrame frame;
    frame.frame_lost = false;
    frame.failsafe = false;
    for (std::size_t channel = 0; channel < kSbusChannels; ++channel) {
        const std::uint32_t high = number / kSteps;
        const auto mixed =
            number + static_cast<std::uint32_t>(channel) * 61 + (channel % 2 == 1 ? high * 7 : 0);
        frame.set(channel, Pulse::from_microseconds(kLeast + static_cast<int>(mixed % kSteps)));
    }
    frame.set(kSbusChannels, number % 2 == 0 ? kSwitchOffPulse : kSwitchOnPulse);
    frame.set(kSbusChannels + 1, number % 4 < 2 ? kSwitchOffPulse : kSwitchOnPulse);
    return frame;
}

WireFrame numbered_ibus_frame(std::uint32_t number) {
    return encoded(IbusEncoder(kChannelCount), numbered_channels(number));
}

WireFrame numbered_frame_in(std::uint32_t number, Carries carries) {
    switch (carries) {
        case Carries::sbus_of_14:
            return encoded(IbusEncoder(14), numbered_channels(number));
        case Carries::ibus_of_sbus:
            return encoded(SbusEncoder(), numbered_channels(number));
        case Carries::same:
        case Carries::sbus:
            break;
    }
    return numbered_ibus_frame(number);
}

WireFrame numbered_frame_out(std::uint32_t number, Carries carries) {
    const ChannelFrame channels = numbered_channels(number);
    switch (carries) {
        case Carries::same:
            break;
        case Carries::sbus:
            return encoded(SbusEncoder(), channels);
        case Carries::sbus_of_14:
            return encoded(SbusEncoder(), first_14_of(channels));
        case Carries::ibus_of_sbus:
            return encoded(IbusEncoder(kChannelCount), read_from_sbus(channels));
    }
    return numbered_ibus_frame(number);
}

Lane::Lane(Pty in, Pty out, Carries carries)
    : in_(std::move(in)), out_(std::move(out)), carries_(carries) {}

tl::expected<Lane, std::string> Lane::open(Carries carries) {
    auto in = Pty::open();
    auto out = Pty::open();
    if (!in || !out) {
        return tl::unexpected(in ? out.error() : in.error());
    }
    if (!make_raw(in->path) || !make_raw(out->path)) {
        return tl::unexpected("cannot set up " + in->path);
    }
    return Lane(std::move(*in), std::move(*out), carries);
}

bool Lane::send() {
    const WireFrame frame = numbered_frame_in(number_ + 1, carries_);
    const WireFrame expected = numbered_frame_out(number_ + 1, carries_);
    const Instant now = monotonic_now();
    const ssize_t taken = ::write(in_.master.get(), frame.bytes.data(), frame.length);
    if (taken != static_cast<ssize_t>(frame.length)) {
        return false;
    }
    ++number_;
    sent_at_ = now;
    before_ = expected_;
    expected_ = expected;
    outstanding_ = true;
    ++counts_.sent;
    return true;
}

void Lane::send_garbage(std::size_t count, std::uint32_t seed) {
    constexpr std::uint8_t kHeader = 0x20;
    constexpr std::uint32_t kMultiplier = 1664525;
    constexpr std::uint32_t kIncrement = 1013904223;
    std::array<std::uint8_t, kLongestSerialFrame> bytes{};
    count = std::min(count, bytes.size());
    for (std::size_t i = 0; i < count; ++i) {
        seed = seed * kMultiplier + kIncrement;
        bytes[i] = seed >> 30U == 0 ? kHeader : static_cast<std::uint8_t>(seed >> 16U);
    }
    [[maybe_unused]] const auto taken = ::write(in_.master.get(), bytes.data(), count);
}

bool Lane::take_frame(const WireFrame& frame) {
    if (pending_count_ < frame.length || frame.length == 0 ||
        !std::equal(frame.bytes.begin(),
                    frame.bytes.begin() + static_cast<std::ptrdiff_t>(frame.length),
                    pending_.begin())) {
        return false;
    }
    std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(frame.length),
              pending_.begin() + static_cast<std::ptrdiff_t>(pending_count_), pending_.begin());
    pending_count_ -= frame.length;
    return true;
}

bool Lane::receive() {
    const ssize_t count = ::read(out_.master.get(), pending_.data() + pending_count_,
                                 pending_.size() - pending_count_);
    pending_count_ += count > 0 ? static_cast<std::size_t>(count) : 0;
    bool arrived = false;
    while (pending_count_ > 0 && pending_count_ >= expected_.length) {
        if (take_frame(expected_)) {
            arrived = arrived || outstanding_;
            counts_.arrived += outstanding_ ? 1 : 0;
            counts_.repeated += outstanding_ ? 0 : 1;
            outstanding_ = false;
        } else if (take_frame(before_)) {
            ++counts_.repeated;
        } else {
            ++counts_.torn;
            pending_count_ = 0;
        }
    }
    return arrived;
}

void Lane::drain() {
    std::array<std::uint8_t, 1024> buffer{};
    while (::read(out_.master.get(), buffer.data(), buffer.size()) > 0) {
    }
    pending_count_ = 0;
}

void Lane::start_counting() {
    counts_ = {};
    outstanding_ = false;
}

}  // namespace tribus::bench
