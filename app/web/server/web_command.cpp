#include "app/web/server/web_command.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/journal/log.h"
#include "app/web/http/listeners.h"
#include "app/web/server/page_server.h"
#include "pipelines/realtime/clock.h"

namespace tribus::web {
namespace {

constexpr Duration kUnusedEnd = std::chrono::minutes(10);
constexpr std::string_view kUsualAddress = "127.0.0.1:8480";

struct WebOptions {
    std::vector<std::string> listen;
    std::string configurations = "/etc/tribus";
    std::string state = "/var/lib/tribus-web";
    std::string page = "/usr/share/tribus/page";
    std::vector<std::string> hosts;
    std::string ports;
    bool is_public = false;
    bool metrics = false;
    std::string version;
};

tl::expected<std::vector<Listener>, std::string> listeners_of(const WebOptions& options) {
    auto listeners = inherited_listeners(options.is_public);
    if (!listeners) {
        return listeners;
    }
    std::vector<std::string> addresses = options.listen;
    if (listeners->empty() && addresses.empty()) {
        addresses.emplace_back(kUsualAddress);
    }
    for (const std::string& address : addresses) {
        auto listener = listen_at(address, options.is_public);
        if (!listener) {
            return tl::unexpected(listener.error());
        }
        log_info("the page is at {}", place_of(*listener));
        listeners->push_back(std::move(*listener));
    }
    return listeners;
}

int serve(PageServer& server, MainWait& wait, bool ends_unused) {
    Instant used = monotonic_now();
    for (;;) {
        const Instant end = ends_unused ? later(used, kUnusedEnd) : kNever;
        const auto signal = wait.until(std::min(server.due(), end), server.descriptors());
        if (signal) {
            return kExitFine;
        }
        const Instant now = monotonic_now();
        server.serve(now);
        if (server.in_use()) {
            used = now;
        } else if (ends_unused && now >= end) {
            return kExitFine;
        }
    }
}

int run(const WebOptions& options) {
    auto wait = MainWait::for_signals({SIGTERM, SIGINT});
    if (!wait) {
        log_error("{}", wait.error());
        return kExitFailed;
    }
    auto listeners = listeners_of(options);
    if (!listeners) {
        log_error("{}", listeners.error());
        return kExitFailed;
    }
    const bool ends_unused = options.listen.empty() && std::getenv("LISTEN_FDS") != nullptr;
    auto server = PageServer::make(std::move(*listeners), {.configurations = options.configurations,
                                                           .state = options.state,
                                                           .page = options.page,
                                                           .hosts = options.hosts,
                                                           .is_public = options.is_public,
                                                           .ports = options.ports,
                                                           .metrics = options.metrics,
                                                           .version = options.version});
    if (!server) {
        log_error("{}", server.error());
        return kExitFailed;
    }
    return serve(**server, *wait, ends_unused);
}

}  // namespace

Command web_command(std::string version) {
    auto options = std::make_shared<WebOptions>();
    options->version = std::move(version);
    return {
        .name = "serve",
        .help = "Serve the page of all daemons of this board",
        .options = {{.name = "--listen",
                     .value = &options->listen,
                     .help = "Address, such as 127.0.0.1:8480, or the path of a local socket. "
                             "Default: what systemd listens on, else 127.0.0.1:8480",
                     .value_name = "ADDRESS"},
                    {.name = "--configurations",
                     .value = &options->configurations,
                     .help = "Folder of the configurations",
                     .shows_value = true,
                     .value_name = "FOLDER"},
                    {.name = "--state",
                     .value = &options->state,
                     .help = "Folder of paired browsers and earlier configurations",
                     .shows_value = true,
                     .value_name = "FOLDER"},
                    {.name = "--page",
                     .value = &options->page,
                     .help = "Folder of the built page",
                     .shows_value = true,
                     .value_name = "FOLDER"},
                    {.name = "--host",
                     .value = &options->hosts,
                     .help = "Further name of this machine that browsers may use",
                     .value_name = "NAME"},
                    {.name = "--ports",
                     .value = &options->ports,
                     .help = "Socket of the helper that opens ports for doctor and learn; default: "
                             "a child of this program, with its rights",
                     .value_name = "SOCKET"},
                    {.name = "--metrics",
                     .value = &options->metrics,
                     .help = "Answer Prometheus at /metrics; it needs no pairing"},
                    {.name = "--public",
                     .value = &options->is_public,
                     .help = "Allow an address that the network can reach; nothing is encrypted"}},
        .examples = {{"tribus-web serve", "the page is at http://127.0.0.1:8480"},
                     {"tribus-web serve --listen 192.168.1.20:8480 --public --metrics",
                      "in a network that you trust, with figures for Prometheus"},
                     {"ssh -L 8480:127.0.0.1:8480 USER@BOARD",
                      "from another machine, encrypted, without --public"}},
        .exits = {{kExitFine, "ended by a signal, or nobody used it for 10 minutes"},
                  {kExitFailed, "it cannot listen"},
                  {kExitWrongUse, "wrong use"}},
        .run =
            [options] {
                log_to_journal_or_terminal();
                return run(*options);
            },
    };
}

}  // namespace tribus::web
