#pragma once

#include <string>
#include <string_view>

namespace tribus::mqtt {

/// The name with all but letters, digits and those of `kept` as `mark` and two hexadecimal digits a
/// byte, so that different names stay different. `kept` must not have `mark`. Pure.
std::string escaped(std::string_view name, char mark, std::string_view kept);

}  // namespace tribus::mqtt
