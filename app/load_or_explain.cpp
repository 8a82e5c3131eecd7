#include "app/load_or_explain.h"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "app/journal.h"
#include "config/load.h"
#include "config/mistakes.h"

namespace tribus {

std::optional<Configuration> load_or_explain(const std::string& path) {
    auto configuration = load_configuration_file(path);
    if (!configuration) {
        for (const Mistake& mistake : configuration.error()) {
            fmt::print(stderr, "{}{}\n", stderr_is_journal() ? "<3>" : "", format_mistake(mistake));
        }
        return std::nullopt;
    }
    return std::move(*configuration);
}

}  // namespace tribus
