#include "config/language/document.h"

#include <fmt/format.h>

#include <algorithm>
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

bool is_plain(const Value& value) {
    return value.as<List>() == nullptr && value.as<Table>() == nullptr &&
           value.as<DateOrTime>() == nullptr;
}

/// A short list of plain values as it stands in the file.
std::string describe_list(const List& list) {
    constexpr std::size_t kMostShown = 4;
    if (list.items.empty() || list.items.size() > kMostShown ||
        !std::ranges::all_of(list.items, is_plain)) {
        return "a list";
    }
    std::string text;
    for (const Value& item : list.items) {
        text += (text.empty() ? "[" : ", ") + describe(item);
    }
    return text + "]";
}

}  // namespace

std::string describe(const Value& value) {
    return std::visit(Overloaded{
                          [](bool truth) -> std::string { return truth ? "true" : "false"; },
                          [](std::int64_t number) { return fmt::format("{}", number); },
                          [](double number) { return format_number(number); },
                          [](const std::string& text) { return in_quotes(text, kLongestQuote); },
                          [](const DateOrTime&) -> std::string { return "a date or time"; },
                          [](const List& list) { return describe_list(list); },
                          [](const Table&) -> std::string { return "a table"; },
                      },
                      value.content);
}

}  // namespace tribus
