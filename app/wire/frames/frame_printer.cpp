#include "app/wire/frames/frame_printer.h"

#include <ostream>

#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"

namespace tribus {

std::string_view recording_kind_name(RecordingKind kind) {
    switch (kind) {
        case RecordingKind::raw:
            return "raw";
        case RecordingKind::hex:
            return "hex";
        case RecordingKind::timed:
            return "timed";
        case RecordingKind::saleae:
            return "saleae";
        case RecordingKind::candump:
            return "candump";
    }
    return "";
}

FramePrinter::FramePrinter(DecodeFormat format, RecordingKind input, std::ostream& results,
                           std::ostream& messages)
    : format_(format), input_(input), results_(results), messages_(messages) {}

void FramePrinter::heading() {
    std::string text;
    if (format_ == DecodeFormat::text) {
        append_text_heading(text);
    } else if (format_ == DecodeFormat::csv) {
        append_csv_heading(text);
    }
    results_ << text;
}

std::string FramePrinter::line(const FoundFrame& found) const {
    std::string text;
    switch (format_) {
        case DecodeFormat::text:
            append_frame_text(text, found);
            break;
        case DecodeFormat::json:
            append_frame_json(text, found);
            break;
        case DecodeFormat::csv:
            append_frame_csv(text, found);
            break;
    }
    return text;
}

void FramePrinter::frame(const FoundFrame& found) {
    line(line(found));
}

void FramePrinter::line(std::string_view printed) {
    results_ << printed;
}

void FramePrinter::summary(const Tally& tally) {
    std::string text;
    if (format_ == DecodeFormat::json) {
        append_summary_json(text, tally, recording_kind_name(input_));
    } else {
        append_summary_text(text, tally);
    }
    (format_ == DecodeFormat::csv ? messages_ : results_) << text;
}

void FramePrinter::can_summary(const CanTally& tally) {
    std::string text;
    if (format_ == DecodeFormat::json) {
        append_can_summary_json(text, tally, recording_kind_name(input_));
    } else {
        append_can_summary_text(text, tally);
    }
    (format_ == DecodeFormat::csv ? messages_ : results_) << text;
}

}  // namespace tribus
