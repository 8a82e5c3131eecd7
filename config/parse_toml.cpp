#include "config/parse_toml.h"

#include <algorithm>
#include <tuple>
#include <utility>

// Debian's shared library is built with exceptions, so the header is compiled here, without.
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#define TOML_ENABLE_FORMATTERS 0
// toml++ 3.3 asserts that a key follows `[[`, and promises it to the optimiser where NDEBUG is set,
// but `[[=` and `[[[` get there too (fixed upstream in 2026, marzer/tomlplusplus pull request 301).
// Without either it goes on to report a mistake of syntax, as it should.
#undef NDEBUG
#define TOML_ASSERT(expression) static_cast<void>(0)
#include <toml++/toml.h>

namespace tribus {
namespace {

Location location(const toml::source_region& source) {
    return {source.begin.line, source.begin.column};
}

Table convert(const toml::table& table);

// toml++ itself refuses to nest deeper than 256 levels, so the recursion is bounded.
Value convert(const toml::node& node) {
    Value value{location(node.source()), DateOrTime{}};
    if (const auto* truth = node.as_boolean()) {
        value.content = truth->get();
    } else if (const auto* whole = node.as_integer()) {
        value.content = whole->get();
    } else if (const auto* number = node.as_floating_point()) {
        value.content = number->get();
    } else if (const auto* text = node.as_string()) {
        value.content = text->get();
    } else if (const auto* table = node.as_table()) {
        value.content = convert(*table);
    } else if (const auto* array = node.as_array()) {
        List list;
        for (const toml::node& item : *array) {
            list.items.push_back(convert(item));
        }
        value.content = std::move(list);
    }
    return value;
}

Table convert(const toml::table& table) {
    Table result;
    for (auto&& [key, node] : table) {
        result.entries.push_back({std::string(key.str()), location(key.source()), convert(node)});
    }
    std::stable_sort(
        result.entries.begin(), result.entries.end(), [](const Entry& a, const Entry& b) {
            return std::tie(a.where.line, a.where.column) < std::tie(b.where.line, b.where.column);
        });
    return result;
}

}  // namespace

tl::expected<Table, SyntaxError> parse_toml(std::string_view text) {
    const toml::parse_result result = toml::parse(text);
    if (!result) {
        return tl::unexpected(SyntaxError{location(result.error().source()),
                                          std::string(result.error().description())});
    }
    return convert(result.table());
}

}  // namespace tribus
