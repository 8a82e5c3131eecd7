#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/bench/bench.h"
#include "app/check.h"
#include "app/dbc_command.h"
#include "app/decode.h"
#include "app/demo.h"
#include "app/diff.h"
#include "app/doctor/doctor.h"
#include "app/encode.h"
#include "app/exit_status.h"
#include "app/graph.h"
#include "app/help_formatter.h"
#include "app/learn.h"
#include "app/monitor.h"
#include "app/record.h"
#include "app/reload.h"
#include "app/replay.h"
#include "app/run.h"
#include "app/simulate.h"
#include "config/mistakes.h"
#include "core/quotes.h"

namespace {

/// CLI11 would only say that a subcommand is required.
bool explain_unknown_command(CLI::App& app, std::string_view word) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) {
        names.push_back(command->get_name());
    }
    const std::vector<std::string_view> allowed(names.begin(), names.end());
    if (word.starts_with('-') || std::find(allowed.begin(), allowed.end(), word) != allowed.end()) {
        return false;
    }
    fmt::print(stderr, "tribus: {} is no command; {}\n", tribus::in_quotes(word),
               tribus::suggestion(word, allowed));
    return true;
}

int run_command_line(int argc, char** argv) {
    CLI::App app{"tribus translates RC signals between i.Bus, SBUS and CAN", "tribus"};
    app.formatter(std::make_shared<tribus::HelpFormatter>());
    app.require_subcommand(1);
    app.set_version_flag("--version", TRIBUS_VERSION);
    int status = tribus::kExitFine;
    tribus::add_run_command(app, status);
    tribus::add_monitor_command(app, status);
    tribus::add_reload_command(app, status);
    tribus::add_check_command(app, status);
    tribus::add_diff_command(app, status);
    tribus::add_graph_command(app, status);
    tribus::add_demo_command(app, status);
    tribus::add_decode_command(app, status);
    tribus::add_encode_command(app, status);
    tribus::add_simulate_command(app, status);
    tribus::add_record_command(app, status);
    tribus::add_replay_command(app, status);
    tribus::add_learn_command(app, status);
    tribus::add_doctor_command(app, status);
    tribus::add_dbc_command(app, status);
    tribus::add_bench_command(app, status);
    tribus::add_schema_command(app);
    if (argc <= 1) {
        fmt::print(stderr, "{}", app.help());
        return tribus::kExitWrongUse;
    }
    if (explain_unknown_command(app, argv[1])) {
        return tribus::kExitWrongUse;
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? tribus::kExitFine : tribus::kExitWrongUse;
    }
    return status;
}

}  // namespace

int main(int argc, char** argv) {
    std::ios::sync_with_stdio(false);
    // Libraries throw when memory or a standard stream fails; nothing of ours does.
    try {
        return run_command_line(argc, argv);
    } catch (const std::exception& error) {
        std::fputs(error.what(), stderr);
        std::fputs("\n", stderr);
        return tribus::kExitFailed;
    }
}
