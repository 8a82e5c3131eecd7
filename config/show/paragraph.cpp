#include "config/show/paragraph.h"

#include <algorithm>

namespace tribus {

std::string paragraph(std::string_view first, std::string_view rest, std::string_view text,
                      std::size_t columns) {
    std::string broken(first);
    std::size_t width = first.size();
    bool begun = false;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find(' ', at), text.size());
        const std::string_view word = text.substr(at, end - at);
        if (begun && width + 1 + word.size() > columns) {
            broken += '\n';
            broken += rest;
            width = rest.size();
            begun = false;
        }
        broken += begun ? " " : "";
        width += begun ? 1 : 0;
        broken += word;
        width += word.size();
        begun = true;
        at = end + 1;
    }
    broken += '\n';
    return broken;
}

}  // namespace tribus
