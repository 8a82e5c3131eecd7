#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/client/parse_json.h"
#include "app/client/status_fields.h"
#include "app/web/answers/answers.h"
#include "app/web/answers/metrics.h"
#include "app/web/server/site.h"

/// Metrics of all daemons, for Prometheus.
namespace tribus::web {
namespace {

constexpr std::string_view kMetricsType = "text/plain; version=0.0.4; charset=utf-8";

HttpAnswer metrics_said(const std::string& json) {
    const auto parsed = parse_json(json);
    const std::string text = status_fields::raw_text(parsed, "text");
    return text.empty() ? refused(502, "no metrics") : HttpAnswer{.content = text};
}

}  // namespace

/// Scrapers wait 10 s: daemons that hang do not keep the others from being seen.
Site::Reply Site::metrics(const Asked& asked) {
    if (!settings_.metrics) {
        return refused(404, "metrics are off; `tribus-web serve --metrics` has them");
    }
    struct OfDaemon {
        std::string name;
        Reply reply;
    };
    constexpr Duration kPatience = std::chrono::seconds(2);
    auto all_asked = std::make_shared<std::vector<OfDaemon>>();
    for (const KnownDaemon& daemon : known_daemons(settings_.configurations)) {
        all_asked->push_back(
            {daemon.name, ask(daemon, "metrics", asked.now, metrics_said, kPatience)});
    }
    return Late([all_asked]() -> std::optional<HttpAnswer> {
        std::vector<DaemonMetrics> all;
        for (const auto& [name, reply] : *all_asked) {
            const Late* const late = std::get_if<Late>(&reply);
            const auto answer = late != nullptr ? (*late)() : std::get<HttpAnswer>(reply);
            if (!answer) {
                return std::nullopt;
            }
            all.push_back(
                {name, answer->status == 200 ? std::optional(answer->content) : std::nullopt});
        }
        return HttpAnswer{.type = kMetricsType, .content = metrics_of_all(all)};
    });
}

}  // namespace tribus::web
