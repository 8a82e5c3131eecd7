#include "config/language/document.h"

#include <fmt/format.h>

#include <cstddef>

#include "config/schema/notation.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// Long enough to recognise a text, short enough for a message.
constexpr std::size_t kLongestQuote = 80;

template <class... Ts>
struct Overloaded : Ts... {
    using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

}  // namespace

std::string describe(const Value& value) {
    return std::visit(Overloaded{
                          [](bool truth) -> std::string { return truth ? "true" : "false"; },
                          [](std::int64_t number) { return fmt::format("{}", number); },
                          [](double number) { return format_number(number); },
                          [](const std::string& text) { return in_quotes(text, kLongestQuote); },
                          [](const DateOrTime&) -> std::string { return "a date or time"; },
                          [](const List&) -> std::string { return "a list"; },
                          [](const Table&) -> std::string { return "a table"; },
                      },
                      value.content);
}

}  // namespace tribus
