#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "config/language/mistakes.h"

namespace tribus {

/// The bytes of a file as text that a TOML parser can read: UTF-8, and lines that end with LF or CR
/// LF. Another encoding and other line ends are one mistake each, however often they occur, and the
/// text is converted, so that its other mistakes are found too. `nullopt` if that is hopeless, as
/// for UTF-16. Accepts any bytes. Returns a part of `bytes`, or `converted`, which is written only
/// then: usually nothing is copied.
std::optional<std::string_view> decoded_text(std::string_view bytes, std::string& converted,
                                             Mistakes& mistakes);

}  // namespace tribus
