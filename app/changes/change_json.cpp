#include "app/changes/change_json.h"

#include <charconv>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/status/field_values.h"

namespace tribus {
namespace {

using field_values::text_or_null;
using field_values::us;
using OrderedJson = nlohmann::ordered_json;

/// Limit of one answer, because the memory of a client is bounded. A client asks again for more.
constexpr std::size_t kMostChanges = 100;

OrderedJson json_of(const ToldChange& change) {
    OrderedJson json{{"type", "change"},
                     {"number", change.number},
                     {"t_us", us(change.at.time_since_epoch())},
                     {"unix_time_us", us(change.wall_time)},
                     {"part", change.part},
                     {"name", change.name},
                     {"field", change.field},
                     {"was", text_or_null(change.was)},
                     {"now", text_or_null(change.now)},
                     {"text", line_of(change)}};
    if (change.part == "output") {
        json["input"] = text_or_null(change.input);
    }
    return json;
}

std::optional<std::uint64_t> number_in(std::span<const std::string> words) {
    if (words.empty()) {
        return 0;
    }
    std::uint64_t number = 0;
    const char* const end = words.front().data() + words.front().size();
    const auto [rest, error] = std::from_chars(words.front().data(), end, number);
    return words.size() == 1 && rest == end && error == std::errc{} ? std::optional(number)
                                                                    : std::nullopt;
}

}  // namespace

std::string changes_json(const ChangeJournal& changes, std::span<const std::string> words) {
    const auto number = number_in(words);
    if (!number || *number > changes.newest()) {
        return error_object(
            "\"changes\" takes the number of the newest change that you have, at "
            "most " +
            std::to_string(changes.newest()) + ", or nothing");
    }
    OrderedJson list = OrderedJson::array();
    for (const ToldChange& change : changes.since(*number, kMostChanges)) {
        list.push_back(json_of(change));
    }
    const std::uint64_t oldest = changes.oldest();
    return json_text({{"type", "changes"},
                      {"newest", changes.newest()},
                      {"lost", *number + 1 < oldest ? oldest - *number - 1 : 0},
                      {"changes", std::move(list)}});
}

}  // namespace tribus
