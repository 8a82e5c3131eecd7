#include "app/inspect/reload.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/cli/streams.h"
#include "app/client/ask_daemon.h"
#include "app/client/control_socket.h"
#include "app/client/draft.h"
#include "app/client/status_fields.h"
#include "app/journal/print_error.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "core/quantity.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

/// Time to open devices and to send the last frames of outputs that are removed.
constexpr Duration kReloadPatience = std::chrono::seconds(20);
/// The daemon reads the file first, and gives up after a minute: who gives up before would not know
/// whether the draft stays.
constexpr Duration kConfirmPatience = std::chrono::seconds(70);

struct ReloadOptions {
    std::string name;
    std::optional<std::string> socket;
    std::string trial;
    std::optional<std::string> draft;
    std::optional<std::int64_t> number;
    bool confirm = false;
    bool back = false;
};

/// Prints what the daemon did. `told`: receives its answer.
int ask_and_tell(const std::string& socket, const std::string& request, const char* taken,
                 nlohmann::json* told = nullptr, Duration patience = kReloadPatience) {
    const auto answer = ask_daemon(socket, request, patience);
    if (!answer) {
        return complain(answer.error(), kExitFailed);
    }
    if (told != nullptr) {
        *told = *answer;
    }
    const bool done = status_fields::flag(*answer, "taken");
    for (const auto& line : status_fields::list(*answer, "lines")) {
        print_error("{}{}\n", done ? "outputs stopped for it: " : "",
                    status_fields::shown(line.is_string() ? line.get<std::string>() : line.dump()));
    }
    print_error("tribus: {}\n", done ? taken : "refused; the configuration before stays");
    return done ? kExitFine : kExitFailed;
}

/// Gives the daemon the text of `file` as its draft. The error is a sentence.
tl::expected<void, std::string> hand_draft_over(const std::string& socket,
                                                const std::string& file) {
    const auto text = read_file(file, kMostConfigurationBytes + 1, FileKinds::any);
    if (!text) {
        return tl::unexpected(fmt::format("{}: {}", file, text.error()));
    }
    if (const auto made = ask_daemon(socket, "draft", kReloadPatience); !made) {
        return tl::unexpected(made.error());
    }
    if (!write_draft(socket, *text)) {
        return tl::unexpected(
            fmt::format("{}: cannot be written: {}", draft_file(socket), std::strerror(errno)));
    }
    return {};
}

enum class Choice : std::uint8_t { keep, back, too_late };

/// Waits for Enter, a signal, or `end`.
Choice ask_person(MainWait& wait, Instant end) {
    while (monotonic_now() < end) {
        if (wait.until(end, std::array{STDIN_FILENO})) {
            return Choice::back;
        }
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&input, 1, 0) > 0) {
            char key = 0;
            return ::read(STDIN_FILENO, &key, 1) == 1 ? Choice::keep : Choice::back;
        }
    }
    return Choice::too_late;
}

/// What has to be done before a draft can be kept: this program may have other rights than whoever
/// may write that file, and does not write where a daemon says.
std::string before_keeping(const ReloadOptions& options) {
    return options.draft ? fmt::format("copy {} into the daemon's own file, then ", *options.draft)
                         : "";
}

/// `number`: " 7", the number of the daemon's trial; empty if the daemon does not number trials.
int watch_trial(const std::string& socket, const ReloadOptions& options, Duration trial,
                const std::string& number) {
    if (::isatty(STDIN_FILENO) == 0) {
        print_error("tribus: goes back in {}; {}`tribus reload{}{} --confirm` keeps it\n",
                    options.trial, before_keeping(options), options.name.empty() ? "" : " ",
                    options.name);
        return kExitFine;
    }
    const Instant end = later(monotonic_now(), trial);
    auto wait = MainWait::for_signals({SIGINT, SIGTERM, SIGHUP});
    std::string question = before_keeping(options) + "Enter keeps it";
    question.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(question[0])));
    tell_person(
        fmt::format("{}; Ctrl-C, or no answer within {}, goes back:", question, options.trial));
    for (;;) {
        const Choice choice = wait ? ask_person(*wait, end) : Choice::back;
        if (choice == Choice::too_late) {
            break;
        }
        if (choice == Choice::back) {
            print_error("\n");
            return ask_and_tell(socket, "back" + number, "the configuration before is back");
        }
        const int kept =
            ask_and_tell(socket, "confirm" + number, "confirmed", nullptr, kConfirmPatience);
        // Whoever has not copied the draft yet may still do so.
        if (kept == kExitFine || !options.draft) {
            return kept;
        }
    }
    print_error("\ntribus: not confirmed; the configuration before is back\n");
    return kExitFailed;
}

int reload(const ReloadOptions& options) {
    const auto trial = parse_duration(options.trial);
    if (!options.trial.empty() && !trial) {
        return complain("--trial must be a duration such as \"30s\"", kExitWrongUse);
    }
    if (options.number && !options.confirm && !options.back) {
        return complain("--number goes with --confirm or --back", kExitWrongUse);
    }
    const auto socket = find_daemon(options.name, options.socket);
    if (!socket) {
        return complain(socket.error(), kExitFailed);
    }
    const std::string only = options.number ? fmt::format(" {}", *options.number) : "";
    if (options.confirm) {
        return ask_and_tell(*socket, "confirm" + only, "confirmed", nullptr, kConfirmPatience);
    }
    if (options.back) {
        return ask_and_tell(*socket, "back" + only, "the configuration before is back");
    }
    if (options.draft) {
        if (const auto handed = hand_draft_over(*socket, *options.draft); !handed) {
            return complain(handed.error(), kExitFailed);
        }
    }
    nlohmann::json told;
    const int status =
        ask_and_tell(*socket, (options.draft ? "reload draft " : "reload ") + options.trial,
                     trial ? "taken, on trial" : "taken", &told);
    const bool numbered = told.is_object() && told.contains("trial") && told["trial"].is_number();
    const std::string number = numbered ? " " + told["trial"].dump() : "";
    return status == kExitFine && trial ? watch_trial(*socket, options, *trial, number) : status;
}

}  // namespace

Command reload_command() {
    auto options = std::make_shared<ReloadOptions>();
    return {
        .name = "reload",
        .help = "Make a daemon read its configuration again, on trial if you like",
        .notes =
            "The daemon takes the file between two frames, or refuses it, says why, and goes on "
            "with the old one. In a terminal a trial asks: Enter keeps it, Ctrl-C goes back.",
        .options = {daemon_name_option(options->name),
                    daemon_socket_option(options->socket),
                    {.name = "--trial",
                     .value = &options->trial,
                     .help = "Go back after this time, such as \"30s\", to the configuration "
                             "before, unless confirmed",
                     .value_name = "DURATION"},
                    {.name = "--draft",
                     .value = &options->draft,
                     .help = "Try the text of this file; the daemon's own file stays as it is, and "
                             "must have the same text before the trial can be confirmed",
                     .value_name = "FILE",
                     .needs = {"--trial"}},
                    {.name = "--confirm",
                     .value = &options->confirm,
                     .help = "Keep the configuration on trial",
                     .excludes = {"--trial", "--back"}},
                    {.name = "--back",
                     .value = &options->back,
                     .help = "Go back from a trial at once",
                     .excludes = {"--trial"}},
                    {.name = "--number",
                     .value = &options->number,
                     .help = "With --confirm or --back: only if this trial is the present one",
                     .value_name = "NUMBER"}},
        .examples = {{"tribus reload servos", "the daemon reads servos.toml again"},
                     {"tribus reload --trial 30s", "goes back after 30 s unless Enter is pressed"},
                     {"tribus reload --confirm", "from another terminal"}},
        .exits = {{kExitFine, "taken, confirmed, or gone back as asked"},
                  {kExitFailed, "refused, not confirmed in time, no trial, or no daemon answers"}},
        .run = [options] { return reload(*options); },
    };
}

}  // namespace tribus
