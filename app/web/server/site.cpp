#include "app/web/server/site.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/web/answers/answers.h"
#include "app/web/http/access.h"

namespace tribus::web {
namespace {

constexpr std::string_view kApi = "/api/";

std::string host_name() {
    constexpr std::size_t kLongest = 256;
    std::array<char, kLongest> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : "";
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
        client.close_when_sent_and_discard();
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
    return answer_request(client, request, now);
}

bool Site::answer_request(SocketClient& client, const HttpRequest& request, Instant now) {
    const bool api = request.path.starts_with(kApi);
    if (api && is_asked_by_another_page(request)) {
        return send_reply(
            client, request,
            refused(403, "the request comes from a page of another address", request.keeps_open),
            now);
    }
    for (const SiteRoute& one : routes()) {
        if (one.route.method == request.method) {
            if (const auto names = names_in(one.route, request.path)) {
                return answer_route(client, request, one, *names, now);
            }
        }
    }
    return send_reply(client, request, api ? of_no_route(request) : file_of_page(request), now);
}

bool Site::answer_route(SocketClient& client, const HttpRequest& request, const SiteRoute& one,
                        const PathNames& names, Instant now) {
    const auto visitor = visitor_of(request);
    if (const auto why =
            why_not(one.route, request, visitor ? std::optional(visitor->role) : std::nullopt)) {
        return send_reply(client, request, refused(why->status, why->why), now);
    }
    const auto& [first, last] = names;
    const auto daemon = first.empty() ? KnownDaemon{} : find_known(settings_.configurations, first);
    if (!daemon) {
        return send_reply(client, request,
                          refused(404, "there is no daemon and no configuration of that name"),
                          now);
    }
    const Asked asked{request, visitor, *daemon, last, client.who(), now};
    return one.answer == nullptr ? begin_stream(client, asked)
                                 : send_reply(client, request, (this->*one.answer)(asked), now);
}

HttpAnswer Site::of_no_route(const HttpRequest& request) const {
    const auto other = std::ranges::find_if(routes(), [&](const SiteRoute& one) {
        return names_in(one.route, request.path).has_value();
    });
    const bool file = files_.find(request.path) != nullptr && request.method != "GET";
    if (other == routes().end() && !file) {
        return refused(404, "there is nothing of that name");
    }
    const std::string_view method = file ? "GET" : other->route.method;
    HttpAnswer answer = refused(405, fmt::format("only {} is for this path", method));
    answer.headers = fmt::format("Allow: {}\r\n", method);
    return answer;
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
    if (request.method == "HEAD") {
        answer.content.clear();  // RFC 9110, 9.3.2
    }
    client.follow_with(std::move(answer.source));
    return client.send(http_text(answer), now);
}

Site::Reply Site::me(const Asked& asked) {
    return json_answer(
        {{"role", asked.visitor ? Json(std::string(word_of(asked.visitor->role))) : Json(nullptr)},
         {"host", host_name()},
         {"public", settings_.is_public},
         {"version", settings_.version},
         {"screens", {"live", "timing", "config", "doctor", "learn", "recordings", "more"}}});
}

HttpAnswer Site::file_of_page(const HttpRequest& request) const {
    if (request.method != "GET") {
        return of_no_route(request);
    }
    if (files_.empty()) {
        return {.status = 503,
                .type = "text/plain; charset=utf-8",
                .content = fmt::format("The page is not in {}: this tribus was built without it.\n",
                                       settings_.page.string())};
    }
    const PageFile* const file = files_.find(request.path);
    if (file == nullptr) {
        return of_no_route(request);
    }
    const bool gzip = request.takes_gzip && !file->gzip.empty();
    return {.type = file->type,
            .content = gzip ? file->gzip : file->content,
            .headers = "Vary: Accept-Encoding\r\n",
            .cached = request.path != "/",
            .gzip = gzip};
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
