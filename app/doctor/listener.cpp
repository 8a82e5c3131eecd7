#include "app/doctor/listener.h"

#include <poll.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/doctor/line_heard.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/serial/serial_port.h"
#include "transports/registry/registry.h"

namespace tribus::doctor {
namespace {

using std::chrono::milliseconds;

/// Three frames of the slowest known sender, 80 ms each.
constexpr Duration kLook = milliseconds(250);
constexpr int kPollMilliseconds = 20;
/// More than any line delivers in a minute; a pty has no rate.
constexpr std::size_t kMostBytes = std::size_t{1} << 21;

Burst burst_of(const Reception& reception, Duration at) {
    const auto bytes = reception.view();
    Burst burst{.start = at, .bytes = {bytes.begin(), bytes.end()}, .damaged = {}};
    burst.damaged.resize(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        burst.damaged[i] = reception.damaged[i];
    }
    return burst;
}

/// Listens with these settings. The error is a sentence without the device.
tl::expected<Heard, std::string> listen(const std::string& device, const LineSettings& line,
                                        Duration time) {
    auto port = SerialPort::open(device, line);
    if (!port) {
        return tl::unexpected(
            port.error().substr(std::min(device.size() + 2, port.error().size())));
    }
    Heard heard{.line = line, .listened = {}, .bursts = {}};
    const Instant begin = monotonic_now();
    std::size_t bytes = 0;
    Reception reception;
    while (heard.listened < time && bytes < kMostBytes) {
        pollfd watched{(*port)->descriptor(), POLLIN, 0};
        ::poll(&watched, 1, kPollMilliseconds);
        const ReadStatus status = (*port)->read(reception);
        heard.listened = monotonic_now() - begin;
        if (status == ReadStatus::lost) {
            return tl::unexpected(std::string("it vanished during listening"));
        }
        if (status == ReadStatus::received) {
            bytes += reception.count;
            heard.bursts.push_back(burst_of(reception, heard.listened));
        }
    }
    return heard;
}

bool has_frames(const Heard& heard) {
    return judge_line(std::span(&heard, 1)).sound == LineSound::frames;
}

/// True if a port was refused for its settings; the error text comes from uart_rate.cpp.
bool is_refusal_of_settings(std::string_view error) {
    return error.starts_with("asked for");
}

/// Adds the trial. Returns false if the port cannot be opened at all.
bool add_trial(const std::string& device, const LineSettings& line, Visit& visit) {
    const auto taken = listen(device, line, Duration::zero());
    if (!taken && !is_refusal_of_settings(taken.error())) {
        visit.failure = taken.error();
        return false;
    }
    visit.trials.push_back({line, taken ? std::string() : taken.error()});
    return true;
}

}  // namespace

std::vector<LineSettings> usual_lines() {
    std::vector<LineSettings> lines{kIbusLine, kSbusLine, kFastSbusLine};
    const auto hear = [&lines](LineSettings line) {
        line.inverted_wire = false;
        if (std::ranges::find(lines, line) == lines.end()) {
            lines.push_back(line);
        }
    };
    for (const Protocol* protocol : protocols()) {
        if (protocol->shape != WireShape::bytes || !protocol->goes(SettingScope::input)) {
            continue;
        }
        hear(protocol->line);
        const auto key = std::ranges::find(protocol->settings, "baud", &Setting::key);
        for (const std::string_view rate :
             key == protocol->settings.end() ? std::span<const std::string_view>() : key->choices) {
            LineSettings line = protocol->line;
            std::from_chars(rate.data(), rate.data() + rate.size(), line.baud);
            hear(line);
        }
    }
    return lines;
}

std::vector<LineSettings> further_lines() {
    // SBUS of senders that omit the parity bit, and rates to which people set receivers of
    // protocols that take several.
    std::vector<LineSettings> lines;
    const std::vector<LineSettings> usual = usual_lines();
    for (const std::uint32_t baud : {100'000U, 400'000U, 460'800U, 921'600U}) {
        const LineSettings line{.baud = baud};
        if (std::ranges::find(usual, line) == usual.end()) {
            lines.push_back(line);
        }
    }
    return lines;
}

Visit try_port(const std::string& device, const LineSettings& line) {
    Visit visit;
    add_trial(device, line, visit);
    return visit;
}

Visit visit_port(const std::string& device, Duration time,
                 const std::function<void(std::string_view)>& says) {
    Visit visit;
    for (const LineSettings& line : usual_lines()) {
        if (!add_trial(device, line, visit)) {
            return visit;
        }
    }
    std::vector<LineSettings> lines;
    for (const Trial& trial : visit.trials) {
        if (trial.refusal.empty()) {
            lines.push_back(trial.line);
        }
    }
    std::vector<Heard> all;
    Duration left = time;
    const auto listen_more = [&](const LineSettings& line, Duration most) {
        auto heard = listen(device, line, std::max(most, kLook));
        if (!heard) {
            visit.failure = heard.error();
            return false;
        }
        left -= heard->listened;
        all.push_back(*std::move(heard));
        return true;
    };
    for (const LineSettings& line : lines) {
        says(fmt::format("listening at {} baud ...", line.baud));
        if (!listen_more(line, kLook)) {
            return visit;
        }
        if (has_frames(all.back())) {
            const Heard look = std::exchange(all, {}).back();
            if (!listen_more(line, left)) {
                return visit;
            }
            if (!has_frames(all.back())) {
                all.push_back(look);
            }
            visit.story = judge_line(all);
            return visit;
        }
    }
    for (const LineSettings& line : further_lines()) {
        if (listen(device, line, Duration::zero())) {
            lines.push_back(line);
        }
    }
    const Duration each = left / static_cast<std::int64_t>(lines.size());
    for (const LineSettings& line : lines) {
        says(fmt::format("listening at {} baud again ...", line.baud));
        if (!listen_more(line, each)) {
            return visit;
        }
    }
    visit.story = judge_line(all);
    return visit;
}

}  // namespace tribus::doctor
