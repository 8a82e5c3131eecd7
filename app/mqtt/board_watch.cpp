#include "app/mqtt/board_watch.h"

#include <algorithm>
#include <utility>

#include "app/client/status_fields.h"

namespace tribus::mqtt {
namespace {

constexpr Duration kWatchPeriod = std::chrono::milliseconds(200);
constexpr std::size_t kMostDaemons = 64;

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
    auto status = nlohmann::json::parse(line, nullptr, false);
    if (!status.is_object() || status_fields::raw_text(status, "type") != "status") {
        return;
    }
    daemon.received = now;
    std::vector<Event> events;
    if (daemon.newest) {
        events = changes(*daemon.newest, status, now);
    }
    const bool tells = !events.empty() || now - daemon.told >= kTellPeriod;
    for (Event& event : events) {
        outbox_.add(daemon.topics.event, std::move(event));
    }
    if (!options_.discovery.empty()) {
        outbox_.retain(daemon.discovery_topic,
                       discovery_payload(daemon.topics, options_.board, status, options_.version));
    }
    if (tells) {
        outbox_.tell(daemon.topics.status, status_payload(status));
        daemon.told = now;
    }
    daemon.newest = std::move(status);
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
