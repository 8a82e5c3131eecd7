#include "app/run.h"

#include <csignal>
#include <ctime>
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
#include "app/journal.h"
#include "app/load_or_explain.h"
#include "app/service_notify.h"
#include "app/state_log.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Often enough that a replugged device is back before a failsafe has run its course; each time
/// costs about as much as a frame.
constexpr timespec kTendPeriod{.tv_sec = 0, .tv_nsec = 200'000'000};

sigset_t handled_signals() {
    sigset_t signals;
    ::sigemptyset(&signals);
    ::sigaddset(&signals, SIGTERM);
    ::sigaddset(&signals, SIGINT);
    ::sigaddset(&signals, SIGHUP);
    return signals;
}

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

/// From the start of an appliance, or of none, on.
std::unique_ptr<StateLog> begin_watch(const Appliance* appliance, ServiceNotify& service) {
    if (appliance == nullptr) {
        return nullptr;
    }
    const Instant now = monotonic_now();
    service.started(*appliance, now);
    return std::make_unique<StateLog>(*appliance, now);
}

int run(const std::string& path) {
    ServiceNotify service;
    std::optional<Configuration> configuration = load_or_explain(path);
    if (!configuration) {
        return kExitWrongUse;
    }
    // Blocked before the data thread exists, so that it inherits that.
    const sigset_t signals = handled_signals();
    ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::unique_ptr<Appliance> appliance = start_or_log(std::move(*configuration));
    auto log = begin_watch(appliance.get(), service);
    while (appliance) {
        const int signal = ::sigtimedwait(&signals, nullptr, &kTendPeriod);
        if (signal == SIGTERM || signal == SIGINT) {
            service.stopping();
            appliance->end();
            spdlog::info("stopped");
            return kExitFine;
        }
        if (signal == SIGHUP) {
            service.reloading(monotonic_now());
            appliance = reload(std::move(appliance), path);
            log = begin_watch(appliance.get(), service);
        } else {
            log->look(*appliance, monotonic_now());
            appliance->look_at_machine(monotonic_now());
            service.look(*appliance, monotonic_now());
        }
        if (appliance && appliance->restart_wanted()) {
            service.reloading(monotonic_now());
            appliance = restart(std::move(appliance));
            log = begin_watch(appliance.get(), service);
        }
    }
    return kExitFailed;
}

}  // namespace

void add_run_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand("run", "Run a configuration, in the foreground");
    auto path = std::make_shared<std::string>();
    command->add_option("CONFIG", *path, "Configuration file")->required();
    command->footer(
        "SIGTERM and Ctrl-C: outputs end as their failsafe says, then the program exits.\n"
        "SIGHUP: reads the configuration again; one with mistakes is refused.");
    command->callback([path, &status] {
        auto logger = spdlog::stderr_color_st("tribus");
        if (stderr_is_journal()) {
            logger->set_formatter(journal_formatter());
        } else {
            logger->set_pattern("%H:%M:%S.%e %^%l%$ %v");
        }
        spdlog::set_default_logger(std::move(logger));
        status = run(*path);
    });
}

}  // namespace tribus
