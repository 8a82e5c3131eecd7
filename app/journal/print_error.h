#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace tribus {

/// Prints to standard error. Unlike `fmt::print` it does not throw if that cannot be written: what
/// the program does goes on, and its exit status still tells the outcome.
template <class... Arguments>
void print_error(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    const std::string text = fmt::format(format, std::forward<Arguments>(arguments)...);
    static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr));
}

}  // namespace tribus
