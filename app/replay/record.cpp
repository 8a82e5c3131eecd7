#include "app/replay/record.h"

#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/line_use.h"
#include "app/cli/protocol_use.h"
#include "app/client/ask_daemon.h"
#include "app/client/status_fields.h"
#include "app/replay/record_port.h"
#include "core/quantity.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

constexpr Duration kAnswerPatience = std::chrono::seconds(5);
/// A slow card needs time for some hundred megabytes.
constexpr Duration kDiskPatience = std::chrono::minutes(5);
constexpr timespec kAskPause{.tv_sec = 0, .tv_nsec = 20'000'000};
constexpr std::uintmax_t kBytesPerMib = std::uintmax_t{1024} * 1024;

struct RecordOptions {
    std::string target;
    std::optional<std::string> socket;
    std::string out;
    std::string protocol;
    std::string baud;
    std::string time;
    std::uint64_t limit_mib = 100;
    bool force = false;
};

/// Asks until the folder is complete, or cannot be written.
int ask_for_recording(const RecordOptions& options) {
    const auto socket = find_daemon(options.target, options.socket);
    if (!socket) {
        return complain(socket.error(), kExitFailed);
    }
    auto answer = ask_daemon(*socket, "record", kAnswerPatience);
    const Instant end = later(monotonic_now(), kDiskPatience);
    while (answer && status_fields::text(*answer, "state") == "writing" && monotonic_now() < end) {
        ::nanosleep(&kAskPause, nullptr);
        const auto number = status_fields::count(*answer, "number");
        answer = ask_daemon(*socket, fmt::format("record {}", number), kAnswerPatience);
    }
    if (!answer) {
        return complain(answer.error(), kExitFailed);
    }
    if (status_fields::text(*answer, "state") != "written") {
        const std::string reason = status_fields::text(*answer, "reason");
        return complain(
            "nothing was recorded: " + (reason.empty() ? "the disk is too slow" : reason),
            kExitFailed);
    }
    fmt::print("{}\n", status_fields::raw_text(*answer, "folder"));
    return kExitFine;
}

int record(const RecordOptions& options) {
    if (options.out.empty()) {
        if (is_device_path(options.target) && !options.target.ends_with(".toml")) {
            return complain(
                fmt::format("to record the port {}, name a file with --out FILE", options.target),
                kExitWrongUse);
        }
        return ask_for_recording(options);
    }
    if (options.target.empty() || options.socket) {
        return complain("--out is for a port: tribus record DEVICE|INTERFACE --out FILE",
                        kExitWrongUse);
    }
    PortRecording recording{.port = options.target,
                            .protocol = options.protocol,
                            .baud = options.baud,
                            .file = options.out,
                            .force = options.force,
                            .time = {},
                            .most_bytes = options.limit_mib * kBytesPerMib};
    if (!options.time.empty()) {
        recording.time = parse_duration(options.time);
        if (!recording.time || *recording.time <= Duration::zero()) {
            return complain("--for must be a duration such as \"10s\"", kExitWrongUse);
        }
    }
    return record_port(recording);
}

}  // namespace

Command record_command() {
    auto options = std::make_shared<RecordOptions>();
    return {
        .name = "record",
        .help = "Record with a daemon's flight recorder, or directly from a port",
        .notes =
            "Without --out it asks a daemon whose configuration has [recorder] for a recording, "
            "and prints the folder. With --out it reads a port that no other program uses; CAN "
            "interfaces are shared. `decode`, `simulate` and `replay` read the files.",
        .options = {{.name = "TARGET",
                     .value = &options->target,
                     .help = "Name of the daemon's configuration file, if several run; with --out "
                             "a serial device or CAN interface",
                     .value_name = "NAME|DEVICE",
                     .offers = running_daemons},
                    daemon_socket_option(options->socket),
                    {.name = "--out",
                     .value = &options->out,
                     .help = "File for what arrives at the port",
                     .value_name = "FILE"},
                    line_protocol_option(options->protocol),
                    line_baud_option(options->baud),
                    {.name = "--for",
                     .value = &options->time,
                     .help = "How long, such as 10s; default: until Ctrl-C",
                     .value_name = "DURATION"},
                    {.name = "--limit",
                     .value = &options->limit_mib,
                     .help = "Largest size of the file",
                     .shows_value = true,
                     .range = {{1, 100000}},
                     .value_name = "MIB"},
                    {.name = "--force", .value = &options->force, .help = "Overwrite the file"}},
        .examples = {{"tribus record servos", "what passed the ports of the daemon of servos.toml"},
                     {"tribus record /dev/ttyAMA5 --protocol ibus --out receiver.txt --for 10s",
                      ""},
                     {"tribus record can0 --out drive.log", "until Ctrl-C"}},
        .run = [options] { return record(*options); },
    };
}

}  // namespace tribus
