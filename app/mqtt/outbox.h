#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/mqtt/report.h"
#include "core/time.h"

namespace tribus::mqtt {

/// A message for the broker.
struct Message {
    std::string topic;
    std::string payload;
    int quality = 0;  ///< 0: at most once, 1: at least once
    bool retained = false;
    /// Number of the event, which the broker must acknowledge; else 0.
    std::uint64_t event = 0;
};

/// Messages that wait for the broker: the newest status of each daemon, what is retained, and
/// events in their order, as many as fit. Any thread may call it; no call waits long.
class Outbox {
  public:
    struct Limits {
        std::size_t events = 1000;   ///< kept while the broker is away; then the oldest goes
        std::size_t under_way = 16;  ///< events that are sent and not acknowledged
    };

    /// `session`: begins the ids of events; different for each start of the program.
    Outbox(std::string session, Limits limits) : session_(std::move(session)), limits_(limits) {}

    /// Replaces what is retained there; nothing if it is the same.
    void retain(const std::string& topic, const std::string& payload);
    /// The newest status; one that was not sent yet is dropped.
    void tell(const std::string& topic, std::string payload);
    /// An event; it is kept until the broker has acknowledged it.
    void add(const std::string& topic, Event event);
    /// So many events before the next one are not known.
    void lost(std::uint64_t events);

    /// The broker is there: what is retained is sent first, then the events that waited, marked
    /// late. A status from before is dropped: it is old.
    void connected();
    /// The broker is gone: events that it has not acknowledged wait again.
    void disconnected();
    /// Sends retained messages below this topic again.
    void retain_again(const std::string& begin_of_topic);

    /// The next message to send, if there is one. Only while connected.
    std::optional<Message> next(Instant now);
    /// The broker has acknowledged the event with that number.
    void acknowledged(std::uint64_t event);

    std::size_t waiting_events() const;

  private:
    struct Waiting {
        std::string topic;
        Event event;
        std::uint64_t number = 0;
        bool late = false;
        bool under_way = false;
        std::uint64_t lost_before = 0;
    };
    struct Retained {
        std::string payload;
        bool sent = false;
    };

    std::optional<Message> next_event(Instant now);

    mutable std::mutex mutex_;
    std::string session_;
    Limits limits_;
    bool connected_ = false;
    std::map<std::string, Retained> retained_;
    std::map<std::string, std::string> newest_;
    std::deque<Waiting> events_;
    std::uint64_t last_number_ = 0;
    std::uint64_t lost_ = 0;
};

}  // namespace tribus::mqtt
