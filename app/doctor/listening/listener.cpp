#include "app/doctor/listening/listener.h"

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

#include "app/doctor/listening/line_heard.h"
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

std::vector<LineSettings> accepted_lines(const Visit& visit) {
    std::vector<LineSettings> lines;
    for (const Trial& trial : visit.trials) {
        if (trial.refusal.empty()) {
            lines.push_back(trial.line);
        }
    }
    return lines;
}

/// Listens to a port with one line after another, until frames are there, the time is over or the
/// port is lost.
class Listening {
  public:
    Listening(const std::string& device, Duration time,
              const std::function<void(std::string_view)>& says)
        : device_(device), left_(time), says_(says) {}

    /// Returns how the port was lost, or nothing.
    std::string run(std::vector<LineSettings> lines) {
        if (!lines.empty()) {
            look(lines);
            stay_while_silent(lines);
            look_further(lines);
            listen_again(lines);
        }
        return failure_;
    }
    std::span<const Heard> heard() const { return heard_; }

  private:
    bool is_over() const { return found_ || !failure_.empty(); }
    bool is_silent() const {
        return std::ranges::all_of(heard_, [](const Heard& one) { return one.bursts.empty(); });
    }
    void listen_with(const LineSettings& line, Duration time, std::string_view how) {
        says_(fmt::format("listening at {} baud{} ...", line.baud, how));
        auto heard = listen(device_, line, std::max(time, kLook));
        if (!heard) {
            failure_ = heard.error();
            return;
        }
        left_ -= heard->listened;
        heard_.push_back(*std::move(heard));
    }
    /// Briefly with each; the rest of the time with the first that gives frames.
    void look(std::span<const LineSettings> lines) {
        for (auto line = lines.begin(); line != lines.end() && !is_over(); ++line) {
            listen_with(*line, kLook, "");
            if (failure_.empty() && has_frames(heard_.back())) {
                stay(*line);
            }
        }
    }
    void stay(const LineSettings& line) {
        found_ = true;
        const Heard look = std::exchange(heard_, {}).back();
        listen_with(line, left_, "");
        if (failure_.empty() && !has_frames(heard_.back())) {
            heard_.push_back(look);
        }
    }
    /// A line that carries anything carries bytes with any settings, so one of them is enough to
    /// wait for the first byte.
    void stay_while_silent(std::span<const LineSettings> lines) {
        if (is_over() || !is_silent()) {
            return;
        }
        listen_with(lines.front(), left_, " again");
        if (failure_.empty() && !is_silent()) {
            look(lines);
        }
    }
    void look_further(std::vector<LineSettings>& lines) {
        if (is_over() || is_silent()) {
            return;
        }
        std::vector<LineSettings> further = further_lines();
        std::erase_if(further, [this](const LineSettings& line) {
            return !listen(device_, line, Duration::zero());
        });
        look(further);
        lines.insert(lines.end(), further.begin(), further.end());
    }
    void listen_again(std::span<const LineSettings> lines) {
        const Duration each = left_ / static_cast<std::int64_t>(lines.size());
        if (is_silent() || each < kLook) {
            return;
        }
        for (auto line = lines.begin(); line != lines.end() && !is_over(); ++line) {
            listen_with(*line, each, " again");
        }
    }

    const std::string& device_;
    Duration left_;
    const std::function<void(std::string_view)>& says_;
    std::vector<Heard> heard_;
    std::string failure_;
    bool found_ = false;
};

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
    Listening listening(device, time, says);
    visit.failure = listening.run(accepted_lines(visit));
    if (visit.failure.empty()) {
        visit.story = judge_line(listening.heard());
    }
    return visit;
}

}  // namespace tribus::doctor
