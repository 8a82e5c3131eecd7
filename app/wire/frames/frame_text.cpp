#include "app/wire/frames/frame_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>

#include "app/state_text/cause_text.h"
#include "app/wire/frames/frame_json.h"
#include "core/counted.h"

namespace tribus {
namespace {

std::string_view link_text(const ChannelFrame& frame) {
    if (frame.good()) {
        return "ok";
    }
    if (!frame.failsafe) {
        return "frame-lost";
    }
    return frame.frame_lost ? "frame-lost failsafe" : "failsafe";
}

/// In a column of 5.
void append_cell(std::string& text, std::string_view cell) {
    constexpr std::size_t kColumn = 5;
    text.append(kColumn - std::min(kColumn, cell.size()), ' ').append(cell);
}

/// Appends `, rejected: 3 checksum, 1 damaged`.
void append_rejected_text(std::string& text, std::span<const NamedCount> rejected) {
    text += ", rejected:";
    bool any = false;
    for (const NamedCount& cause : rejected) {
        if (cause.count > 0) {
            text += fmt::format("{} {} {}", any ? "," : "", cause.count, cause.name);
            any = true;
        }
    }
    text += any ? "" : " none";
}

}  // namespace

void append_text_heading(std::string& text) {
    text += fmt::format("{:>12} {:<8}", "t_us", "protocol");
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        text += fmt::format("{:>5}", channel);
    }
    text += "  link\n";
}

void append_frame_text(std::string& text, const FoundFrame& found) {
    if (found.start) {
        text += fmt::format("{:>12} ", whole_microseconds(*found.start));
    } else {
        text += fmt::format("{:>12} ", "-");
    }
    text += fmt::format("{:<8}", found.protocol->name);
    const ChannelFrame& frame = found.frame.channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (const auto pulse = frame.channel(channel)) {
            const fmt::format_int number(pulse->whole_microseconds());
            append_cell(text, {number.data(), number.size()});
        } else {
            append_cell(text, "-");
        }
    }
    text += "  ";
    text += link_text(frame);
    for (const FrameDetail& detail : found.details) {
        if (!detail.list && !detail.values.empty()) {
            text += fmt::format("  {}={:#04x}", detail.name, detail.values.front());
        }
    }
    if (found.judged && found.judged->lost_before) {
        text += fmt::format("  (lost before: {})",
                            cause_text(*found.judged->lost_before, found.judged->implausible));
    }
    if (found.judged && found.judged->state.cause != LinkCause::good) {
        text += fmt::format("  {}", cause_text(found.judged->state, found.judged->implausible));
    }
    text += '\n';
}

void append_summary_text(std::string& text, const Tally& tally) {
    text += counted(tally.frames, "frame") + " in ";
    if (!tally.can) {
        text += fmt::format("{}, {} skipped", counted(tally.bytes, "byte"),
                            counted(tally.skipped_bytes, "byte"));
        append_rejected_text(text, tally.rejected);
    } else {
        text +=
            fmt::format("{} of {}, {}, {}", counted(tally.can->frames, "CAN frame"),
                        counted(tally.bytes, "byte"), counted(tally.can->others, "other CAN frame"),
                        counted(tally.can->log.error_frames, "error frame"));
        append_rejected_text(text, tally.rejected);
        text += fmt::format("; 0 is {} of the log", log_time_text(tally.can->log.start));
    }
    text += '\n';
}

std::string log_time_text(Duration time) {
    const std::int64_t us = whole_microseconds(time);
    return fmt::format("{}.{:06}", us / 1'000'000, us % 1'000'000);
}

void append_csv_heading(std::string& text) {
    text += "t_us";
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        text += fmt::format(",ch{}", channel);
    }
    text += ",frame_lost,failsafe\n";
}

void append_frame_csv(std::string& text, const FoundFrame& found) {
    if (found.start) {
        text += fmt::format("{}", whole_microseconds(*found.start));
    }
    const ChannelFrame& frame = found.frame.channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        text += ',';
        if (const auto pulse = frame.channel(channel)) {
            append_pulse(text, *pulse);
        }
    }
    text += frame.frame_lost ? ",1" : ",0";
    text += frame.failsafe ? ",1\n" : ",0\n";
}

}  // namespace tribus
