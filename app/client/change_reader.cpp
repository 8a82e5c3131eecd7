#include "app/client/change_reader.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/client/status_fields.h"

namespace tribus {

using namespace status_fields;

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
    const double uptime_us = number(status, "uptime_us").value_or(0);
    if (uptime_us < uptime_us_) {
        // Another process begins anew.
        read_ = 0;
        asked_ = false;
    }
    uptime_us_ = uptime_us;
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
