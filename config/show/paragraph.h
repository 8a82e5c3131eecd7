#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tribus {

/// Breaks a text at its blanks into lines of at most `columns` bytes, each with a line end. The
/// first line begins with `first`, all others with `rest`. A word that does not fit gets a line of
/// its own. Pure.
std::string paragraph(std::string_view first, std::string_view rest, std::string_view text,
                      std::size_t columns);

}  // namespace tribus
