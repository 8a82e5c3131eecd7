#include "app/web/answers/metrics.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "app/status/metrics_text.h"

namespace tribus::web {
namespace {

struct MetricFamily {
    std::string_view head;  ///< its lines of help and type
    std::string samples;
};

/// The text up to the next family, which is removed from `rest`.
std::string_view take_family(std::string_view& rest) {
    const std::size_t end = rest.find("\n# HELP ");
    const std::string_view family = rest.substr(0, end == std::string_view::npos ? end : end + 1);
    rest.remove_prefix(family.size());
    return family;
}

/// Its first two lines.
std::string_view head_of(std::string_view family) {
    const std::size_t first = family.find('\n');
    const std::size_t second =
        first == std::string_view::npos ? first : family.find('\n', first + 1);
    return family.substr(0, second == std::string_view::npos ? second : second + 1);
}

void add_families(std::vector<MetricFamily>& families, std::string_view text) {
    while (!text.empty()) {
        const std::string_view family = take_family(text);
        const std::string_view head = head_of(family);
        auto known = std::ranges::find(families, head, &MetricFamily::head);
        if (known == families.end()) {
            known = families.insert(known, MetricFamily{.head = head, .samples = {}});
        }
        known->samples += family.substr(head.size());
    }
}

}  // namespace

std::string metrics_of_all(const std::vector<DaemonMetrics>& daemons) {
    std::string text =
        "# HELP tribus_daemon_answers 1 if the daemon answered; else nothing else here is of it.\n"
        "# TYPE tribus_daemon_answers gauge\n";
    std::vector<MetricFamily> families;
    for (const DaemonMetrics& daemon : daemons) {
        text += fmt::format("tribus_daemon_answers{{daemon=\"{}\"}} {}\n",
                            escaped_label(daemon.name), daemon.text ? 1 : 0);
        if (daemon.text) {
            add_families(families, *daemon.text);
        }
    }
    for (const MetricFamily& family : families) {
        text += family.head;
        text += family.samples;
    }
    return text;
}

}  // namespace tribus::web
