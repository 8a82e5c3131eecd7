#include "app/monitor/monitor.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/cli/streams.h"
#include "app/cli/terminal.h"
#include "app/client/ask_daemon.h"
#include "app/client/monitor_link.h"
#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/journal/print_error.h"
#include "app/journal/terminal_stream.h"
#include "app/monitor/monitor_keys.h"
#include "app/monitor/monitor_screen.h"
#include "core/quantity.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

constexpr Duration kScreenPeriod = std::chrono::milliseconds(100);
constexpr Duration kLinePeriod = std::chrono::seconds(1);
constexpr std::string_view kJson = "json";

struct MonitorOptions {
    std::string name;
    std::optional<std::string> socket;
    std::string format = "text";
    std::string period = "200ms";
    bool once = false;
};

/// Follows one daemon until the user ends it.
class Monitor {
  public:
    Monitor(MonitorLink link, MonitorOptions options, MainWait wait)
        : link_(std::move(link)), options_(std::move(options)), wait_(std::move(wait)) {}

    int run() {
        link_.reconnect(monotonic_now());
        if (!link_.connected()) {
            return complain(link_.problem(), kExitFailed);
        }
        const bool live = options_.format != kJson && !options_.once && is_screen(STDOUT_FILENO) &&
                          ::isatty(STDIN_FILENO) == 1;
        if (!live) {
            return follow(options_.format == kJson ? Duration::zero() : kLinePeriod, false);
        }
        const KeyMode keys;
        const AlternateScreen screen;
        return follow(kScreenPeriod, true);
    }

  private:
    int follow(Duration period, bool live) {
        // The first line comes after one period, when there is something to show.
        Instant next_show = later(monotonic_now(), live ? Duration::zero() : period);
        while (!quit_) {
            std::vector<int> watched;
            for (const int descriptor : {link_.descriptor(), live ? STDIN_FILENO : -1}) {
                watched.push_back(descriptor);
            }
            const Instant wake =
                period > Duration::zero() ? next_show : later(monotonic_now(), kLinePeriod);
            const auto signal = wait_.until(wake, watched);
            if (signal && signal != SIGWINCH) {
                return kExitFine;
            }
            if (live) {
                take_keys();
            }
            if (const auto status = take_objects()) {
                return *status;
            }
            const Instant now = monotonic_now();
            const bool due = period > Duration::zero() && now >= next_show;
            if (due || (live && signal == SIGWINCH)) {
                next_show = later(now, period);
                if (!show(live, now)) {
                    return kExitFine;
                }
            }
        }
        return kExitFine;
    }

    /// Returns the exit status if the monitor must end.
    std::optional<int> take_objects() {
        const bool was_connected = link_.connected();
        for (std::string& line : link_.read()) {
            if (options_.format == kJson && !print_line_now(line)) {
                return kExitFine;
            }
            auto object = parse_json(line);
            if (status_fields::text(object, "type") == "error") {
                return complain(status_fields::text(object, "error"), kExitFailed);
            }
            if (!view_.paused && object.is_object()) {
                view_.status = std::move(object);
                came_at_ = monotonic_now();
            }
            if (options_.once) {
                return options_.format == kJson || show(false, monotonic_now())
                           ? std::optional(kExitFine)
                           : std::nullopt;
            }
        }
        link_.reconnect(monotonic_now());
        if (was_connected && !link_.connected() && options_.format == kJson) {
            print_error("tribus: {}\n", link_.problem());
        }
        return std::nullopt;
    }

    void take_keys() {
        std::array<char, 64> bytes;
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&input, 1, 0) <= 0) {
            return;
        }
        const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
        if (count <= 0) {
            quit_ = true;
            return;
        }
        const std::size_t items = selectable(view_.status);
        for (const MonitorKey key : keys_in({bytes.data(), static_cast<std::size_t>(count)})) {
            if (key == MonitorKey::quit) {
                quit_ = true;
            } else if (key == MonitorKey::pause) {
                view_.paused = !view_.paused;
            } else if (key == MonitorKey::page_down || key == MonitorKey::page_up) {
                const int pages = key == MonitorKey::page_down ? 1 : -1;
                view_.top = top_after_pages(view_, screen_style(), pages);
            } else if (items > 0) {
                const std::size_t step = key == MonitorKey::next ? 1 : items - 1;
                view_.selected = (selected_item(view_) + step) % items;
                view_.top = top_that_shows_selected(view_, screen_style());
            }
        }
    }

    bool show(bool live, Instant now) {
        view_.connected = link_.connected();
        view_.notice = link_.problem();
        view_.age = now - came_at_;
        if (live) {
            AlternateScreen::show(draw_monitor(view_, screen_style()));
            return true;
        }
        return print_line_now(monitor_line(view_));
    }

    MonitorLink link_;
    MonitorOptions options_;
    MainWait wait_;
    MonitorView view_;
    Instant came_at_{};
    bool quit_ = false;
};

int monitor_daemon(const MonitorOptions& options) {
    const auto period = parse_duration(options.period);
    if (!period) {
        return complain("--period must be a duration such as \"200ms\"", kExitWrongUse);
    }
    const auto socket = find_daemon(options.name, options.socket, Wants::look);
    if (!socket) {
        return complain(socket.error(), kExitFailed);
    }
    // When the reader of the output goes away (`| head`), the monitor ends normally and restores
    // the terminal.
    std::signal(SIGPIPE, SIG_IGN);
    auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP, SIGWINCH});
    if (!wait) {
        return complain(wait.error(), kExitFailed);
    }
    return Monitor(MonitorLink(*socket, *period), options, std::move(*wait)).run();
}

}  // namespace

Command monitor_command() {
    auto options = std::make_shared<MonitorOptions>();
    return {
        .name = "monitor",
        .help = "Live view of a running daemon",
        .notes =
            "In a terminal: up and down (or Tab) select, PgUp and PgDn (or u and d) scroll, p "
            "pauses, q quits. Without one it prints a line a second. It waits for a daemon that "
            "restarts.",
        .options = {daemon_name_option(options->name),
                    daemon_socket_option(options->socket),
                    {.name = "--format",
                     .value = &options->format,
                     .help = "text, or json: one object a line",
                     .shows_value = true,
                     .choices = {"text", "json"}},
                    {.name = "--period",
                     .value = &options->period,
                     .help = "Time from one status to the next, 50ms to 60s",
                     .shows_value = true,
                     .value_name = "DURATION"},
                    {.name = "--once",
                     .value = &options->once,
                     .help = "End after the first object or line"}},
        .examples = {{"tribus monitor", "the daemon of this machine, if only one runs"},
                     {"tribus monitor servos --once --format json", "the daemon of servos.toml"}},
        .run = [options] { return monitor_daemon(*options); },
    };
}

}  // namespace tribus
