#include "app/bench/measurements.h"

#include <poll.h>
#include <pthread.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "app/appliance/appliance.h"
#include "app/cli/pty.h"
#include "core/distribution.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/scheduling.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/links/serial/serial_port.h"

namespace tribus::bench {
namespace {

constexpr Duration kFramePeriod = std::chrono::milliseconds(7);
constexpr Duration kLostAfter = std::chrono::milliseconds(500);  ///< longer than any stall

/// Frames come out as they went in. Their period is longer than that of the output, so `follow`
/// waits for the next one and does not repeat the last one.
constexpr const char* kSameFrames = "protocol = \"ibus\"\nchannels = 18\nperiod = \"5ms\"\n";
constexpr const char* kGrid = "protocol = \"sbus\"\nschedule = \"grid\"\nperiod = \"7ms\"\n";

/// As the loop names its thread.
constexpr const char* kDataThread = "tribus-data";

/// Each channel depends on the number.
std::vector<std::uint8_t> numbered_frame(std::uint32_t number) {
    ChannelFrame channels;
    for (std::uint32_t channel = 0; channel < kChannelCount; ++channel) {
        const std::uint32_t steps = (7 * number + 61 * channel) % 1000;
        channels.set(channel, Pulse::from_microseconds(1000 + static_cast<int>(steps)));
    }
    std::array<std::uint8_t, kLongestSerialFrame> wire{};
    const std::size_t length = IbusEncoder(kChannelCount).write(channels, wire, Instant{});
    return {wire.begin(), wire.begin() + length};
}

void sleep_until(Instant instant) {
    const timespec until = as_timespec(instant.time_since_epoch());
    ::clock_nanosleep(kClock, TIMER_ABSTIME, &until, nullptr);
}

/// A thread of tribus or of the bare relay carries what the far end `in.master` writes from the
/// device `in` to the device `out`.
struct Way {
    std::string thread;
    Pty in;
    Pty out;
    std::unique_ptr<Appliance> tribus{};
    std::jthread bare{};
    std::uint32_t number = 0;
    std::vector<Duration> times{};
    Duration used_before{};
    Distribution latency{};
    Duration cpu{};  ///< of the thread, for a frame
};

/// Waits, reads and writes, as real-time as tribus.
void relay(const std::stop_token& end, const std::string& name,
           const std::unique_ptr<SerialPort>& in, const std::unique_ptr<SerialPort>& out) {
    constexpr int kLookForTheEndMilliseconds = 50;
    ::pthread_setname_np(::pthread_self(), name.c_str());
    const Scheduling got = make_realtime({});
    pollfd wait{.fd = in->descriptor(), .events = POLLIN, .revents = 0};
    Reception came;
    while (!end.stop_requested() && in->read(came) != ReadStatus::lost) {
        if (came.count > 0) {
            [[maybe_unused]] const ssize_t written =
                ::write(out->descriptor(), came.bytes.data(), came.count);
        }
        ::poll(&wait, 1, kLookForTheEndMilliseconds);
    }
}

std::string configuration_text(const Way& way, const char* output) {
    return fmt::format(
        "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"{}\"\ntimeout = \"1s\"\n"
        "[output.servos]\ndevice = \"{}\"\n{}"
        "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
        "[pipeline.main.failsafe]\nrecover = \"0ms\"\n",
        way.in.path, way.out.path, output);
}

tl::expected<Way, std::string> start(const std::string& thread, const char* output,
                                     tl::expected<Pty, std::string> near) {
    auto far = Pty::open();
    if (!near || !far) {
        return tl::unexpected(near ? far.error() : near.error());
    }
    Way way{thread, std::move(*near), std::move(*far)};
    if (thread == kDataThread) {
        auto tribus = Appliance::start_text(configuration_text(way, output), "bench");
        if (!tribus) {
            return tl::unexpected(tribus.error());
        }
        way.tribus = std::move(*tribus);
        return way;
    }
    auto in = SerialPort::open(way.in.path, kIbusProtocol.line);
    auto out = SerialPort::open(way.out.path, kIbusProtocol.line);
    if (!in || !out) {
        return tl::unexpected(in ? out.error() : in.error());
    }
    way.bare = std::jthread(relay, thread, std::move(*in), std::move(*out));
    return way;
}

void drain(const Pty& pty) {
    std::array<std::uint8_t, 256> bytes{};
    while (::read(pty.master.get(), bytes.data(), bytes.size()) > 0) {
    }
}

/// Sends the next frame, and notes its time if it comes out within `patience`.
void carry(Way& way, Duration patience) {
    drain(way.out);
    const std::vector<std::uint8_t> frame = numbered_frame(++way.number);
    std::array<std::uint8_t, 128> bytes{};
    std::size_t count = 0;
    const Instant sent = monotonic_now();
    [[maybe_unused]] const ssize_t taken = ::write(way.in.master.get(), frame.data(), frame.size());
    for (Instant now = sent; now < sent + patience && count < bytes.size(); now = monotonic_now()) {
        pollfd wait{.fd = way.out.master.get(), .events = POLLIN, .revents = 0};
        const timespec rest = as_timespec(sent + patience - now);
        ::ppoll(&wait, 1, &rest, nullptr);
        const ssize_t more = ::read(wait.fd, bytes.data() + count, bytes.size() - count);
        count += more > 0 ? static_cast<std::size_t>(more) : 0;
        // The frame before may come once more, ahead of it.
        if (count >= frame.size() &&
            std::equal(frame.begin(), frame.end(), bytes.data() + count - frame.size())) {
            way.times.push_back(monotonic_now() - sent);
            return;
        }
    }
}

Duration processor_time(const std::string& thread) {
    std::int64_t nanoseconds = 0;
    for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
        std::string name;
        std::ifstream(task.path() / "comm") >> name;
        if (name == thread) {
            std::ifstream(task.path() / "schedstat") >> nanoseconds;
        }
    }
    return Duration(nanoseconds);
}

/// One frame on each way in each period, one after the other: all see the same machine, and none is
/// disturbed by another's frame.
void carry_in_turns(std::span<Way> ways, std::size_t rounds, Duration patience) {
    for (Way& way : ways) {
        way.used_before = processor_time(way.thread);
        way.times.clear();
        way.times.reserve(rounds);
    }
    const Duration step = kFramePeriod / static_cast<std::int64_t>(ways.size());
    Instant next = monotonic_now();
    for (std::size_t turn = 0; turn < rounds * ways.size(); ++turn) {
        sleep_until(next);
        // Behind a stall, frames closer together than a period would wait in tribus.
        const Instant now = monotonic_now();
        next = (now - next > kFramePeriod / 8 ? now : next) + step;
        carry(ways[turn % ways.size()], patience);
    }
}

/// On a thread of its own, above those of the ways, and on processor 0 if there are several.
/// Returns whether each way carries frames.
bool measure(std::span<Way> ways, std::size_t rounds) {
    constexpr std::size_t kWarmUpFrames = 20;
    constexpr int kMostWarmUps = 15;
    bool all_carry = false;
    std::thread([&] {
        const bool several = std::thread::hardware_concurrency() > 1;
        const Scheduling got =
            make_realtime({.priority = 90, .cpu = several ? std::optional(0) : std::nullopt});
        for (int i = 0; i < kMostWarmUps && !all_carry; ++i) {
            carry_in_turns(ways, kWarmUpFrames, kFramePeriod);
            all_carry = std::ranges::none_of(ways, [](auto& way) { return way.times.empty(); });
        }
        carry_in_turns(ways, all_carry ? rounds : 0, kLostAfter);
    }).join();
    for (Way& way : ways) {
        way.cpu = (processor_time(way.thread) - way.used_before) /
                  std::max<std::int64_t>(static_cast<std::int64_t>(way.times.size()), 1);
        way.latency = Distribution(std::move(way.times));
    }
    return all_carry;
}

}  // namespace

tl::expected<void, std::string> add_frames(Report& report, const std::vector<std::string>& ports,
                                           Duration length) {
    const bool wired = !ports.empty();
    tl::expected<std::unique_ptr<SerialPort>, std::string> sender;
    if (wired && !(sender = SerialPort::open(ports[1], kIbusProtocol.line))) {
        return tl::unexpected(sender.error());
    }
    const auto rounds = static_cast<std::size_t>(length / (wired ? 3 : 1) / kFramePeriod + 1);
    std::vector<Way> ways;
    for (const char* thread : {"bare-relay", kDataThread, "bare-again"}) {
        auto way =
            start(thread, kSameFrames,
                  wired ? Pty{UniqueFd(::dup((*sender)->descriptor())), ports[0]} : Pty::open());
        if (!way) {
            return tl::unexpected(way.error());
        }
        ways.push_back(std::move(*way));
        if (!wired && ways.size() < 3) {
            continue;
        }
        // A port has one reader at a time; pseudo-terminals are measured together.
        if (!measure(wired ? std::span(&ways.back(), 1) : ways, rounds)) {
            return tl::unexpected(
                wired ? fmt::format("no frame that was written on {} came in on {}: connect TX of "
                                    "the first to RX of the second, and their grounds",
                                    ports[1], ports[0])
                      : "no frame came through; does another program use these pseudo-terminals?");
        }
        ways.back().tribus.reset();
        ways.back().bare = {};
    }
    for (const int percent : {50, 90, 99}) {
        report.add("latency", fmt::format("p{}", percent), ways[1].latency.percentile(percent),
                   ways[0].latency.percentile(percent), ways[2].latency.percentile(percent),
                   "a bare relay");
    }
    report.measurements.push_back({.group = "latency",
                                   .what = "frames lost or torn",
                                   .figure = static_cast<double>(rounds - ways[1].latency.size()),
                                   .unit = "frames",
                                   .reading = fmt::format("of {}", rounds)});
    report.add("cpu", "a frame", ways[1].cpu, ways[0].cpu, ways[2].cpu, "a bare relay");
    return {};
}

tl::expected<void, std::string> add_lateness(Report& report, Duration length) {
    const auto way = start(kDataThread, kGrid, Pty::open());
    if (!way) {
        return tl::unexpected(way.error());
    }
    Histogram bare;
    std::thread([&] {
        const Scheduling got = make_realtime({});
        const Instant end = monotonic_now() + length;
        pollfd first{.fd = way->out.master.get(), .events = POLLIN, .revents = 0};
        ::poll(&first, 1, 1000);
        // Half a period away from the frames.
        Instant deadline = monotonic_now() + kFramePeriod / 2;
        for (Instant now = deadline; now < end; deadline += kFramePeriod) {
            sleep_until(deadline);
            now = monotonic_now();
            bare.record(now - deadline, now);
            drain(way->out);
        }
    }).join();
    const HistogramReading grid = way->tribus->output_timing(0).lateness().since_start();
    for (const int percent : {50, 90, 99}) {
        const Duration its = bare.since_start().quantile(percent / 100.0);
        report.add("lateness", fmt::format("p{}", percent), grid.quantile(percent / 100.0), its,
                   its, "a bare timer");
    }
    return {};
}

}  // namespace tribus::bench
