#include "app/inspect/check.h"

#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/journal/journal.h"
#include "app/journal/print_error.h"
#include "config/check/warnings.h"
#include "config/load.h"
#include "config/show/effective.h"
#include "config/show/json_schema.h"
#include "config/show/manual.h"
#include "config/show/mistakes_json.h"

namespace tribus {

namespace {

int check(const std::string& path, bool json) {
    const auto configuration = load_configuration_file(path);
    if (!configuration) {
        explain_mistakes(configuration.error());
        if (json) {
            fmt::print("{}", mistakes_document(configuration.error()));
        }
        return kExitWrongUse;
    }
    for (Mistake& warning : warnings_about(*configuration)) {
        warning.text = "warning: " + warning.text;
        print_error("{}\n", without_control_characters(format_mistake(warning)));
    }
    fmt::print("{}", json ? effective_json(*configuration) : effective_toml(*configuration));
    return kExitFine;
}

}  // namespace

Command check_command() {
    struct Options {
        std::string path;
        std::string format = "toml";
    };
    auto options = std::make_shared<Options>();
    return {
        .name = "check",
        .help = "Print a configuration with every default, or all its mistakes",
        .options = {configuration_option(options->path),
                    {.name = "--format",
                     .value = &options->format,
                     .help = "Form of the configuration, and of its mistakes with json",
                     .shows_value = true,
                     .choices = {"toml", "json"}}},
        .examples = {{"tribus check servos.toml", ""},
                     {"tribus check --format json servos.toml | jq .input", ""}},
        .exits = {{kExitFailed, "the result cannot be written"},
                  {kExitWrongUse, "wrong use, mistakes, or a file that cannot be read"}},
        .run = [options] { return check(options->path, options->format == "json"); },
    };
}

Command schema_command() {
    auto format = std::make_shared<std::string>("json");
    return {
        .name = "schema",
        .help = "Print every key of configurations: a JSON schema, or the manual",
        .notes =
            "Editors that know the JSON schema complete keys and underline mistakes. Save it "
            "beside the configuration, and start that with the line "
            "`#:schema ./tribus.schema.json`.",
        .options = {{.name = "--format",
                     .value = format.get(),
                     .help = "json: JSON schema; markdown, man: every key with its meaning",
                     .shows_value = true,
                     .choices = {"json", "markdown", "man"}}},
        .examples = {{"tribus schema > tribus.schema.json", ""},
                     {"tribus schema --format man | man -l -", ""}},
        .run =
            [format] {
                fmt::print("{}", *format == "man"        ? manual_mdoc()
                                 : *format == "markdown" ? manual_markdown()
                                                         : json_schema());
                return kExitFine;
            },
    };
}

}  // namespace tribus
