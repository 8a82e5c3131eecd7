#include "app/learn/learn_step.h"

#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/cli/streams.h"

namespace tribus {

void tell_learn_step(std::string_view step, std::string_view text,
                     const std::vector<std::string>& lines) {
    print_line_now(json_text({{"step", step}, {"text", text}, {"lines", lines}}));
}

}  // namespace tribus
