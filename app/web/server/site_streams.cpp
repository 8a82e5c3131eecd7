#include <algorithm>
#include <charconv>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "app/web/answers/answers.h"
#include "app/web/http/cookie.h"
#include "app/web/server/site.h"

/// Pages that get each status, and who they belong to.
namespace tribus::web {
namespace {

constexpr Duration kLeastPeriod = std::chrono::milliseconds(50);
constexpr Duration kUsualPeriod = std::chrono::milliseconds(100);
constexpr Duration kMostPeriod = std::chrono::seconds(1);
/// A page can tell a daemon that is gone from a server that hangs.
constexpr Duration kSaidAgain = std::chrono::seconds(1);
/// How soon a revoked browser gets nothing more.
constexpr Duration kVisitorPeriod = std::chrono::seconds(1);

/// `rate=10`: ten a second.
Duration period_in(std::string_view query) {
    constexpr std::string_view kRate = "rate=";
    int rate = 0;
    if (!query.starts_with(kRate) ||
        std::from_chars(query.data() + kRate.size(), query.data() + query.size(), rate).ec !=
            std::errc() ||
        rate < 1) {
        return kUsualPeriod;
    }
    return std::clamp(Duration(std::chrono::seconds(1)) / rate, kLeastPeriod, kMostPeriod);
}

/// JSON of a daemon is one line, so it is one line of data. Joined in one allocation, as each page
/// gets 2 KB ten times a second.
std::string event(std::string_view name, std::string_view data) {
    constexpr std::string_view kName = "event: ";
    constexpr std::string_view kData = "\ndata: ";
    constexpr std::string_view kEnd = "\n\n";
    std::string text;
    text.reserve(kName.size() + name.size() + kData.size() + data.size() + kEnd.size());
    text.append(kName).append(name).append(kData).append(data).append(kEnd);
    return text;
}

std::string reason(std::string_view why) {
    return json_answer({{"reason", std::string(why)}}).content;
}

}  // namespace

/// The port is in the name, so that two boards behind one name do not take each other's cookie.
std::string Site::cookie_name(std::string_view host) const {
    const std::size_t colon = host.rfind(':');
    const bool has_port = colon != std::string_view::npos && !host.ends_with(']');
    return "tribus_" + std::string(has_port ? host.substr(colon + 1) : "80");
}

std::optional<Site::Visitor> Site::visitor_of(const HttpRequest& request) {
    return visitor_with(hash_of_cookie(cookie_value(request.cookie, cookie_name(request.host))));
}

std::optional<Site::Visitor> Site::visitor_with(std::string_view hash) {
    const Session* const session = find_session(sessions_.of(pairing_), hash, wall_now());
    return session == nullptr ? std::nullopt : std::optional(Visitor{session->role, session->hash});
}

DaemonWatch* Site::watch_of(const std::string& daemon) {
    auto& watch = watches_[daemon];
    if (!watch) {
        const auto known = find_known(settings_.configurations, daemon);
        if (known && !known->tells.empty()) {
            watch = std::make_unique<DaemonWatch>(known->tells);
        }
    }
    if (!watch) {
        watches_.erase(daemon);
        return nullptr;
    }
    return watch.get();
}

bool Site::begin_stream(SocketClient& client, const Asked& asked) {
    const auto& [request, visitor, daemon, name, who, now] = asked;
    std::vector<std::shared_ptr<Stream>> own;
    for (const auto& one : streams_) {
        auto stream = one.lock();
        if (stream && stream->visitor == visitor->hash && !stream->displaced) {
            own.push_back(std::move(stream));
        }
    }
    if (own.size() >= kStreamsOfOneBrowser) {
        own.front()->displaced = true;
    }
    auto stream = std::make_shared<Stream>();
    stream->daemon = daemon.name;
    stream->visitor = visitor->hash;
    stream->looked_for_visitor = now;
    streams_.push_back(stream);
    watch_of(stream->daemon);
    client.repeat(period_in(request.query), now, [this, stream](SocketClient& to, Instant at) {
        return send_to_stream(stream, to, at);
    });
    return client.send(
        http_text({.type = "text/event-stream", .content = "retry: 3000\n\n", .endless = true}),
        now);
}

bool Site::send_to_stream(const std::shared_ptr<Stream>& stream, SocketClient& client,
                          Instant now) {
    const auto end = [&](std::string_view name, std::string_view data) {
        client.close_when_sent();
        return client.send(event(name, data), now);
    };
    if (stream->displaced) {
        return end("ended", reason("another page of this browser took the place"));
    }
    if (now - stream->looked_for_visitor >= kVisitorPeriod) {
        stream->looked_for_visitor = now;
        if (!visitor_with(stream->visitor)) {
            return end("revoked", "{}");
        }
    }
    DaemonWatch* const watch = watch_of(stream->daemon);
    const std::string problem =
        watch == nullptr ? "no daemon runs " + stream->daemon : watch->problem(now);
    if (problem != stream->said || (!problem.empty() && now - stream->said_at >= kSaidAgain)) {
        stream->said = problem;
        stream->said_at = now;
        if (!problem.empty()) {
            return client.send(event("gone", reason(problem)), now);
        }
    }
    if (watch == nullptr || watch->number() == stream->sent || !problem.empty()) {
        return true;
    }
    stream->sent = watch->number();
    return client.send(event("status", watch->newest()), now);
}

}  // namespace tribus::web
