#include "app/journal/terminal_stream.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace tribus {
namespace {

std::string_view variable(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? std::string_view() : value;
}

}  // namespace

bool is_screen(int descriptor) {
    const std::string_view terminal = variable("TERM");
    return ::isatty(descriptor) == 1 && !terminal.empty() && terminal != "dumb";
}

bool shows_colour(int descriptor) {
    return is_screen(descriptor) && variable("NO_COLOR").empty();
}

}  // namespace tribus
