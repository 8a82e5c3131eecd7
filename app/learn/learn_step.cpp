#include "app/learn/learn_step.h"

#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"

namespace tribus {

void tell_learn_step(std::string_view step, std::string_view text,
                     const std::vector<std::string>& lines) {
    fmt::print("{}\n", json_text({{"step", step}, {"text", text}, {"lines", lines}}));
    std::fflush(stdout);
}

}  // namespace tribus
