#include "app/bench/ports.h"

#include <poll.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/bench/lane.h"
#include "app/bench/latency.h"
#include "app/bench/stamping_link.h"
#include "app/bench/subject.h"
#include "app/bench/tester.h"
#include "config/build/build.h"
#include "config/language/mistakes.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/data_thread.h"
#include "pipelines/realtime/loop.h"
#include "pipelines/realtime/scheduling.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/links/serial/serial_port.h"

namespace tribus::bench {
namespace {

using Stamp = StampingLink::Stamp;

/// Frames are recognised by their first channels, which are in their first eight bytes.
std::uint64_t beginning_of(std::uint32_t number) {
    const WireFrame frame = numbered_ibus_frame(number);
    return StampingLink::beginning_of({frame.bytes.data(), frame.length});
}

/// Writes all frames; returns the instant at which each was begun.
std::vector<Instant> send_frames(ByteLink& out, std::size_t frames) {
    std::vector<Instant> sent_at;
    sent_at.reserve(frames);
    const TesterPriority priority;
    Instant next = monotonic_now() + kFramePeriod;
    for (std::size_t i = 0; i < frames && !interrupted(); ++i) {
        const WireFrame frame = numbered_ibus_frame(static_cast<std::uint32_t>(i));
        sleep_until(next);
        next += kFramePeriod;
        sent_at.push_back(monotonic_now());
        out.write({frame.bytes.data(), frame.length});
    }
    // Waits for frames that are still on their way.
    sleep_until(monotonic_now() + 4 * kFramePeriod);
    return sent_at;
}

Distribution matched(const std::vector<Instant>& sent_at, const std::vector<Stamp>& stamps) {
    std::vector<Duration> times;
    std::size_t next = 0;
    for (const Stamp& stamp : stamps) {
        for (std::size_t i = next; i < sent_at.size(); ++i) {
            if (beginning_of(static_cast<std::uint32_t>(i)) == stamp.beginning) {
                times.push_back(stamp.at - sent_at[i]);
                next = i + 1;
                break;
            }
        }
    }
    return Distribution(std::move(times));
}

/// Waits, reads, and stamps each complete frame.
void read_bare(ByteLink& in, std::optional<int> priority, std::vector<Stamp>& stamps,
               const std::atomic<bool>& end) {
    SchedulingSettings scheduling;
    scheduling.priority = priority.value_or(scheduling.priority);
    scheduling.realtime = priority.has_value();
    const Scheduling got = make_realtime(scheduling);
    IbusDecoder decoder;
    Reception reception;
    while (!end.load(std::memory_order_relaxed)) {
        constexpr int kLookForTheEndMilliseconds = 50;
        pollfd wait{.fd = in.descriptor(), .events = POLLIN, .revents = 0};
        if (::poll(&wait, 1, kLookForTheEndMilliseconds) <= 0 ||
            in.read(reception) != ReadStatus::received) {
            continue;
        }
        const Instant now = monotonic_now();
        auto bytes = reception.view();
        DecodedFrame frame;
        while (decoder.next(bytes, now, frame)) {
            WireFrame wire;
            wire.length = IbusEncoder(kChannelCount).write(frame.channels, wire.bytes, Instant{});
            if (stamps.size() < stamps.capacity()) {
                stamps.push_back({.at = now, .beginning = StampingLink::beginning_of(wire.bytes)});
            }
        }
    }
}

tl::expected<Distribution, std::string> through_bare_reader(const std::string& in, ByteLink& out,
                                                            std::optional<int> priority,
                                                            std::size_t frames) {
    auto port = SerialPort::open(in, kIbusProtocol.line);
    if (!port) {
        return tl::unexpected(port.error());
    }
    std::vector<Stamp> stamps;
    stamps.reserve(frames);
    std::atomic<bool> end{false};
    std::thread reader([&] { read_bare(**port, priority, stamps, end); });
    const std::vector<Instant> sent_at = send_frames(out, frames);
    end = true;
    reader.join();
    return matched(sent_at, stamps);
}

std::string configuration(const std::string& in) {
    return fmt::format(R"([input.receiver]
protocol = "ibus"
device = "{}"
[output.servos]
protocol = "ibus"
channels = 18
device = "/dev/servos"
period = "5ms"
[pipeline.main]
from = "receiver"
to = "servos"
[pipeline.main.failsafe]
recover = "0ms"
)",
                       in);
}

tl::expected<Distribution, std::string> through_engine(const std::string& in, ByteLink& out,
                                                       std::optional<int> priority,
                                                       std::size_t frames) {
    auto checked = load_configuration(configuration(in), "bench");
    if (!checked) {
        return tl::unexpected(format_mistake(checked.error().front()));
    }
    const auto engine = build_engine(*checked);
    std::vector<Stamp> stamps;
    std::vector<PortWiring> wiring;
    std::vector<std::unique_ptr<Link>> links;
    for (const PortPlan& plan : plan_ports(*checked)) {
        wiring.push_back(plan.wiring);
        if (first_of(plan.wiring.stations, StationKind::output)) {
            links.push_back(
                std::make_unique<StampingLink>(engine->outputs().front(), stamps, 2 * frames));
            continue;
        }
        auto port = open_port(*checked, Stations(*engine, nullptr), plan);
        if (!port) {
            return tl::unexpected(port.error());
        }
        links.push_back(std::move(*port));
    }
    Loop loop(*engine, std::move(wiring), std::move(links));
    if (auto prepared = loop.prepare(); !prepared) {
        return tl::unexpected(prepared.error());
    }
    SchedulingSettings scheduling;
    scheduling.priority = priority.value_or(scheduling.priority);
    scheduling.realtime = priority.has_value();
    DataThread thread(loop, scheduling);
    if (auto prepared = thread.prepare(); !prepared) {
        return tl::unexpected(prepared.error());
    }
    thread.run();
    const std::vector<Instant> sent_at = send_frames(out, frames);
    loop.request_end();
    thread.join();
    return matched(sent_at, stamps);
}

}  // namespace

tl::expected<PortsResult, std::string> measure_ports(const std::string& in, const std::string& out,
                                                     std::optional<int> priority, Duration length) {
    auto sender = SerialPort::open(out, kIbusProtocol.line);
    if (!sender) {
        return tl::unexpected(sender.error());
    }
    const auto frames = static_cast<std::size_t>(length / 3 / kFramePeriod + 1);
    auto bare = through_bare_reader(in, **sender, priority, frames);
    if (!bare) {
        return tl::unexpected(bare.error());
    }
    if (bare->empty()) {
        return tl::unexpected(
            fmt::format("no frame that was written on {} came in on {}: connect TX of the first to "
                        "RX of the second, and their grounds",
                        out, in));
    }
    auto engine = through_engine(in, **sender, priority, frames);
    if (!engine) {
        return tl::unexpected(engine.error());
    }
    auto again = through_bare_reader(in, **sender, priority, frames);
    if (!again) {
        return tl::unexpected(again.error());
    }
    return PortsResult{std::move(*engine), std::move(*bare), std::move(*again)};
}

}  // namespace tribus::bench
