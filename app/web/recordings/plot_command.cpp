#include "app/web/recordings/plot_command.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/cli/process_limit.h"
#include "app/journal/print_error.h"
#include "app/web/recordings/plot_recording.h"

namespace tribus::web {
namespace {

struct PlotOptions {
    std::string folder;
    std::uint64_t from_us = 0;
    std::uint64_t to_us = 0;
    int width = 0;
};

/// A damaged recording must not take the board's memory, processor or disk. The instrumented build
/// of the tests needs more memory for itself.
bool set_limits() {
    constexpr rlim_t kMib = rlim_t{1} << 20U;
    [[maybe_unused]] constexpr rlim_t kMostMemory = 32 * kMib;
    constexpr rlim_t kMostWritten = 16 * kMib;
    constexpr rlim_t kMostSeconds = 60;
#ifndef TRIBUS_SANITIZED
    if (!limit_process(RLIMIT_DATA, kMostMemory)) {
        return false;
    }
#endif
    return limit_process(RLIMIT_FSIZE, kMostWritten) && limit_process(RLIMIT_CPU, kMostSeconds) &&
           limit_process(RLIMIT_CORE, 0);
}

Duration plot_time(std::uint64_t us) {
    constexpr auto kMost = std::chrono::duration_cast<std::chrono::microseconds>(kLongestPlot);
    return us < static_cast<std::uint64_t>(kMost.count())
               ? std::chrono::microseconds(static_cast<std::int64_t>(us))
               : kMost;
}

int fail_plot(const std::string& why) {
    print_error("{}\n", why);
    return kExitFailed;
}

/// Works in the folder, so that messages name its files only.
int plot(const PlotOptions& options) {
    if (!set_limits()) {
        return fail_plot(std::string("no limits can be set: ") + std::strerror(errno));
    }
    std::error_code error;
    if (std::filesystem::symlink_status(options.folder, error).type() !=
        std::filesystem::file_type::directory) {
        return fail_plot("the recording is not there");
    }
    if (::chdir(options.folder.c_str()) != 0) {
        return fail_plot(std::string("the recording cannot be read: ") + std::strerror(errno));
    }
    const auto made = plot_recording("", {.from = plot_time(options.from_us),
                                          .to = plot_time(options.to_us),
                                          .columns = static_cast<std::size_t>(options.width)});
    if (!made) {
        return fail_plot(made.error());
    }
    write_plot(*made, std::cout);
    return kExitFine;
}

}  // namespace

Command plot_command() {
    auto options = std::make_shared<PlotOptions>();
    return {.name = "plot",
            .help = "Print a recording of the flight recorder as JSON for a picture",
            .notes = "The page asks for it; docs/web.md describes what is printed.",
            .options = {{.name = "FOLDER",
                         .value = &options->folder,
                         .help = "Folder of the recording",
                         .required = true},
                        {.name = "--from",
                         .value = &options->from_us,
                         .help = "Start of the picture, from the start of the recording",
                         .shows_value = true,
                         .value_name = "MICROSECONDS"},
                        {.name = "--to",
                         .value = &options->to_us,
                         .help = "End of the picture; if the recording ends before, its end",
                         .required = true,
                         .value_name = "MICROSECONDS"},
                        {.name = "--width",
                         .value = &options->width,
                         .help = "Columns of the picture",
                         .required = true,
                         .range = {{1, kMostPlotColumns}},
                         .value_name = "NUMBER"}},
            .examples = {{"tribus-web plot --to 5000000 --width 800 recording",
                          "the first five seconds of the recording in that folder"}},
            .run = [options] { return plot(*options); }};
}

}  // namespace tribus::web
