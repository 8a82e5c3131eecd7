#include "app/web/server/site.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/object_text.h"
#include "app/inspect/graph_model.h"
#include "app/inspect/graph_picture.h"
#include "app/status/fingerprint.h"
#include "app/web/answers/answers.h"
#include "app/web/answers/checks.h"
#include "app/web/http/access.h"
#include "config/language/read_document.h"
#include "config/language/read_file.h"
#include "config/show/json_schema.h"
#include "core/quotes.h"

namespace tribus::web {
namespace {

constexpr std::string_view kApi = "/api/";

std::string host_name() {
    constexpr std::size_t kLongest = 256;
    std::array<char, kLongest> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : "";
}

bool is_content_of(const std::filesystem::path& file, const std::optional<std::string>& text) {
    const auto content = read_file(file, kMostConfigurationBytes, FileKinds::regular);
    return content && text && *content == *text;
}

/// The part of a path up to the next '/', which is removed, too.
std::string_view take_part(std::string_view& path) {
    const std::size_t end = path.find('/');
    const std::string_view part = path.substr(0, end);
    path.remove_prefix(end == std::string_view::npos ? path.size() : end + 1);
    return part;
}

}  // namespace

Site::Site(SiteSettings settings)
    : settings_(std::move(settings)),
      files_(PageFiles::read(settings_.page)),
      pairing_(settings_.state),
      names_(own_names(host_name(), settings_.hosts)) {}

/// A request that came together with the one before has no event of its own.
bool Site::answer(SocketClient& client, Instant now) {
    bool went_on = true;
    while (went_on && client.ready() && !client.done()) {
        const std::size_t before = client.received().size();
        const bool waited = client.waits();
        if (!answer_one(client, now)) {
            return false;
        }
        went_on = client.received().size() < before || (waited && !client.waits());
    }
    return true;
}

bool Site::answer_one(SocketClient& client, Instant now) {
    if (client.waits()) {
        if (auto late = client.take_answer()) {
            return client.send(*std::move(late), now);
        }
        return true;
    }
    if (client.repeats() || client.received().empty()) {
        return true;
    }
    auto parsed = parse_http(client.received());
    if (std::holds_alternative<MoreBytes>(parsed)) {
        return true;
    }
    if (const auto* refusal = std::get_if<HttpRefusal>(&parsed)) {
        client.close_when_sent();
        return client.send(http_text(refused(refusal->status, refusal->why, false)), now);
    }
    const HttpRequest request = std::get<HttpRequest>(std::move(parsed));
    client.take_received(request.bytes);
    if (!is_own_host(request.host, names_)) {
        client.close_when_sent();
        return client.send(
            http_text(refused(421,
                              "this machine has another name; allowed: its addresses, its "
                              "name with or without .local, and those given with --host",
                              false)),
            now);
    }
    std::string_view path = request.path;
    if (path.starts_with(kApi) && is_asked_by_another_page(request)) {
        return send_reply(
            client, request,
            refused(403, "the request comes from a page of another address", request.keeps_open),
            now);
    }
    if (request.method == "GET" && path.starts_with(kApi) && path.ends_with("/stream")) {
        path.remove_prefix(kApi.size());
        return begin_stream(client, request, std::string(take_part(path)), now);
    }
    return send_reply(client, request, reply(request, now), now);
}

bool Site::send_reply(SocketClient& client, const HttpRequest& request, Reply reply, Instant now) {
    const bool keeps_open = request.keeps_open;
    if (!keeps_open) {
        client.close_when_sent();
    }
    if (auto* late = std::get_if<Late>(&reply)) {
        // The client owns this function, so it lives as long.
        client.wait_for(
            [late = std::move(*late), keeps_open, &client]() -> std::optional<std::string> {
                auto answer = late();
                if (!answer) {
                    return std::nullopt;
                }
                answer->keeps_open = keeps_open;
                client.follow_with(std::move(answer->source));
                return http_text(*answer);
            });
        return true;
    }
    HttpAnswer& answer = std::get<HttpAnswer>(reply);
    answer.keeps_open = keeps_open;
    client.follow_with(std::move(answer.source));
    return client.send(http_text(answer), now);
}

Site::Reply Site::reply(const HttpRequest& request, Instant now) {
    if (request.path == "/pair" || request.path == "/leave") {
        if (const auto why = why_not_from_own_page(request)) {
            return refused(why->status, why->why);
        }
        return request.path == "/pair" ? pair(request) : leave(request);
    }
    if (request.path == "/metrics" && request.method == "GET") {
        return settings_.metrics
                   ? metrics_of_daemons(now)
                   : refused(404, "metrics are off; `tribus-web serve --metrics` has them");
    }
    std::string_view path = request.path;
    if (path.starts_with(kApi)) {
        path.remove_prefix(kApi.size());
        return reply_of_api(request, path, now);
    }
    return request.method == "GET" ? file_of_page(request) : refused(405, "only GET");
}

HttpAnswer Site::file_of_page(const HttpRequest& request) const {
    if (files_.empty()) {
        return {.status = 503,
                .type = "text/plain; charset=utf-8",
                .content = fmt::format("The page is not in {}: this tribus was built without it.\n",
                                       settings_.page.string())};
    }
    const PageFile* const file = files_.find(request.path);
    if (file == nullptr) {
        return refused(404, "there is no such page");
    }
    const bool gzip = request.takes_gzip && !file->gzip.empty();
    return {.type = file->type,
            .content = gzip ? file->gzip : file->content,
            .headers = "Vary: Accept-Encoding\r\n",
            .cached = request.path != "/",
            .gzip = gzip};
}

Site::Reply Site::reply_of_api(const HttpRequest& request, std::string_view path, Instant now) {
    if (request.method == "GET" && path == "me") {
        return me(request);
    }
    const auto visitor = visitor_of(request);
    if (!visitor) {
        return refused(401, "this browser is not paired; `sudo tribus pair` prints a code");
    }
    if (request.method == "GET" && path == "daemons") {
        return daemons(now);
    }
    constexpr std::string_view kLearn = "learn/";
    if (path == "doctor" || path.starts_with(kLearn)) {
        if (const auto why = why_not_from_own_page(request)) {
            return refused(why->status, why->why);
        }
        return path == "doctor" ? doctor(request, visitor->role, now)
                                : learn(request, path.substr(kLearn.size()), *visitor, now);
    }
    const auto daemon = find_known(settings_.configurations, take_part(path));
    if (!daemon) {
        return refused(404, "there is no daemon and no configuration of that name");
    }
    return reply_of_daemon(request, *daemon, path, visitor->role, now);
}

HttpAnswer Site::me(const HttpRequest& request) {
    const auto visitor = visitor_of(request);
    return json_answer(
        {{"role", visitor ? Json(std::string(word_of(visitor->role))) : Json(nullptr)},
         {"host", host_name()},
         {"public", settings_.is_public},
         {"version", settings_.version},
         {"screens", {"live", "timing", "config", "doctor", "learn", "recordings", "more"}}});
}

HttpAnswer Site::daemons(Instant now) const {
    Json list = Json::array();
    for (const KnownDaemon& daemon : known_daemons(settings_.configurations)) {
        const auto watch = watches_.find(daemon.name);
        const bool hangs = watch != watches_.end() && !watch->second->problem(now).empty();
        list.push_back({{"name", daemon.name},
                        {"state", daemon.tells.empty() ? "absent"
                                  : hangs              ? "hung"
                                                       : "running"},
                        {"file", daemon.file.string()}});
    }
    return json_answer({{"daemons", std::move(list)}});
}

Site::Reply Site::reply_of_daemon(const HttpRequest& request, const KnownDaemon& daemon,
                                  std::string_view what, Role role, Instant now) {
    constexpr std::string_view kRecordings = "recordings";
    if (request.method == "GET" && (what == kRecordings || what.starts_with("recordings/"))) {
        return look_at_recordings(request, daemon, what.substr(kRecordings.size()), now);
    }
    if (request.method == "GET") {
        return look_at_daemon(daemon, what, now);
    }
    if (const auto why = why_not_from_own_page(request)) {
        return refused(why->status, why->why);
    }
    // Judging a text changes nothing, but reads the files that it names: who may only look has the
    // configuration judged as it stands.
    if (role != Role::change && !is_content_of(daemon.file, text_in(request.body, "toml"))) {
        return refused(403, "this browser may only look; `sudo tribus pair` lets it change");
    }
    if (auto judged = judge_draft(request, daemon, what, now)) {
        return *std::move(judged);
    }
    return role == Role::change
               ? change_of_daemon(request, daemon, what, now)
               : refused(403, "this browser may only look; `sudo tribus pair` lets it change");
}

/// Answers questions about a draft that change nothing.
std::optional<Site::Reply> Site::judge_draft(const HttpRequest& request, const KnownDaemon& daemon,
                                             std::string_view what, Instant now) {
    const auto text = text_in(request.body, "toml");
    if (text && what == "check") {
        return json_answer(check_draft(*text, daemon.file));
    }
    if (text && what == "graph") {
        return picture_of_draft(*text, daemon.file);
    }
    if (text && what == "diff") {
        const auto watch = watches_.find(daemon.name);
        const std::string status =
            watch == watches_.end() ? std::string() : watch->second->fresh(now);
        return ask(daemon, "configuration", now,
                   [text, file = daemon.file, status](const auto& json) {
                       return difference_to(json, *text, file, status);
                   });
    }
    return std::nullopt;
}

Site::Reply Site::look_at_daemon(const KnownDaemon& daemon, std::string_view what, Instant now) {
    if (what == "status") {
        return ask(daemon, "status", now, as_it_is);
    }
    if (what == "histograms") {
        return ask(daemon, "histograms", now, as_it_is);
    }
    if (what == "configuration") {
        return configuration_answer(daemon.file);
    }
    if (what == "schema") {
        return HttpAnswer{.content = json_schema()};
    }
    if (what == "graph.svg") {
        return ask(daemon, "configuration", now,
                   [](const std::string& json) { return picture_of_running(json); });
    }
    if (what == "history" || what.starts_with("history/")) {
        return history_answer(settings_.state / "history" / daemon.name, what.substr(7));
    }
    if (what.starts_with("record/")) {
        return ask(daemon, fmt::format("record {}", what.substr(7)), now, as_it_is);
    }
    return refused(404, "there is nothing of that name");
}

Site::Reply Site::ask(const KnownDaemon& daemon, std::string_view line, Instant now,
                      FromLine as_answer, Duration patience) {
    if (daemon.tells.empty()) {
        return refused(502, fmt::format("no daemon runs {}", daemon.name));
    }
    return ask_at(daemon.tells, line, now, std::move(as_answer), patience);
}

/// Only for a browser that may change: `change_of_daemon` alone calls it.
Site::Reply Site::ask_to_change(const KnownDaemon& daemon, std::string_view line, Instant now,
                                FromLine as_answer, Duration patience) {
    if (daemon.control.empty()) {
        return refused(
            502, daemon.tells.empty()
                     ? fmt::format("no daemon runs {}", daemon.name)
                     : fmt::format("the page may not use the control socket of {}", daemon.name));
    }
    return ask_at(daemon.control, line, now, std::move(as_answer), patience);
}

Site::Reply Site::ask_at(const std::string& socket, std::string_view line, Instant now,
                         FromLine as_answer, Duration patience) {
    if (line.find_first_of("\r\n") != std::string_view::npos) {
        return refused(400, "a name must stand in one line");
    }
    return ask(LineRequest(daemon_at(socket), line, later(now, patience)), std::move(as_answer));
}

Site::Reply Site::ask(LineRequest request, FromLine as_answer) {
    auto pending =
        std::make_shared<Pending>(Pending{std::move(request), std::move(as_answer), std::nullopt});
    pending_.push_back(pending);
    return Late([pending] { return pending->answer; });
}

std::vector<int> Site::descriptors(std::size_t room) const {
    std::vector<int> descriptors;
    descriptors.reserve(pending_.size() + watches_.size() + (learning_ ? 1U : 0U) +
                        (plotting_ ? 1U : 0U) + room);
    for (const auto& pending : pending_) {
        descriptors.push_back(pending->request.descriptor());
    }
    for (const auto& [name, watch] : watches_) {
        descriptors.push_back(watch->descriptor());
    }
    if (learning_ && learning_->awaits_step) {
        descriptors.push_back(learning_->talk.descriptor());
    }
    if (plotting_) {
        descriptors.push_back(plotting_->descriptor());
    }
    return descriptors;
}

Instant Site::due() const {
    Instant due = learning_ ? learning_->end : kNever;
    due = plotting_ ? std::min(due, plotting_->due()) : due;
    for (const auto& pending : pending_) {
        due = std::min(due, pending->request.end());
    }
    for (const auto& [name, watch] : watches_) {
        due = std::min(due, watch->due());
    }
    return due;
}

void Site::look(Instant now) {
    for (auto pending = pending_.begin(); pending != pending_.end();) {
        const auto json = (*pending)->request.poll(now);
        if (json) {
            (*pending)->answer = (*pending)->as_answer(*json);
        }
        pending = json ? pending_.erase(pending) : std::next(pending);
    }
    look_at_learning(now);
    if (plotting_) {
        plotting_->look(now);
        if (plotting_->answer()) {
            plotting_.reset();
        }
    }
    std::erase_if(streams_, [](const std::weak_ptr<Stream>& stream) { return stream.expired(); });
    for (auto& [name, watch] : watches_) {
        watch->look(now);
    }
    std::erase_if(watches_, [this](const auto& entry) {
        return std::ranges::none_of(streams_, [&](const std::weak_ptr<Stream>& one) {
            const auto stream = one.lock();
            return stream && stream->daemon == entry.first;
        });
    });
}

}  // namespace tribus::web
