#include "app/run.h"

#include <algorithm>
#include <csignal>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "app/appliance.h"
#include "app/exit_status.h"
#include "app/inside_view.h"
#include "app/journal.h"
#include "app/load_or_explain.h"
#include "app/main_wait.h"
#include "app/service_notify.h"
#include "app/state_log.h"
#include "config/carry_over.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Often enough that a replugged device is back before a failsafe has run its course; each time
/// costs about as much as a frame.
constexpr Duration kTendPeriod = std::chrono::milliseconds(200);

/// What runs, with what tells of it; without an appliance where nothing could be started.
struct Running {
    std::unique_ptr<Appliance> appliance;
    InsideView& inside;
    ServiceNotify& service;
    std::unique_ptr<StateLog> log{};

    /// Tells of the appliance, which has just started.
    void watch() {
        const Instant now = monotonic_now();
        if (appliance) {
            log = std::make_unique<StateLog>(*appliance, now);
            log->say_interfaces(*appliance);
            inside.show(*appliance, now);
            service.started(*appliance, now);
        }
    }
    /// Tells of it, which goes on from one that had those ports.
    void watch_on(const std::vector<PortPlan>& ports_before) {
        const Instant now = monotonic_now();
        log = std::make_unique<StateLog>(*appliance, now);
        log->take_as_known(*appliance);
        const bool new_port = std::ranges::any_of(appliance->ports(), [&](const PortPlan& port) {
            return std::ranges::none_of(ports_before, [&](const PortPlan& before) {
                return same_device(before.config, port.config);
            });
        });
        if (new_port) {
            log->say_interfaces(*appliance);
        }
        // Devices with other line settings are opened here.
        log->look(*appliance, now);
        inside.show(*appliance, now);
        service.started(*appliance, now);
    }
    /// A few times a second.
    void look(Instant now) {
        log->look(*appliance, now);
        appliance->look_at_machine(now, inside.watched());
        inside.look();
        service.look(*appliance, now);
        appliance->look_at_recorder(now);
    }
};

std::string summary(const Configuration& configuration) {
    const std::size_t buses = configuration.sensor_buses.size();
    return fmt::format("{}: {} inputs, {} outputs, {} pipelines{}", configuration.file,
                       configuration.inputs.size(), configuration.outputs.size(),
                       configuration.pipelines.size(),
                       buses == 0 ? "" : fmt::format(", {} sensor buses", buses));
}

void log_start(const Appliance& appliance) {
    for (const std::string& missing : appliance.missing_realtime()) {
        spdlog::warn("no full real time: {}", missing);
    }
    spdlog::info("started {}", summary(appliance.configuration()));
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

/// For what cannot change while frames flow. A configuration whose devices cannot be opened gives
/// way to the old one again, whether or not one of its own devices is unplugged just now.
void stop_and_start(Running& running, Configuration fresh) {
    Configuration old = running.appliance->configuration();
    running.appliance.reset();
    running.appliance = start_or_log(std::move(fresh));
    if (!running.appliance) {
        spdlog::error("reload failed; back to the old configuration");
        running.appliance = start_or_log(std::move(old), Appliance::MissingDevices::wait_for);
    }
    running.watch();
}

/// A configuration that has mistakes, or whose devices cannot be opened, leaves the old one running
/// as if nothing had been asked for.
void reload(Running& running, const std::string& path) {
    running.service.reloading(monotonic_now());
    std::optional<Configuration> fresh = load_or_explain(path);
    if (!fresh) {
        spdlog::error("reload refused: {} has mistakes; the old configuration runs on", path);
        running.service.started(*running.appliance, monotonic_now());
        return;
    }
    const CarryOver carry_over = plan_carry_over(running.appliance->configuration(), *fresh);
    if (!carry_over.obstacles.empty()) {
        for (const std::string& obstacle : carry_over.obstacles) {
            spdlog::warn("reload with a stop, outputs go into failsafe: {}", obstacle);
        }
        stop_and_start(running, std::move(*fresh));
        return;
    }
    const std::vector<PortPlan> ports_before = running.appliance->ports();
    auto next = Appliance::succeed(running.appliance, std::move(*fresh), carry_over);
    if (!next) {
        for (const std::string& error : next.error()) {
            spdlog::error("{}", error);
        }
        spdlog::error("reload refused: {} cannot be set up; the old configuration runs on", path);
        running.service.started(*running.appliance, monotonic_now());
        return;
    }
    running.appliance = std::move(*next);
    spdlog::info("reloaded {}", summary(running.appliance->configuration()));
    running.watch_on(ports_before);
}

/// As another node of DroneCAN asked for.
void restart(Running& running) {
    running.service.reloading(monotonic_now());
    spdlog::info("restarting, as another DroneCAN node asked for");
    Configuration configuration = running.appliance->configuration();
    running.appliance->end();
    running.appliance.reset();
    running.appliance = start_or_log(std::move(configuration), Appliance::MissingDevices::wait_for);
    running.watch();
}

/// Until it is told to end.
int run(const std::string& path, std::unique_ptr<Appliance> appliance, MainWait& wait,
        InsideView& inside, ServiceNotify& service) {
    Running running{std::move(appliance), inside, service};
    running.watch();
    Instant next_look = later(monotonic_now(), kTendPeriod);
    while (running.appliance) {
        const auto signal = wait.until(std::min(next_look, inside.due()), inside.descriptors());
        if (signal && (*signal == SIGTERM || *signal == SIGINT)) {
            service.stopping();
            running.appliance->end();
            spdlog::info("stopped");
            return kExitFine;
        }
        if (signal == SIGHUP) {
            reload(running, path);
        } else if (const Instant now = monotonic_now(); now >= next_look) {
            next_look = later(now, kTendPeriod);
            running.look(now);
        }
        if (running.appliance && running.appliance->restart_wanted()) {
            restart(running);
        }
        if (running.appliance) {
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
    ServiceNotify service;
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
    return run(options.path, start_or_log(std::move(*configuration)), *wait, **inside, service);
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
        "SIGHUP: reads the configuration again and takes it between two frames; one with "
        "mistakes,\n"
        "or whose devices cannot be opened, is refused and the old one runs on.");
    command->callback([options, &status] {
        auto logger = spdlog::stderr_color_st("tribus");
        if (stderr_is_journal()) {
            logger->set_formatter(journal_formatter());
        } else {
            logger->set_pattern("%H:%M:%S.%e %^%l%$ %v");
        }
        spdlog::set_default_logger(std::move(logger));
        status = run(*options);
    });
}

}  // namespace tribus
