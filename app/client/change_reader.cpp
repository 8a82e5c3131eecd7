#include "app/client/change_reader.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/client/status_fields.h"

namespace tribus {

using namespace status_fields;

std::chrono::microseconds ChangeReader::start_of(const nlohmann::json& status) {
    return std::chrono::microseconds(whole(status, "t_us").value_or(0) -
                                     whole(status, "uptime_us").value_or(0));
}

/// A status gives both times in whole microseconds.
bool ChangeReader::same_start(std::chrono::microseconds a, std::chrono::microseconds b) {
    return std::chrono::abs(a - b) < std::chrono::milliseconds(1);
}

std::optional<std::string> ChangeReader::ask(std::uint64_t newest) {
    if (asked_ || newest == *read_) {
        return std::nullopt;
    }
    asked_ = true;
    return fmt::format("changes {}", *read_);
}

std::optional<std::string> ChangeReader::take_status(const nlohmann::json& status) {
    // A daemon of an earlier version numbers no changes.
    if (!number(status, "changes")) {
        return std::nullopt;
    }
    const std::uint64_t newest = count(status, "changes");
    const std::chrono::microseconds start = start_of(status);
    if (read_ && !same_start(start, start_)) {
        // Another process begins anew.
        read_ = 0;
        asked_ = false;
    }
    start_ = start;
    read_ = std::min(read_.value_or(newest), newest);
    return ask(newest);
}

ChangeReader::News ChangeReader::take_answer(const nlohmann::json& answer) {
    News news;
    if (!read_ || !asked_) {
        return news;
    }
    asked_ = false;
    news.lost = count(answer, "lost");
    *read_ += news.lost;
    for (const nlohmann::json& change : list(answer, "changes")) {
        const std::uint64_t its = count(change, "number");
        if (its == *read_ + 1) {
            read_ = its;
            news.changes.push_back(change);
        }
    }
    news.request = news.changes.empty() ? std::nullopt : ask(count(answer, "newest"));
    return news;
}

}  // namespace tribus
