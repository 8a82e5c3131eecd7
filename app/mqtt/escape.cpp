#include "app/mqtt/escape.h"

#include <fmt/format.h>

namespace tribus::mqtt {

std::string escaped(std::string_view name, char mark, std::string_view kept) {
    std::string text;
    for (const char c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                           (c >= '0' && c <= '9') || kept.find(c) != std::string_view::npos;
        text += plain ? std::string(1, c)
                      : fmt::format("{}{:02X}", mark, static_cast<unsigned char>(c));
    }
    return text;
}

}  // namespace tribus::mqtt
