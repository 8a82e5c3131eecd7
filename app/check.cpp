#include "app/check.h"

#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "app/exit_status.h"
#include "app/load_or_explain.h"
#include "config/absent_channels.h"
#include "config/effective.h"
#include "config/json_schema.h"

namespace tribus {

void add_check_command(CLI::App& app, int& status) {
    auto* command = app.add_subcommand(
        "check", "Validate a configuration; print it with every default, or all its mistakes");
    struct Options {
        std::string path;
        std::string format = "toml";
    };
    auto options = std::make_shared<Options>();
    command->add_option("CONFIG", options->path, "Configuration file")->required();
    command->add_option("--format", options->format, "Form of the effective configuration")
        ->check(CLI::IsMember({"toml", "json"}))
        ->capture_default_str();
    command->callback([options, &status] {
        const auto configuration = load_or_explain(options->path);
        if (!configuration) {
            status = kExitWrongUse;
            return;
        }
        for (const Mistake& remark : maps_of_absent_channels(*configuration)) {
            fmt::print(stderr, "{}:{}:{}: warning: {}\n", remark.file, remark.where.line,
                       remark.where.column, remark.text);
        }
        fmt::print("{}", options->format == "json" ? effective_json(*configuration)
                                                   : effective_toml(*configuration));
    });
}

void add_schema_command(CLI::App& app) {
    auto* command =
        app.add_subcommand("schema", "Print the JSON schema of configurations, for editors");
    command->footer(
        "Editors that know it complete keys and underline mistakes. Save it beside the\n"
        "configuration and start that with the line\n"
        "  #:schema ./tribus.schema.json");
    command->callback([] { fmt::print("{}", json_schema()); });
}

}  // namespace tribus
