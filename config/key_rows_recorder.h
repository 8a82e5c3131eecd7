#pragma once

#include <array>

#include "config/key_rows.h"

/// Rows of the flight recorder.
namespace tribus::key_rows {

using enum SettingType;

inline constexpr std::array kRecorderKeys{
    Key{{.key = "directory",
         .type = text,
         .help = "Folder for recordings; the default is the service's own, /var/lib/tribus/NAME"}},
    Key{{.key = "memory",
         .type = integer,
         .fallback = "1024",
         .least = 16,
         .most = 65536,
         .help = "For each port, KiB; 64 bytes hold a frame of i.Bus, SBUS or classic CAN"}},
    Key{{.key = "before",
         .type = duration,
         .fallback = "\"30s\"",
         .least = 1,
         .most = 3600,
         .help = "At most so much of what came before the event is written"}},
    Key{{.key = "after",
         .type = duration,
         .fallback = "\"2s\"",
         .least = 0,
         .most = 60,
         .help = "And so much of what follows it"}},
    Key{{.key = "on_failsafe",
         .type = boolean,
         .fallback = "true",
         .help =
             "An output that goes into failsafe is an event; false: only crashes and requests"}},
    Key{{.key = "pause",
         .type = duration,
         .fallback = "\"60s\"",
         .least = 0,
         .most = 3600,
         .help = "For so long after a recording no other is made, unless somebody asks for one"}},
    Key{{.key = "keep",
         .type = integer,
         .fallback = "20",
         .least = 1,
         .most = 1000,
         .help = "Recordings; the oldest are removed"}},
    Key{{.key = "space",
         .type = integer,
         .fallback = "100",
         .least = 1,
         .most = 100000,
         .help = "MiB that all recordings may take together; the oldest are removed"}},
};

}  // namespace tribus::key_rows
