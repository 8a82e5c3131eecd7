#include "app/status_command/status_command.h"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/cli/object_text.h"
#include "app/cli/streams.h"
#include "app/client/ask_daemon.h"
#include "app/client/change_reader.h"
#include "app/client/monitor_link.h"
#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/status_command/summary.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// A daemon that is alive answers within milliseconds.
constexpr Duration kStatusPatience = std::chrono::seconds(2);
/// The time from one status to the next while it watches.
constexpr Duration kWatchPeriod = std::chrono::milliseconds(200);

struct StatusOptions {
    std::string name;
    std::optional<std::string> socket;
    std::string format = "text";
    bool watch = false;

    bool json() const { return format == "json"; }
};

std::int64_t whole_us(Duration duration) {
    return std::chrono::duration_cast<std::chrono::microseconds>(duration).count();
}

bool print_whole(const StatusOptions& options, const nlohmann::ordered_json& found) {
    if (options.json()) {
        return print_line_now(json_text(found));
    }
    std::string text;
    for (const std::string& line : status_summary::lines(found)) {
        text += (text.empty() ? "" : "\n") + line;
    }
    return print_line_now(text);
}

/// Follows one daemon, and prints what changes.
class StatusWatch {
  public:
    StatusWatch(MonitorLink link, StatusOptions options, MainWait wait)
        : link_(std::move(link)), options_(std::move(options)), wait_(std::move(wait)) {}

    int run() {
        came_at_ = monotonic_now();
        link_.reconnect(came_at_);
        if (!link_.connected()) {
            return complain(link_.problem(), kExitFailed);
        }
        std::optional<int> end;
        while (!end) {
            const auto signal =
                wait_.until(later(monotonic_now(), kWatchPeriod), std::array{link_.descriptor()});
            end = signal ? std::optional(kExitFine) : step();
        }
        return *end;
    }

  private:
    /// Returns the exit status if the watch must end.
    std::optional<int> step() {
        for (const std::string& line : link_.read()) {
            if (const auto end = take(parse_json(line))) {
                return end;
            }
        }
        const Instant now = monotonic_now();
        if (!link_.connected()) {
            if (const auto end = miss(link_.problem())) {
                return end;
            }
            link_.reconnect(now);
        } else if (now - came_at_ > kStatusPatience) {
            return miss("it runs but is silent");
        }
        return std::nullopt;
    }

    std::optional<int> take(const nlohmann::json& object) {
        const std::string type = status_fields::raw_text(object, "type");
        if (type == "changes") {
            return take_changes(changes_.take_answer(object));
        }
        if (type == "error") {
            return complain(status_fields::text(object, "error"), kExitFailed);
        }
        auto found = status_summary::of_status(object);
        if (!found) {
            return complain(found.error(), kExitFailed);
        }
        if (const auto request = changes_.take_status(object)) {
            link_.send(*request);
        }
        came_at_ = monotonic_now();
        const bool old = status_fields::flag(nlohmann::json(*found), "figures_old");
        bool read = true;
        if (!answers_ && !latest_.is_null()) {
            read = print_daemon("answers", true, "answers again");
        }
        latest_ = std::move(*found);
        if (!std::exchange(answers_, true)) {
            read = read && print_whole(options_, latest_);
        } else if (old != figures_old_) {
            read = print_daemon("figures_old", old,
                                old ? "stands still: nothing is known about now" : "goes on");
            // The summary before it said "unknown" of everything, perhaps.
            read = read && (old || print_whole(options_, latest_));
        }
        figures_old_ = old;
        return read ? std::nullopt : std::optional(kExitFine);
    }

    std::optional<int> take_changes(const ChangeReader::News& news) {
        bool read = true;
        if (news.lost > 0) {
            read = print_daemon("changes_lost", true,
                                fmt::format("{} came and went before", news.lost));
        }
        for (const auto& change : news.changes) {
            read = read && print_change(status_summary::of_change(change));
        }
        if (news.request) {
            link_.send(*news.request);
        }
        return read ? std::nullopt : std::optional(kExitFine);
    }

    /// The daemon has gone or is silent: what was told of it counts no more.
    std::optional<int> miss(const std::string& why) {
        changes_.disconnected();
        if (latest_.is_null()) {
            return complain(why, kExitFailed);
        }
        if (!std::exchange(answers_, false)) {
            return std::nullopt;
        }
        return print_daemon("answers", false, "does not answer", why) ? std::nullopt
                                                                      : std::optional(kExitFine);
    }

    bool print_daemon(std::string field, bool now, std::string text, std::string why = "") const {
        return print_change(status_summary::change_of_daemon(
            latest_, {.field = std::move(field),
                      .now = now,
                      .text = std::move(text),
                      .why = std::move(why),
                      .t_us = whole_us(monotonic_now().time_since_epoch()),
                      .unix_time_us = whole_us(wall_time_now())}));
    }

    bool print_change(const nlohmann::ordered_json& change) const {
        return print_line_now(options_.json() ? json_text(change) : status_summary::line(change));
    }

    MonitorLink link_;
    StatusOptions options_;
    MainWait wait_;
    ChangeReader changes_;
    nlohmann::ordered_json latest_;
    bool answers_ = false;
    bool figures_old_ = false;
    Instant came_at_{};
};

int show_status(const StatusOptions& options) {
    const auto socket = find_daemon(options.name, options.socket, Wants::look);
    if (!socket) {
        return complain(socket.error(), kExitFailed);
    }
    // When the reader of the output goes away (`| head`), the command ends normally.
    std::signal(SIGPIPE, SIG_IGN);
    if (options.watch) {
        auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP});
        return wait ? StatusWatch(MonitorLink(*socket, kWatchPeriod), options, std::move(*wait))
                          .run()
                    : complain(wait.error(), kExitFailed);
    }
    const auto answer = ask_daemon(*socket, "status", kStatusPatience);
    if (!answer) {
        return complain(answer.error(), kExitFailed);
    }
    const auto found = status_summary::of_status(*answer);
    if (!found) {
        return complain(fmt::format("{}: {}", *socket, found.error()), kExitFailed);
    }
    print_whole(options, *found);
    return kExitFine;
}

}  // namespace

Command status_command() {
    auto options = std::make_shared<StatusOptions>();
    return {
        .name = "status",
        .help = "Summary of a running daemon for scripts",
        .notes = "--watch says when the daemon goes away, and waits for it.",
        .options = {daemon_name_option(options->name),
                    daemon_socket_option(options->socket),
                    {.name = "--format",
                     .value = &options->format,
                     .help = "text, or json: one object a line",
                     .shows_value = true,
                     .choices = {"text", "json"}},
                    {.name = "--watch",
                     .value = &options->watch,
                     .help = "Go on, with a line for each change"}},
        .examples = {{"tribus status", "the daemon of this machine, if only one runs"},
                     {"tribus status servos --format json | jq .outputs", ""},
                     {"tribus status --watch", "what changes, as it changes"}},
        .exits = {{kExitFine, "the daemon answered, whatever it says"},
                  {kExitFailed, "it did not answer"}},
        .run = [options] { return show_status(*options); },
    };
}

}  // namespace tribus
