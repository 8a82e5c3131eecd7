#include "app/doctor/listening/line_judge.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/protocol_use.h"
#include "app/doctor/listening/line_inversion.h"
#include "app/wire/frames/frame_finder.h"
#include "app/wire/sensors/sensor_frame_finder.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/ibus2/ibus2.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/codecs/sbus/sbus24.h"
#include "transports/registry/registry.h"

namespace tribus::doctor {
namespace {

/// Too many for a coincidence, but few enough for the shortest listening time.
constexpr std::uint64_t kFewestFramesToJudge = 3;

/// The usual time from one to the next: the mean of those close to the median.
std::optional<Duration> usual_step(const std::vector<Duration>& times) {
    std::vector<Duration> steps;
    for (std::size_t i = 1; i < times.size(); ++i) {
        steps.push_back(times[i] - times[i - 1]);
    }
    if (steps.size() < 2) {
        return std::nullopt;
    }
    std::ranges::sort(steps);
    const Duration median = steps[steps.size() / 2];
    Duration sum{};
    std::int64_t count = 0;
    for (const Duration step : steps) {
        if (3 * std::chrono::abs(step - median) <= median) {
            sum += step;
            ++count;
        }
    }
    return count == 0 ? std::nullopt : std::optional(sum / count);
}

struct ByteCount {
    std::uint64_t bytes = 0;
    std::uint64_t damaged = 0;
    std::uint64_t breaks = 0;  ///< damaged zeros; breaks look like these
};

ByteCount count_bytes(const Heard& heard) {
    ByteCount count;
    for (const Burst& burst : heard.bursts) {
        count.bytes += burst.bytes.size();
        for (std::size_t i = 0; i < burst.damaged.size(); ++i) {
            count.damaged += burst.damaged[i] ? 1U : 0U;
            count.breaks += burst.damaged[i] && burst.bytes[i] == 0 ? 1U : 0U;
        }
    }
    return count;
}

LineStory story_of(const Heard& heard) {
    const ByteCount count = count_bytes(heard);
    LineStory story;
    story.line = heard.line;
    story.listened = heard.listened;
    story.bytes = count.bytes;
    story.damaged = count.damaged;
    return story;
}

/// The same bytes without damage marks.
Heard undamaged(Heard heard) {
    for (Burst& burst : heard.bursts) {
        burst.damaged.assign(burst.bytes.size(), false);
    }
    return heard;
}

class FrameWatch {
  public:
    explicit FrameWatch(bool has_switches) {
        is_switch_[kSbusChannels] = is_switch_[kSbusChannels + 1] = has_switches;
    }

    void take(const FoundFrame& found) {
        bytes_ += found.frame.length;
        if (found.start) {
            starts_.push_back(*found.start);
        }
        const ChannelFrame& channels = found.frame.channels;
        story_.frame_lost += channels.frame_lost ? 1U : 0U;
        story_.failsafe += channels.failsafe ? 1U : 0U;
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            if (const auto pulse = channels.channel(channel)) {
                story_.channels = std::max(story_.channels, channel + 1);
                if (is_switch_[channel]) {
                    continue;
                }
                const double us = pulse->microseconds();
                story_.least_us = std::min(story_.least_us.value_or(us), us);
                story_.most_us = std::max(story_.most_us.value_or(us), us);
            }
        }
        for (const FrameDetail& detail : found.details) {
            if (detail.name == "raw") {
                scale_.take(detail.values);
            }
            story_.sbus2 = story_.sbus2 || (detail.name == "footer" && detail.values[0] != 0);
        }
    }
    /// Nothing if there are too few frames, or if most bytes belong to none.
    std::optional<LineStory> finish(const Heard& heard, const Tally& tally,
                                    std::string_view protocol) const {
        if (tally.frames < kFewestFramesToJudge || 2 * bytes_ < tally.bytes) {
            return std::nullopt;
        }
        LineStory story = story_of(heard);
        story.sound = LineSound::frames;
        story.protocol = protocol;
        story.frames = tally.frames;
        story.lost_bytes = tally.skipped_bytes;
        story.period = usual_step(starts_);
        story.channels = story_.channels;
        story.frame_lost = story_.frame_lost;
        story.failsafe = story_.failsafe;
        story.sbus2 = story_.sbus2;
        story.scale = scale_.guess();
        story.least_us = story_.least_us;
        story.most_us = story_.most_us;
        return story;
    }

  private:
    LineStory story_;
    std::array<bool, kChannelCount> is_switch_{};
    ScaleWatch scale_;
    std::vector<Duration> starts_;
    std::uint64_t bytes_ = 0;
};

std::optional<LineStory> read_frames(const Heard& heard, const Protocol& protocol) {
    auto use = use_protocol(protocol, SettingScope::input, {});
    if (!use) {
        return {};
    }
    use->line = heard.line;
    FrameWatch watch(&protocol == &kSbusProtocol);
    const auto finder =
        make_frame_finder(*use, [&](const FoundFrame& found) { watch.take(found); });
    for (std::size_t index = 0; index < heard.bursts.size(); ++index) {
        finder->feed_burst(index, heard.bursts[index]);
    }
    finder->finish();
    return watch.finish(heard, finder->tally(), protocol.name);
}

/// Adds the frames of the sensor bus, alone or beside i.Bus.
std::optional<LineStory> with_sensor_bus(const Heard& heard, std::optional<LineStory> ibus) {
    std::uint64_t requests = 0;
    std::uint64_t replies = 0;
    std::uint64_t in_frames = 0;
    std::vector<Duration> starts;
    SensorFrameFinder finder([&](const ReceivedSensorFrame& found) {
        in_frames += kSensorRequestBytes + found.frame.data_size;
        ++(found.frame.is_request() ? requests : replies);
        if (found.frame.is_request() && found.start) {
            starts.push_back(*found.start);
        }
    });
    for (const Burst& burst : heard.bursts) {
        finder.feed_burst(0, burst);
    }
    const SensorTally tally = finder.tally();
    const bool alone = requests >= kFewestFramesToJudge && 2 * in_frames >= tally.frames.bytes;
    if (!ibus && !alone) {
        return std::nullopt;
    }
    LineStory story = ibus.value_or(story_of(heard));
    if (!ibus) {
        story.sound = LineSound::frames;
        story.protocol = kSensorBusName;
        story.frames = tally.frames.frames;
        story.lost_bytes = tally.frames.skipped_bytes;
        story.period = usual_step(starts);
    }
    story.requests = requests;
    story.replies = replies;
    return story;
}

/// Whether a smaller share of the bytes is outside frames.
bool is_cleaner(const LineStory& story, const LineStory& other) {
    return story.lost_bytes * other.bytes < other.lost_bytes * story.bytes;
}

/// Whether the key `baud` may give the protocol that rate. `usual`: one of few that are its own.
bool takes_rate(const Protocol& protocol, std::uint32_t baud, bool usual = false) {
    const auto key = std::ranges::find(protocol.settings, "baud", &Setting::key);
    if (baud == protocol.line.baud || key == protocol.settings.end()) {
        return baud == protocol.line.baud;
    }
    if (!key->choices.empty()) {
        return std::ranges::count(key->choices, std::to_string(baud)) > 0;
    }
    return !usual && baud >= key->least && baud <= key->most;
}

/// Whether a line with these settings may be one of the protocol.
bool is_line_of(const LineSettings& line, const Protocol& protocol, bool usual = false) {
    return line.parity == protocol.line.parity && line.stop_bits == protocol.line.stop_bits &&
           takes_rate(protocol, line.baud, usual);
}

/// SBUS is recognised at its rates with any other settings, to see wrong ones; another protocol
/// with its own settings, and at other rates that it may be set to.
bool may_carry(const LineSettings& line, const Protocol& protocol) {
    return &protocol == &kSbusProtocol ? takes_rate(protocol, line.baud)
                                       : is_line_of(line, protocol);
}

/// A protocol at its usual rate comes before another one at a rate that it may be set to.
std::optional<LineStory> read_any(const Heard& heard) {
    std::optional<LineStory> best;
    for (const bool usual : {true, false}) {
        for (const Protocol* protocol : protocols()) {
            const bool own = heard.line.baud == protocol->line.baud;
            if (protocol->shape != WireShape::bytes || !protocol->goes(SettingScope::input) ||
                own != usual || !may_carry(heard.line, *protocol)) {
                continue;
            }
            auto story = read_frames(heard, *protocol);
            if (story && (!best || is_cleaner(*story, *best))) {
                best = std::move(story);
            }
        }
    }
    const bool may_be_sensor_bus = !best || best->protocol == kIbusProtocol.name;
    if (heard.line == kIbusLine && may_be_sensor_bus) {
        best = with_sensor_bus(heard, std::move(best));
    }
    return best;
}

/// Whether the two are the same frames, heard at rates so close that a port takes both.
bool are_neighbours(const LineStory& story, const LineStory& other) {
    const double ratio = static_cast<double>(story.line.baud) / other.line.baud;
    return story.protocol == other.protocol && story.line.parity == other.line.parity &&
           ratio > 0.94 && ratio < 1.06;
}

/// The cleanest reading; the first of equal ones.
std::optional<LineStory> best_of(std::span<const Heard> heard, bool believe_damage) {
    std::optional<LineStory> best;
    for (const Heard& one : heard) {
        const std::uint64_t damaged = count_bytes(one).damaged;
        if (!believe_damage && damaged == 0) {
            continue;  // It was read as it is, and told nothing.
        }
        auto story = read_any(believe_damage ? one : undamaged(one));
        if (story && (!best || (is_cleaner(*story, *best) && !(are_neighbours(*story, *best) &&
                                                               story->frames <= best->frames)))) {
            best = std::move(story);
            best->damaged = damaged;
        }
    }
    return best;
}

/// At usual rates only. The protocol whose beginning is seen most often behind a gap; the first of
/// equal ones.
std::optional<LineStory> judge_inversion(std::span<const Heard> heard) {
    std::optional<LineStory> best;
    std::size_t most = 0;
    for (const Protocol* protocol : protocols()) {
        for (const Heard& one : heard) {
            const auto inversion = is_line_of(one.line, *protocol, true)
                                       ? inverted_frames(one, *protocol)
                                       : std::optional<Inversion>();
            if (inversion && (!best || inversion->behind_gaps > most)) {
                best = story_of(one);
                best->sound = LineSound::inverted;
                best->protocol = protocol->name;
                best->period = inversion->period;
                most = inversion->behind_gaps;
            }
        }
    }
    return best;
}

std::optional<LineStory> judge_sbus24(std::span<const Heard> heard) {
    for (const Heard& one : heard) {
        Sbus24Watch watch;
        std::vector<Duration> starts;
        for (const Burst& burst : one.bursts) {
            watch.take(burst.bytes);
            starts.push_back(burst.start.value_or(Duration::zero()));
        }
        if (watch.frames() >= kFewestFramesToJudge) {
            LineStory story = story_of(one);
            story.sound = LineSound::sbus24;
            story.frames = watch.frames();
            story.period = usual_step(starts);
            return story;
        }
    }
    return std::nullopt;
}

LineStory judge_rest(std::span<const Heard> heard) {
    LineStory all;
    ByteCount count;
    for (const Heard& one : heard) {
        const ByteCount more = count_bytes(one);
        all.listened += one.listened;
        count.bytes += more.bytes;
        count.damaged += more.damaged;
        count.breaks += more.breaks;
        all.period = all.period ? all.period : period_of_breaks(one);
    }
    all.bytes = count.bytes;
    all.damaged = count.damaged;
    if (count.bytes > 0) {
        const bool mostly_low = 5 * count.breaks >= 4 * count.bytes;
        all.sound = mostly_low ? LineSound::breaks : LineSound::unknown;
    }
    return all;
}

}  // namespace

std::string_view sound_name(LineSound sound) {
    constexpr std::array<std::string_view, 8> kNames{
        "silence", "frames", "wrong_parity", "inverted", "breaks", "ibus2", "sbus24", "unknown"};
    return kNames[static_cast<std::size_t>(sound)];
}

LineStory judge_line(std::span<const Heard> heard) {
    if (auto story = best_of(heard, true)) {
        const bool without_parity =
            story->protocol == kSbusProtocol.name && story->line.parity == Parity::none;
        story->sound = without_parity ? LineSound::wrong_parity : LineSound::frames;
        if (story->protocol == kIbus2Protocol.name && story->channels == 0) {
            // No device asked for the key of the channels, so nothing can be read.
            story->sound = LineSound::ibus2;
            story->protocol = {};
        }
        return *std::move(story);
    }
    if (auto story = judge_sbus24(heard)) {
        return *std::move(story);
    }
    if (auto story = best_of(heard, false)) {
        story->sound = LineSound::wrong_parity;
        return *std::move(story);
    }
    if (auto story = judge_inversion(heard)) {
        return *std::move(story);
    }
    return judge_rest(heard);
}

}  // namespace tribus::doctor
