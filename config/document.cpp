#include "config/document.h"

#include <fmt/format.h>

#include <cstddef>

#include "config/mistakes.h"
#include "config/values.h"

namespace tribus {
namespace {

/// Enough to know a text again; messages stay readable.
constexpr std::size_t kLongestQuote = 80;

template <class... Ts>
struct Overloaded : Ts... {
    using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

std::string quote_text(const std::string& text) {
    if (text.size() <= kLongestQuote) {
        return in_quotes(text);
    }
    std::size_t end = kLongestQuote;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) {
        --end;  // not in the middle of a UTF-8 character
    }
    return in_quotes(text.substr(0, end)) + "...";
}

}  // namespace

std::string describe(const Value& value) {
    return std::visit(Overloaded{
                          [](bool truth) -> std::string { return truth ? "true" : "false"; },
                          [](std::int64_t number) { return fmt::format("{}", number); },
                          [](double number) { return format_number(number); },
                          [](const std::string& text) { return quote_text(text); },
                          [](const DateOrTime&) -> std::string { return "a date or time"; },
                          [](const List&) -> std::string { return "a list"; },
                          [](const Table&) -> std::string { return "a table"; },
                      },
                      value.content);
}

}  // namespace tribus
