#include "app/wire/frames/frame_json.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

namespace tribus {
namespace {

using Json = nlohmann::json;
using LineMistake = tl::unexpected<JsonMistake>;

constexpr double kLeastPulse = -4096;
constexpr double kMostPulse = 4095.875;
/// About 31 years; their nanoseconds fit 64 bits.
constexpr double kMostMicroseconds = 1e15;

LineMistake mistake(std::string text) {
    return LineMistake(JsonMistake{1, std::move(text)});
}

void append_detail(std::string& text, const FrameDetail& detail) {
    if (detail.list) {
        text += fmt::format(",\"{}\":[{}]", detail.name, fmt::join(detail.values, ","));
    } else if (!detail.values.empty()) {
        text += fmt::format(",\"{}\":{}", detail.name, detail.values.front());
    }
}

void append_rejected_json(std::string& text, std::span<const NamedCount> rejected) {
    text += "\"rejected\":{";
    for (const NamedCount& cause : rejected) {
        text += fmt::format("{}\"{}\":{}", text.back() == '{' ? "" : ",", cause.name, cause.count);
    }
    text += '}';
}

/// Exceptions of the JSON library end here.
tl::expected<Json, JsonMistake> parse_line(std::string_view line) {
    try {
        return Json::parse(line);
    } catch (const Json::parse_error& error) {
        return LineMistake(JsonMistake{error.byte > 0 ? error.byte : 1,
                                       "not JSON; a line must be one object, as decode prints it"});
    } catch (const Json::exception&) {
        return mistake("JSON that cannot be read; a line must be one object, as decode prints it");
    }
}

tl::expected<void, JsonMistake> read_channels(const Json& channels, ChannelFrame& frame) {
    if (!channels.is_array() || channels.size() > kChannelCount) {
        return mistake(fmt::format(
            "\"channels\" must be a list of at most {} pulses in microseconds, null if absent",
            kChannelCount));
    }
    for (std::size_t channel = 0; channel < channels.size(); ++channel) {
        const Json& value = channels[channel];
        if (value.is_null()) {
            continue;
        }
        const double pulse = value.is_number() ? value.get<double>() : std::nan("");
        if (!(pulse >= kLeastPulse && pulse <= kMostPulse)) {
            return mistake(fmt::format("channel {} is {}; allowed: {} to {} us, or null",
                                       channel + 1,
                                       value.dump(-1, ' ', true, Json::error_handler_t::replace),
                                       kLeastPulse, kMostPulse));
        }
        frame.set(channel, Pulse::from_fractional_microseconds(pulse));
    }
    return {};
}

tl::expected<bool, JsonMistake> read_flag(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end()) {
        return false;
    }
    if (!found->is_boolean()) {
        return mistake(fmt::format("\"{}\" must be true or false", key));
    }
    return found->get<bool>();
}

tl::expected<std::optional<Duration>, JsonMistake> read_start(const Json& object) {
    const auto found = object.find("t_us");
    if (found == object.end()) {
        return std::nullopt;
    }
    const double microseconds = found->is_number() ? found->get<double>() : std::nan("");
    if (!(std::abs(microseconds) <= kMostMicroseconds)) {
        return mistake("\"t_us\" must be a number of microseconds; leave it out if unknown");
    }
    return Duration(std::llround(microseconds * 1000));
}

}  // namespace

void append_pulse(std::string& text, Pulse pulse) {
    const int eighths = pulse.eighths();
    const int size = std::abs(eighths);
    const int whole = size / Pulse::kEighthsPerMicrosecond;
    constexpr std::array<std::string_view, Pulse::kEighthsPerMicrosecond> kEighths{
        "", ".125", ".25", ".375", ".5", ".625", ".75", ".875"};
    const fmt::format_int number(whole);
    text += eighths < 0 ? "-" : "";
    text.append(number.data(), number.size());
    text += kEighths.at(static_cast<std::size_t>(size % Pulse::kEighthsPerMicrosecond));
}

std::int64_t whole_microseconds(Duration duration) {
    return std::chrono::round<std::chrono::microseconds>(duration).count();
}

void append_frame_json(std::string& text, const FoundFrame& found) {
    text += '{';
    if (found.start) {
        text += fmt::format("\"t_us\":{},", whole_microseconds(*found.start));
    }
    text += fmt::format("\"protocol\":\"{}\",\"channels\":[", found.protocol->name);
    const ChannelFrame& frame = found.frame.channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        text += channel > 0 ? "," : "";
        if (const auto pulse = frame.channel(channel)) {
            append_pulse(text, *pulse);
        } else {
            text += "null";
        }
    }
    text += fmt::format("],\"frame_lost\":{},\"failsafe\":{}", frame.frame_lost, frame.failsafe);
    for (const FrameDetail& detail : found.details) {
        append_detail(text, detail);
    }
    if (found.judged) {
        text += fmt::format(",\"cause\":\"{}\"", name_of(found.judged->state.cause));
        if (const auto& before = found.judged->lost_before) {
            text += fmt::format(",\"lost_before\":\"{}\"", name_of(before->cause));
        }
    }
    text += "}\n";
}

void append_summary_json(std::string& text, const Tally& tally, std::string_view input) {
    text += fmt::format("{{\"summary\":{{\"bytes\":{},", tally.bytes);
    if (tally.can) {
        text += fmt::format("\"can_frames\":{},", tally.can->frames);
    }
    text += fmt::format("\"frames\":{},", tally.frames);
    append_rejected_json(text, tally.rejected);
    if (tally.can) {
        text += fmt::format(",\"other_can_frames\":{},\"error_frames\":{},\"log_start_us\":{}",
                            tally.can->others, tally.can->log.error_frames,
                            whole_microseconds(tally.can->log.start));
    } else {
        text += fmt::format(",\"skipped_bytes\":{}", tally.skipped_bytes);
    }
    text += fmt::format(",\"input\":\"{}\"}}}}\n", input);
}

tl::expected<std::optional<WrittenFrame>, JsonMistake> parse_frame_json(std::string_view line) {
    if (line.find_first_not_of(" \t\r\n") == std::string_view::npos) {
        return std::nullopt;
    }
    const auto object = parse_line(line);
    if (!object) {
        return LineMistake(object.error());
    }
    if (!object->is_object()) {
        return mistake("a line must be one object, as decode prints it");
    }
    const auto channels = object->find("channels");
    if (channels == object->end()) {
        if (object->contains("summary") || object->contains("transfer_id")) {
            return std::nullopt;
        }
        return mistake("no \"channels\" in it; a frame is {\"channels\":[1500, ...]}");
    }
    WrittenFrame written;
    if (const auto read = read_channels(*channels, written.channels); !read) {
        return LineMistake(read.error());
    }
    const auto frame_lost = read_flag(*object, "frame_lost");
    const auto failsafe = read_flag(*object, "failsafe");
    const auto start = read_start(*object);
    if (!frame_lost || !failsafe) {
        return LineMistake(!frame_lost ? frame_lost.error() : failsafe.error());
    }
    if (!start) {
        return LineMistake(start.error());
    }
    written.channels.frame_lost = *frame_lost;
    written.channels.failsafe = *failsafe;
    if (!*failsafe) {
        // It comes from no link that could be lost.
        written.channels.cause = LinkCause::good;
    }
    written.start = *start;
    return written;
}

}  // namespace tribus
