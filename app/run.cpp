#include "app/run.h"

#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "app/appliance.h"
#include "app/exit_status.h"
#include "app/inside_view.h"
#include "app/load_or_explain.h"
#include "app/main_wait.h"
#include "app/state_log.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Often enough that a replugged device is back before a failsafe has run its course; each time
/// costs about as much as a frame.
constexpr Duration kTendPeriod = std::chrono::milliseconds(200);

void log_start(const Appliance& appliance) {
    const Configuration& configuration = appliance.configuration();
    for (const std::string& missing : appliance.missing_realtime()) {
        spdlog::warn("no full real time: {}", missing);
    }
    const std::size_t buses = configuration.sensor_buses.size();
    spdlog::info("started {}: {} inputs, {} outputs, {} pipelines{}", configuration.file,
                 configuration.inputs.size(), configuration.outputs.size(),
                 configuration.pipelines.size(),
                 buses == 0 ? "" : fmt::format(", {} sensor buses", buses));
}

std::unique_ptr<Appliance> start_or_log(
    Configuration configuration,
    Appliance::MissingDevices missing = Appliance::MissingDevices::refuse) {
    auto appliance = Appliance::start(std::move(configuration), missing);
    if (!appliance) {
        for (const std::string& error : appliance.error()) {
            spdlog::error("{}", error);
        }
        return nullptr;
    }
    log_start(**appliance);
    return std::move(*appliance);
}

/// A faulty new configuration leaves the old one running. A good one whose devices cannot be opened
/// gives way to the old one again, whether or not one of its own devices is unplugged just now.
std::unique_ptr<Appliance> reload(std::unique_ptr<Appliance> appliance, const std::string& path) {
    std::optional<Configuration> fresh = load_or_explain(path);
    if (!fresh) {
        spdlog::error("reload refused: {} has mistakes; the old configuration runs on", path);
        return appliance;
    }
    Configuration old = appliance->configuration();
    appliance.reset();
    if (auto started = start_or_log(std::move(*fresh))) {
        return started;
    }
    spdlog::error("reload failed; back to the old configuration");
    return start_or_log(std::move(old), Appliance::MissingDevices::wait_for);
}

/// As another node of DroneCAN asked for.
std::unique_ptr<Appliance> restart(std::unique_ptr<Appliance> appliance) {
    spdlog::info("restarting, as another DroneCAN node asked for");
    Configuration configuration = appliance->configuration();
    appliance->end();
    appliance.reset();
    return start_or_log(std::move(configuration), Appliance::MissingDevices::wait_for);
}

/// Until it is told to end.
int run(const std::string& path, std::unique_ptr<Appliance> appliance, MainWait& wait,
        InsideView& inside) {
    std::unique_ptr<StateLog> log;
    const auto begin = [&] {
        if (appliance) {
            log = std::make_unique<StateLog>(*appliance, monotonic_now());
            inside.show(*appliance, monotonic_now());
        }
    };
    begin();
    Instant next_look = later(monotonic_now(), kTendPeriod);
    while (appliance) {
        const auto signal = wait.until(std::min(next_look, inside.due()), inside.descriptors());
        if (signal == SIGTERM || signal == SIGINT) {
            appliance->end();
            spdlog::info("stopped");
            return kExitFine;
        }
        if (signal == SIGHUP) {
            appliance = reload(std::move(appliance), path);
            begin();
        } else if (const Instant now = monotonic_now(); now >= next_look) {
            next_look = later(now, kTendPeriod);
            log->look(*appliance, now);
            appliance->look_at_machine(now, inside.watched());
            inside.look();
        }
        if (appliance && appliance->restart_wanted()) {
            appliance = restart(std::move(appliance));
            begin();
        }
        if (appliance) {
            inside.serve(monotonic_now());
        }
    }
    return kExitFailed;
}

struct RunOptions {
    std::string path;
    std::optional<std::string> socket;
    std::string metrics;
    bool metrics_public = false;
};

int run(const RunOptions& options) {
    std::optional<Configuration> configuration = load_or_explain(options.path);
    if (!configuration) {
        return kExitWrongUse;
    }
    auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP});
    if (!wait) {
        spdlog::error("{}", wait.error());
        return kExitFailed;
    }
    auto inside = InsideView::open(options.path, options.socket);
    if (!inside) {
        spdlog::error("{}", inside.error());
        return kExitFailed;
    }
    if (!options.metrics.empty()) {
        const auto reach = options.metrics_public ? MetricsReach::network : MetricsReach::local;
        if (auto told = (*inside)->tell_metrics(options.metrics, reach); !told) {
            spdlog::error("{}", told.error());
            return kExitFailed;
        }
    }
    return run(options.path, start_or_log(std::move(*configuration)), *wait, **inside);
}

}  // namespace

void add_run_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand("run", "Run a configuration, in the foreground");
    auto options = std::make_shared<RunOptions>();
    command->add_option("CONFIG", options->path, "Configuration file")->required();
    command->add_option("--socket", options->socket,
                        "Control socket, for `tribus monitor`; default: `control` in\n"
                        "$RUNTIME_DIRECTORY, or tribus/NAME.sock in /run or $XDG_RUNTIME_DIR");
    command->add_option("--metrics", options->metrics,
                        "Tell Prometheus metrics at 127.0.0.1:PORT, [::1]:PORT, or a local socket");
    command->add_flag("--metrics-public", options->metrics_public,
                      "Allow an address for --metrics that the network can reach");
    command->footer(
        "SIGTERM and Ctrl-C: outputs end as their failsafe says, then the program exits.\n"
        "SIGHUP: reads the configuration again; one with mistakes is refused.");
    command->callback([options, &status] {
        auto logger = spdlog::stderr_color_st("tribus");
        logger->set_pattern("%H:%M:%S.%e %^%l%$ %v");
        spdlog::set_default_logger(std::move(logger));
        status = run(*options);
    });
}

}  // namespace tribus
