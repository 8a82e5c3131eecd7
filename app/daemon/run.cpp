#include "app/daemon/run.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/cli/main_wait.h"
#include "app/daemon/control_requests.h"
#include "app/daemon/daemon.h"
#include "app/daemon/daemon_sockets.h"
#include "app/daemon/preparation.h"
#include "app/daemon/service_notify.h"
#include "app/journal/log.h"
#include "config/build/machine_mistakes.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "pipelines/realtime/scheduling.h"
#include "transports/links/start_thread.h"

namespace tribus {
namespace {

/// Period of `Daemon::look`: short enough to reopen a replugged device quickly; each round costs
/// about as much as a frame.
constexpr Duration kLookPeriod = std::chrono::milliseconds(200);

/// Returns when a signal ends the program.
int run(Daemon& daemon, MainWait& wait, DaemonSockets& sockets) {
    Instant next_look = later(monotonic_now(), kLookPeriod);
    while (daemon.runs()) {
        std::vector<int> descriptors = sockets.descriptors();
        descriptors.push_back(daemon.descriptor());
        const Instant due = std::min({next_look, sockets.due(), daemon.due()});
        const auto signal = wait.until(due, descriptors);
        if (signal && (*signal == SIGTERM || *signal == SIGINT)) {
            daemon.end();
            return kExitFine;
        }
        if (signal == SIGHUP) {
            daemon.note_hang_up();
        }
        const Instant now = monotonic_now();
        daemon.go_on(now);
        if (daemon.runs() && now >= next_look) {
            next_look = later(now, kLookPeriod);
            daemon.look(now);
        }
        // To ask for connections in each round would take a third of its time.
        const bool asked = wait.other_readable() || sockets.watched() || now >= sockets.due();
        if (asked && daemon.runs()) {
            sockets.serve(monotonic_now());
        }
    }
    return kExitFailed;
}

struct RunOptions {
    std::string path;
    std::optional<std::string> socket;
};

/// A status with many pipelines is 100 KiB and more. As its own mapping it is returned to the
/// system; in the heap it would leave gaps between lasting objects, and the heap would grow for
/// hours.
void keep_long_texts_out_of_the_heap() {
    constexpr int kLongTextBytes = 64 * 1024;
    ::mallopt(M_MMAP_THRESHOLD, kLongTextBytes);
}

/// Links to slow kernel interfaces have threads, all of whose stack is locked into memory.
void keep_stacks_small() {
    if (const int error = set_usual_stack(kRealtimeStackBytes); error != 0) {
        log_warning("threads have large stacks: {}", std::strerror(error));
    }
}

int run(const RunOptions& options) {
    keep_long_texts_out_of_the_heap();
    keep_stacks_small();
    ServiceNotify service;
    auto configuration = load_configuration_file(options.path);
    if (!configuration) {
        explain_mistakes(configuration.error());
        // On kExitFailed systemd starts the service again. On kExitWrongUse it does not, because
        // somebody must correct the file.
        return may_be_temporary(configuration.error()) ? kExitFailed : kExitWrongUse;
    }
    if (const auto mistakes = mistaken_processor(*configuration, configured_processors());
        !mistakes.empty()) {
        explain_mistakes(mistakes);
        return kExitWrongUse;
    }
    auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP});
    if (!wait) {
        log_error("{}", wait.error());
        return kExitFailed;
    }
    auto sockets = DaemonSockets::open(options.path, options.socket);
    if (!sockets) {
        log_error("{}", sockets.error());
        return kExitFailed;
    }
    Daemon daemon(options.path, **sockets, service);
    if (ControlServer* const control = (*sockets)->control()) {
        add_control_requests(*control, daemon);
    }
    if (ControlServer* const look = (*sockets)->look_only()) {
        add_telling_requests(*look, daemon);
    }
    daemon.start(std::move(*configuration));
    return run(daemon, *wait, **sockets);
}

}  // namespace

Command run_command() {
    auto options = std::make_shared<RunOptions>();
    return {
        .name = "run",
        .help = "Run a configuration, in the foreground",
        .notes =
            "SIGTERM and Ctrl-C: outputs send their last frames as their failsafe demands, then "
            "the program exits. SIGHUP: reads the configuration again and takes it between two "
            "frames. If it has mistakes or its devices cannot be opened, the old one goes on.",
        .options = {configuration_option(options->path),
                    {.name = "--socket",
                     .value = &options->socket,
                     .help = "Control socket, for `tribus monitor`; default: `control` in "
                             "$RUNTIME_DIRECTORY, or tribus/NAME.sock in /run or $XDG_RUNTIME_DIR",
                     .value_name = "SOCKET"}},
        .examples = {{"tribus run servos.toml", "until Ctrl-C; `tribus monitor` shows it at work"},
                     {"sudo systemctl enable --now tribus@servos",
                      "the same as a service, of /etc/tribus/servos.toml"}},
        .exits = {{kExitFine, "ended by a signal"}},
        .run =
            [options] {
                log_to_journal_or_terminal();
                const int status = run(*options);
                if (Preparation::any_abandoned()) {
                    std::fflush(nullptr);
                    ::_exit(status);
                }
                return status;
            },
    };
}

}  // namespace tribus
