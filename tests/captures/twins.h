#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Twins of the recordings: what the receivers of the table send, as files of the same formats.
namespace tribus::test {

/// What a poor port makes of a wire. Bytes are counted from the start of the twin; 0 is never.
struct Wear {
    std::size_t split_each =
        0;  ///< a burst ends behind each such byte, and goes on in the next one
    std::size_t damage_each = 0;  ///< each such byte has a parity error
};

/// Returns the content of the twin of a recording's file, whose name and ending are in the table.
/// The same for each call. Empty for other files.
std::string twin_file(std::string_view file, const Wear& wear = {});

}  // namespace tribus::test
