#include "app/cli/load_or_explain.h"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "app/journal/journal.h"
#include "app/journal/print_error.h"
#include "config/load.h"

namespace tribus {

CommandOption configuration_option(std::string& path) {
    return {.name = "CONFIG", .value = &path, .help = "Configuration file", .required = true};
}

void explain_mistakes(const std::vector<Mistake>& mistakes) {
    for (const Mistake& mistake : mistakes) {
        print_error("{}{}\n", stderr_is_journal() ? "<3>" : "",
                    without_control_characters(format_mistake(mistake)));
    }
}

std::optional<Configuration> load_or_explain(const std::string& path) {
    auto configuration = load_configuration_file(path);
    if (!configuration) {
        explain_mistakes(configuration.error());
        return std::nullopt;
    }
    return std::move(*configuration);
}

}  // namespace tribus
