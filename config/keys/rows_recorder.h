#pragma once

#include <array>

#include "config/keys/rows.h"

/// Rows of the flight recorder.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kRecorderKeys{
    row<&RecorderConfig::directory>(
        {.key = "directory",
         .absent = "`/var/lib/tribus/NAME` as a service; required otherwise",
         .help = "Folder for recordings, a path that begins with `/`",
         .example = "\"/data/tribus\""}),
    row<&RecorderConfig::memory_kib>(
        {.key = "memory",
         .least = 16,
         .most = 65536,
         .unit = "KiB",
         .help = "Memory for each port; 64 bytes hold one frame of i.Bus, SBUS or classic CAN",
         .example = "4096"}),
    row<&RecorderConfig::before>(
        {.key = "before",
         .least = 1,
         .most = 3600,
         .help = "Time before the event that is written, as far as `memory` holds it",
         .example = "\"60s\""}),
    row<&RecorderConfig::after>({.key = "after",
                                 .least = 0,
                                 .most = 60,
                                 .help = "Time after the event that is written",
                                 .example = "\"5s\""}),
    row<&RecorderConfig::on_failsafe>(
        {.key = "on_failsafe",
         .help = "`true`: an output that goes into failsafe is an event; `false`: only crashes "
                 "and requests are",
         .example = "false"}),
    row<&RecorderConfig::pause>(
        {.key = "pause",
         .least = 0,
         .most = 3600,
         .help = "Time after a recording in which no other one is made, unless it is requested",
         .example = "\"10s\""}),
    row<&RecorderConfig::keep>({.key = "keep",
                                .least = 1,
                                .most = 1000,
                                .help = "Most recordings in the folder; the oldest are removed",
                                .example = "100"}),
    row<&RecorderConfig::space_mib>(
        {.key = "space",
         .least = 1,
         .most = 100000,
         .unit = "MiB",
         .help = "Most space that all recordings together take; the oldest are removed",
         .example = "500"}),
};

}  // namespace tribus::key_rows
