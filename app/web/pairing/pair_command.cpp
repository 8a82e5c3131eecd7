#include "app/web/pairing/pair_command.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/streams.h"
#include "app/web/pairing/pairing.h"
#include "config/show/paragraph.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {
namespace {

constexpr mode_t kPermissions = 07777;

struct PairOptions {
    std::string state = "/var/lib/tribus-web";
    std::string configurations = "/etc/tribus";
    std::optional<std::string> revoke;
    bool list = false;
    bool look = false;
};

int list(const PairingFolder& folder) {
    const auto sessions = folder.sessions();
    if (!sessions) {
        return fail(sessions.error(), kExitFailed);
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

/// A browser that may change configurations needs a page that may write them: the folder gets the
/// group of the page's folder, and the group may write there until no such browser is left. Only
/// root can do that, and only where the package is installed.
bool set_page_writes(const PairOptions& options, bool writes) {
    struct stat page {};
    if (::geteuid() != 0 || ::stat(options.state.c_str(), &page) != 0 || page.st_uid == 0) {
        return true;
    }
    const UniqueFd folder(
        ::open(options.configurations.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    struct stat before {};
    if (!folder.valid() || ::fstat(folder.get(), &before) != 0) {
        return false;
    }
    const mode_t mode = before.st_mode & kPermissions;
    if (!writes) {
        return before.st_gid != page.st_gid || ::fchmod(folder.get(), mode & ~mode_t{S_IWGRP}) == 0;
    }
    return ::fchown(folder.get(), static_cast<uid_t>(-1), page.st_gid) == 0 &&
           ::fchmod(folder.get(), mode | S_IWGRP) == 0;
}

int revoke(PairingFolder& folder, const PairOptions& options, WallTime now) {
    const std::string& name = *options.revoke;
    const auto gone = folder.revoke(name);
    if (!gone) {
        return fail(gone.error(), kExitFailed);
    }
    if (*gone == 0) {
        return fail(
            fmt::format("no paired browser is called {}; `tribus pair --list` names them", name),
            kExitFailed);
    }
    fmt::print("{} may use the page no longer\n", name);
    if (!folder.lets_change(now) && !set_page_writes(options, false)) {
        return fail(fmt::format("{}: the page still may write there: {}", options.configurations,
                                std::strerror(errno)),
                    kExitFailed);
    }
    return kExitFine;
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
    const auto code = folder.make_code(options.look ? Role::look : Role::change, now);
    if (!code) {
        return fail(code.error() + "; use sudo, and install the package that has tribus-web",
                    kExitFailed);
    }
    if (!options.look && !set_page_writes(options, true)) {
        return fail(fmt::format("{}: the page cannot be allowed to write there: {}",
                                options.configurations, std::strerror(errno)),
                    kExitFailed);
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
