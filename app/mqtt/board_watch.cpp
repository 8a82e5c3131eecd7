#include "app/mqtt/board_watch.h"

#include <algorithm>
#include <utility>

#include "app/client/parse_json.h"
#include "app/client/status_fields.h"

namespace tribus::mqtt {
namespace {

constexpr Duration kWatchPeriod = std::chrono::milliseconds(200);
constexpr std::size_t kMostDaemons = 64;

std::int64_t uptime_us(const nlohmann::json& status) {
    return status_fields::whole(status, "uptime_us").value_or(0);
}

}  // namespace

BoardWatch::BoardWatch(BoardOptions options, Outbox& outbox)
    : options_(std::move(options)), outbox_(outbox) {
    outbox_.retain(topics_of(options_.prefix, options_.board, "").board_availability,
                   std::string(kOnline));
}

void BoardWatch::look_for_daemons(const std::vector<FoundSocket>& sockets, Instant now) {
    for (const FoundSocket& found : sockets) {
        if (!daemons_.contains(found.name) && daemons_.size() < kMostDaemons) {
            daemons_.try_emplace(
                found.name, Daemon{.link = MonitorLink(found.path, kWatchPeriod),
                                   .topics = topics_of(options_.prefix, options_.board, found.name),
                                   .discovery_topic = discovery_topic(options_.discovery,
                                                                      options_.board, found.name),
                                   .received = now});
        }
    }
}

void BoardWatch::look(Instant now, std::chrono::microseconds wall_time) {
    for (auto& [name, daemon] : daemons_) {
        daemon.link.reconnect(now);
        for (const std::string& line : daemon.link.read()) {
            take(daemon, line, now);
        }
        if (!daemon.link.connected()) {
            daemon.changes.disconnected();
            become(daemon, Presence::gone, now, wall_time);
        } else if (now - daemon.received > kHangs) {
            become(daemon, Presence::silent, now, wall_time);
        } else if (daemon.newest && !has_new_figures(*daemon.newest)) {
            become(daemon, Presence::old_figures, now, wall_time);
        } else if (daemon.newest) {
            become(daemon, Presence::here, now, wall_time);
        }
    }
}

void BoardWatch::take(Daemon& daemon, const std::string& line, Instant now) {
    auto object = parse_json(line);
    const std::string type = status_fields::raw_text(object, "type");
    if (type == "status") {
        take_status(daemon, std::move(object), now);
    } else if (type == "changes" && daemon.newest) {
        take_changes(daemon, object, now);
    }
}

void BoardWatch::take_status(Daemon& daemon, nlohmann::json status, Instant now) {
    daemon.received = now;
    if (daemon.newest && !ChangeReader::same_process(status, *daemon.newest)) {
        const auto since = std::chrono::microseconds(uptime_us(status));
        const auto wall = status_fields::whole(status, "unix_time_us").value_or(0) - since.count();
        outbox_.add(daemon.topics.event,
                    daemon_event("restarted", "the daemon started again", wall, now - since));
        daemon.told = {};
    }
    if (const auto request = daemon.changes.take_status(status)) {
        daemon.link.send(*request);
    }
    if (!options_.discovery.empty()) {
        outbox_.retain(daemon.discovery_topic,
                       discovery_payload(daemon.topics, options_.board, status, options_.version));
    }
    daemon.newest = std::move(status);
    if (now - daemon.told >= kTellPeriod) {
        tell_status(daemon, now);
    }
}

void BoardWatch::take_changes(Daemon& daemon, const nlohmann::json& answer, Instant now) {
    const ChangeReader::News news = daemon.changes.take_answer(answer);
    outbox_.lost(news.lost);
    for (const nlohmann::json& change : news.changes) {
        if (auto event = event_of(change, *daemon.newest, now)) {
            outbox_.add(daemon.topics.event, std::move(*event));
        }
    }
    if (news.request) {
        daemon.link.send(*news.request);
    }
    tell_status(daemon, now);
}

void BoardWatch::tell_status(Daemon& daemon, Instant now) {
    outbox_.tell(daemon.topics.status, status_payload(*daemon.newest));
    daemon.told = now;
}

void BoardWatch::become(Daemon& daemon, Presence presence, Instant now,
                        std::chrono::microseconds wall_time) {
    const Presence before = std::exchange(daemon.presence, presence);
    if (before == presence) {
        return;
    }
    const bool here = presence == Presence::here;
    outbox_.retain(daemon.topics.availability, std::string(here ? kOnline : kOffline));
    // How things are when the watch begins is no event.
    if (before == Presence::unknown) {
        return;
    }
    const auto tell = [&](const char* word, const char* text) {
        outbox_.add(daemon.topics.event, daemon_event(word, text, wall_time.count(), now));
    };
    switch (presence) {
        case Presence::unknown:
            break;
        case Presence::here:
            tell("answers", "the daemon answers again");
            break;
        case Presence::gone:
            tell("gone", "the daemon is gone");
            break;
        case Presence::silent:
            tell("silent", "the daemon hangs: it says nothing");
            break;
        case Presence::old_figures:
            tell("old_figures", "the daemon's data thread hangs: its figures are old");
            break;
    }
}

std::vector<int> BoardWatch::descriptors() const {
    std::vector<int> all;
    for (const auto& [name, daemon] : daemons_) {
        all.push_back(daemon.link.descriptor());
    }
    return all;
}

}  // namespace tribus::mqtt
