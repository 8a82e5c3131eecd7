#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>
#include <tl/expected.hpp>

/// The summary of a status that `tribus status` prints: few fields with fixed meanings
/// (docs/commands.md, "status"). Pure.
namespace tribus::status_summary {

/// The version of a summary rises if one of its fields changes its meaning.
inline constexpr int kVersion = 1;

/// The summary of a status as `docs/status.md` describes it. Figures older than a second say
/// nothing about now: then states and causes are "unknown", and no input is good. The error says
/// that `status` is none.
tl::expected<nlohmann::ordered_json, std::string> of_status(const nlohmann::json& status);

/// The summary in words, one line for the daemon and one for each trial, input, output and device.
/// Control characters of names become question marks.
std::vector<std::string> lines(const nlohmann::ordered_json& summary);

/// A change as the daemon tells it (docs/status.md, "Changes"), with the same fields.
nlohmann::ordered_json of_change(const nlohmann::json& change);

/// A change of the daemon itself that its client found.
struct DaemonChange {
    std::string field;  ///< "answers" or "figures_old"
    bool now = false;   ///< and it was the opposite
    std::string text;
    std::string why{};
    std::int64_t t_us = 0;  ///< times as in a status
    std::int64_t unix_time_us = 0;
};
nlohmann::ordered_json change_of_daemon(const nlohmann::ordered_json& summary,
                                        const DaemonChange& change);

/// The change in words, with its time in UTC in front.
std::string line(const nlohmann::ordered_json& change);

}  // namespace tribus::status_summary
