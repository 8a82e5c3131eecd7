#include "app/frame_text.h"

#include <fmt/format.h>

#include <cstddef>
#include <iterator>
#include <string_view>

#include "app/frame_json.h"

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

}  // namespace

void append_text_heading(std::string& text) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{:>12} {:<8}", "t_us", "protocol");
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        fmt::format_to(out, "{:>5}", channel);
    }
    text += "  link\n";
}

void append_frame_text(std::string& text, const FoundFrame& found) {
    auto out = std::back_inserter(text);
    if (found.start) {
        fmt::format_to(out, "{:>12} ", whole_microseconds(*found.start));
    } else {
        fmt::format_to(out, "{:>12} ", "-");
    }
    fmt::format_to(out, "{:<8}", found.protocol->name);
    const ChannelFrame& frame = found.frame.channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (const auto pulse = frame.channel(channel)) {
            fmt::format_to(out, "{:>5}", pulse->whole_microseconds());
        } else {
            fmt::format_to(out, "{:>5}", "-");
        }
    }
    fmt::format_to(out, "  {}", link_text(frame));
    for (const FrameDetail& detail : found.details) {
        if (!detail.list && !detail.values.empty()) {
            fmt::format_to(out, "  {}={:#04x}", detail.name, detail.values.front());
        }
    }
    text += '\n';
}

void append_summary_text(std::string& text, const Tally& tally) {
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{} frames in {} bytes, {} bytes skipped, rejected:", tally.frames,
                   tally.bytes, tally.skipped_bytes);
    bool any = false;
    for (const NamedCount& cause : tally.rejected) {
        if (cause.count > 0) {
            fmt::format_to(out, "{} {} {}", any ? "," : "", cause.count, cause.name);
            any = true;
        }
    }
    text += any ? "\n" : " none\n";
}

void append_csv_heading(std::string& text) {
    auto out = std::back_inserter(text);
    text += "t_us";
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        fmt::format_to(out, ",ch{}", channel);
    }
    text += ",frame_lost,failsafe\n";
}

void append_frame_csv(std::string& text, const FoundFrame& found) {
    auto out = std::back_inserter(text);
    if (found.start) {
        fmt::format_to(out, "{}", whole_microseconds(*found.start));
    }
    const ChannelFrame& frame = found.frame.channels;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        text += ',';
        if (const auto pulse = frame.channel(channel)) {
            append_pulse(text, *pulse);
        }
    }
    fmt::format_to(out, ",{:d},{:d}\n", frame.frame_lost, frame.failsafe);
}

}  // namespace tribus
