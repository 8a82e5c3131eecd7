#include "app/mqtt/outbox.h"

#include <algorithm>

#include <fmt/format.h>

namespace tribus::mqtt {

void Outbox::retain(const std::string& topic, const std::string& payload) {
    const std::lock_guard lock(mutex_);
    Retained& retained = retained_[topic];
    if (retained.payload != payload) {
        retained = {.payload = payload, .sent = false};
    }
}

void Outbox::tell(const std::string& topic, std::string payload) {
    const std::lock_guard lock(mutex_);
    newest_[topic] = std::move(payload);
}

void Outbox::add(const std::string& topic, Event event) {
    const std::lock_guard lock(mutex_);
    if (events_.size() >= limits_.events) {
        lost_ += 1 + events_.front().lost_before;
        events_.pop_front();
        if (!events_.empty()) {
            events_.front().lost_before += std::exchange(lost_, 0);
        }
    }
    events_.push_back({.topic = topic,
                       .event = std::move(event),
                       .number = ++last_number_,
                       .late = !connected_,
                       .lost_before = std::exchange(lost_, 0)});
}

void Outbox::lost(std::uint64_t events) {
    const std::lock_guard lock(mutex_);
    lost_ += events;
}

void Outbox::connected() {
    const std::lock_guard lock(mutex_);
    connected_ = true;
    newest_.clear();
    for (auto& [topic, retained] : retained_) {
        retained.sent = false;
    }
}

void Outbox::disconnected() {
    const std::lock_guard lock(mutex_);
    connected_ = false;
    for (Waiting& waiting : events_) {
        waiting.under_way = false;
        waiting.late = true;
    }
}

void Outbox::retain_again(const std::string& begin_of_topic) {
    const std::lock_guard lock(mutex_);
    for (auto& [topic, retained] : retained_) {
        retained.sent = retained.sent && !topic.starts_with(begin_of_topic);
    }
}

std::optional<Message> Outbox::next(Instant now) {
    const std::lock_guard lock(mutex_);
    if (!connected_) {
        return std::nullopt;
    }
    for (auto& [topic, retained] : retained_) {
        if (!retained.sent) {
            retained.sent = true;
            return Message{
                .topic = topic, .payload = retained.payload, .quality = 1, .retained = true};
        }
    }
    if (auto event = next_event(now)) {
        return event;
    }
    if (newest_.empty()) {
        return std::nullopt;
    }
    auto newest = newest_.extract(newest_.begin());
    return Message{.topic = newest.key(), .payload = std::move(newest.mapped())};
}

std::optional<Message> Outbox::next_event(Instant now) {
    const auto under_way =
        static_cast<std::size_t>(std::ranges::count(events_, true, &Waiting::under_way));
    const auto waiting = std::ranges::find(events_, false, &Waiting::under_way);
    if (under_way >= limits_.under_way || waiting == events_.end()) {
        return std::nullopt;
    }
    waiting->under_way = true;
    return Message{
        .topic = waiting->topic,
        .payload = event_payload(waiting->event, fmt::format("{}-{}", session_, waiting->number),
                                 waiting->late, waiting->lost_before, now),
        .quality = 1,
        .event = waiting->number};
}

void Outbox::acknowledged(std::uint64_t event) {
    const std::lock_guard lock(mutex_);
    std::erase_if(events_, [event](const Waiting& waiting) { return waiting.number == event; });
}

std::size_t Outbox::waiting_events() const {
    const std::lock_guard lock(mutex_);
    return events_.size();
}

}  // namespace tribus::mqtt
