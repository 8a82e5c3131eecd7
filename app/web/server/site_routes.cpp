#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/web/answers/answers.h"
#include "app/web/answers/checks.h"
#include "app/web/server/site.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "config/show/json_schema.h"

/// The routes of the page (docs/web.md), and the answers that change nothing.
namespace tribus::web {
namespace {

bool is_content_of(const std::filesystem::path& file, const std::string& text) {
    const auto content = read_file(file, kMostConfigurationBytes, FileKinds::regular);
    return content && *content == text;
}

bool is_number(const std::string& text) {
    return text.find_first_not_of("0123456789") == std::string::npos;
}

}  // namespace

std::span<const Site::SiteRoute> Site::routes() {
    using enum Access;
    static constexpr std::array kRoutes{
        SiteRoute{{"POST", "/pair", anybody}, &Site::pair},
        SiteRoute{{"POST", "/leave", anybody}, &Site::leave},
        SiteRoute{{"GET", "/metrics", anybody}, &Site::metrics},
        SiteRoute{{"GET", "/api/me", anybody}, &Site::me},
        SiteRoute{{"GET", "/api/daemons", looks}, &Site::daemons},
        SiteRoute{{"POST", "/api/doctor", looks}, &Site::doctor},
        SiteRoute{{"POST", "/api/learn/start", changes}, &Site::begin_learning},
        SiteRoute{{"POST", "/api/learn/next", changes}, &Site::go_on_learning},
        SiteRoute{{"POST", "/api/learn/stop", changes}, &Site::stop_learning},
        SiteRoute{{"GET", "/api/*/stream", looks}, nullptr},
        SiteRoute{{"GET", "/api/*/status", looks}, &Site::status},
        SiteRoute{{"GET", "/api/*/changes/*", looks}, &Site::changes},
        SiteRoute{{"GET", "/api/*/histograms", looks}, &Site::histograms},
        SiteRoute{{"GET", "/api/*/configuration", looks}, &Site::configuration},
        SiteRoute{{"GET", "/api/*/schema", looks}, &Site::schema},
        SiteRoute{{"GET", "/api/*/graph.svg", looks}, &Site::running_picture},
        SiteRoute{{"GET", "/api/*/history", looks}, &Site::history},
        SiteRoute{{"GET", "/api/*/history/*", looks}, &Site::kept_file},
        SiteRoute{{"GET", "/api/*/record/*", looks}, &Site::recording_state},
        SiteRoute{{"GET", "/api/*/recordings", looks}, &Site::recordings},
        SiteRoute{{"GET", "/api/*/recordings/*", looks}, &Site::recording_tar},
        SiteRoute{{"GET", "/api/*/recordings/*/plot", looks}, &Site::recording_plot},
        SiteRoute{{"POST", "/api/*/check", looks}, &Site::check},
        SiteRoute{{"POST", "/api/*/graph", looks}, &Site::draft_picture},
        SiteRoute{{"POST", "/api/*/diff", looks}, &Site::difference},
        SiteRoute{{"POST", "/api/*/draft", changes}, &Site::begin_draft},
        SiteRoute{{"POST", "/api/*/confirm", changes}, &Site::keep_draft},
        SiteRoute{{"POST", "/api/*/back", changes}, &Site::take_draft_back},
        SiteRoute{{"POST", "/api/*/save", changes}, &Site::save},
        SiteRoute{{"POST", "/api/*/record", changes}, &Site::record},
    };
    static_assert(std::ranges::all_of(kRoutes, [](const SiteRoute& one) {
        return std::ranges::count(one.route.path, '*') <=
               static_cast<std::ptrdiff_t>(std::tuple_size_v<PathNames>);
    }));
    return kRoutes;
}

std::vector<Route> Site::known_routes() {
    std::vector<Route> known;
    std::ranges::transform(routes(), std::back_inserter(known), &SiteRoute::route);
    return known;
}

Site::Reply Site::daemons(const Asked& asked) {
    Json list = Json::array();
    for (const KnownDaemon& daemon : known_daemons(settings_.configurations)) {
        const auto watch = watches_.find(daemon.name);
        const bool hangs = watch != watches_.end() && !watch->second->problem(asked.now).empty();
        list.push_back({{"name", daemon.name},
                        {"state", daemon.tells.empty() ? "absent"
                                  : hangs              ? "hung"
                                                       : "running"},
                        {"file", daemon.file.string()}});
    }
    return json_answer({{"daemons", std::move(list)}});
}

Site::Reply Site::status(const Asked& asked) {
    return ask(asked.daemon, "status", asked.now, as_it_is);
}

Site::Reply Site::histograms(const Asked& asked) {
    return ask(asked.daemon, "histograms", asked.now, as_it_is);
}

Site::Reply Site::configuration(const Asked& asked) {
    return configuration_answer(asked.daemon.file);
}

Site::Reply Site::schema(const Asked& /*asked*/) {
    return HttpAnswer{.content = json_schema()};
}

Site::Reply Site::running_picture(const Asked& asked) {
    return ask(asked.daemon, "configuration", asked.now, picture_of_running);
}

Site::Reply Site::history(const Asked& asked) {
    return history_answer(settings_.state / "history" / asked.daemon.name);
}

Site::Reply Site::kept_file(const Asked& asked) {
    return kept_file_answer(settings_.state / "history" / asked.daemon.name, asked.name);
}

Site::Reply Site::changes(const Asked& asked) {
    if (!is_number(asked.name)) {
        return refused(404, "changes have numbers");
    }
    return ask(asked.daemon, fmt::format("changes {}", asked.name), asked.now, as_it_is);
}

Site::Reply Site::recording_state(const Asked& asked) {
    if (!is_number(asked.name)) {
        return refused(404, "a recording that was asked for has a number");
    }
    return ask(asked.daemon, fmt::format("record {}", asked.name), asked.now, as_it_is);
}

/// Judging a text changes nothing, but reads the files that it names: who may only look has the
/// configuration judged as it stands.
tl::expected<std::string, HttpAnswer> Site::draft_in(const Asked& asked) {
    auto text = text_in(asked.request.body, "toml");
    if (!text) {
        return tl::unexpected(refused(400, "the text is missing"));
    }
    if (asked.visitor->role != Role::change && !is_content_of(asked.daemon.file, *text)) {
        return tl::unexpected(refused(403, kMayOnlyLook));
    }
    return *std::move(text);
}

Site::Reply Site::check(const Asked& asked) {
    const auto draft = draft_in(asked);
    return draft ? json_answer(check_draft(*draft, asked.daemon.file)) : draft.error();
}

Site::Reply Site::draft_picture(const Asked& asked) {
    const auto draft = draft_in(asked);
    return draft ? picture_of_draft(*draft, asked.daemon.file) : draft.error();
}

Site::Reply Site::difference(const Asked& asked) {
    const auto draft = draft_in(asked);
    if (!draft) {
        return draft.error();
    }
    const auto watch = watches_.find(asked.daemon.name);
    const std::string status =
        watch == watches_.end() ? std::string() : watch->second->fresh(asked.now);
    return ask(asked.daemon, "configuration", asked.now,
               [draft = *draft, file = asked.daemon.file, status](const auto& json) {
                   return difference_to(json, draft, file, status);
               });
}

}  // namespace tribus::web
