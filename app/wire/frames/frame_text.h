#pragma once

#include <string>

#include "app/wire/frames/frame_finder.h"

/// Decoded frames as text for people and as CSV for spreadsheets.
namespace tribus {

/// Aligned columns; pulses rounded to the nearest microsecond.
void append_text_heading(std::string& text);
void append_frame_text(std::string& text, const FoundFrame& found);
/// One line: `1231 frames in 39395 bytes, 3 bytes skipped, rejected: none`, or on CAN
/// `210 frames in 1050 CAN frames of 8400 bytes, 12 other CAN frames, ...`.
void append_summary_text(std::string& text, const Tally& tally);
/// `1436509052.249713`: a time of a log in seconds.
std::string log_time_text(Duration time);

/// `t_us,ch1..ch18,frame_lost,failsafe`: exact pulses, empty cells for absent values, flags as 0
/// and 1.
void append_csv_heading(std::string& text);
void append_frame_csv(std::string& text, const FoundFrame& found);

}  // namespace tribus
