#include "app/web/pairing/pair_command.h"

#include <unistd.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/web/pairing/page_folder.h"
#include "app/web/pairing/pairing.h"
#include "config/show/paragraph.h"
#include "pipelines/realtime/clock.h"

namespace tribus::web {
namespace {

struct PairOptions {
    std::string state = "/var/lib/tribus-web";
    std::string configurations = "/etc/tribus";
    std::optional<std::string> revoke;
    bool list = false;
    bool look = false;
    bool close = false;
};

int list(const PairingFolder& folder) {
    const auto sessions = folder.sessions();
    if (!sessions) {
        return complain(sessions.error(), kExitFailed);
    }
    if (sessions->empty()) {
        fmt::print("no browser is paired; `sudo tribus pair` prints a code\n");
    }
    for (const Session& session : *sessions) {
        fmt::print("{:<20} {:<6} since {:%Y-%m-%d}\n", session.name, word_of(session.role),
                   fmt::gmtime(static_cast<std::time_t>(session.made.count())));
    }
    return kExitFine;
}

/// If no browser may change anything, nor by a code, the page has no more to write.
int close_if_unused(const PairingFolder& folder, const PairOptions& options, WallTime now) {
    const PageFolder page{options.configurations, options.state};
    const auto taken = folder.close_if_unused(now, [&] { return page.take_back(); });
    return taken ? kExitFine
                 : complain("the page still may write there: " + taken.error(), kExitFailed);
}

int revoke(PairingFolder& folder, const PairOptions& options, WallTime now) {
    const std::string& name = *options.revoke;
    const auto gone = folder.revoke(name);
    if (!gone) {
        return complain(gone.error(), kExitFailed);
    }
    if (*gone == 0) {
        return complain(
            fmt::format("no paired browser is called {}; `tribus pair --list` names them", name),
            kExitFailed);
    }
    fmt::print("{} may use the page no longer\n", name);
    return close_if_unused(folder, options, now);
}

int run(const PairOptions& options) {
    PairingFolder folder(options.state);
    const auto now = std::chrono::duration_cast<WallTime>(wall_time_now());
    if (options.list) {
        return list(folder);
    }
    if (options.revoke) {
        return revoke(folder, options, now);
    }
    if (options.close) {
        return close_if_unused(folder, options, now);
    }
    tl::expected<void, std::string> given;
    const auto give = [&] {
        given = PageFolder{options.configurations, options.state}.give();
        return given;
    };
    const auto code = options.look ? folder.make_code(Role::look, now)
                                   : folder.make_code(Role::change, now, give);
    if (!given) {
        return complain("the page cannot be allowed to write there: " + given.error(), kExitFailed);
    }
    if (!code) {
        return complain(code.error() + "; use sudo, and install the package that has tribus-web",
                        kExitFailed);
    }
    if (const int closed = options.look ? close_if_unused(folder, options, now) : kExitFine;
        closed != kExitFine) {
        return closed;
    }
    const auto sentence = [](const std::string& text) {
        return paragraph("", "", text, text_columns(STDOUT_FILENO));
    };
    fmt::print(
        "{} {}\n{}    ssh -L 8480:127.0.0.1:8480 USER@BOARD\n{}", code->substr(0, 4),
        code->substr(4),
        sentence("Type this code at http://127.0.0.1:8480/ on this board, or from another machine "
                 "behind"),
        sentence(fmt::format(
            "It is for one browser, which may then {}, and is valid for {} minutes.",
            options.look ? "look" : "look and change the configuration",
            std::chrono::duration_cast<std::chrono::minutes>(PairingFolder::kCodeLasts).count())));
    return kExitFine;
}

}  // namespace

Command pair_command() {
    auto options = std::make_shared<PairOptions>();
    return {
        .name = "pair",
        .help = "Print a code with which a browser may look at, or change, this board",
        .options = {{.name = "--look",
                     .value = &options->look,
                     .help = "The browser may only look"},
                    {.name = "--list",
                     .value = &options->list,
                     .help = "List the paired browsers",
                     .excludes = {"--look"}},
                    {.name = "--revoke",
                     .value = &options->revoke,
                     .help = "Name of a browser that may use the page no longer",
                     .value_name = "NAME",
                     .excludes = {"--look", "--list"}},
                    {.name = "--close",
                     .value = &options->close,
                     .help = "Take the folder of the configurations back from the page if no "
                             "browser may change anything any more; tribus-pairing.service does it",
                     .excludes = {"--look", "--list", "--revoke"}},
                    {.name = "--state",
                     .value = &options->state,
                     .help = "Folder of the paired browsers",
                     .shows_value = true,
                     .value_name = "FOLDER"},
                    {.name = "--configurations",
                     .value = &options->configurations,
                     .help = "Folder of the configurations, which a browser that may change them "
                             "lets the page write",
                     .shows_value = true,
                     .value_name = "FOLDER"}},
        .examples = {{"sudo tribus pair", "a code for a browser that may change this board"},
                     {"sudo tribus pair --list", "which browsers are paired"}},
        .run = [options] { return run(*options); },
    };
}

}  // namespace tribus::web
