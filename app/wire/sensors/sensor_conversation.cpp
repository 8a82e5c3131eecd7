#include "app/wire/sensors/sensor_conversation.h"

#include <utility>

namespace tribus {
namespace {

bool same_request(const SensorFrame& one, const SensorFrame& other) {
    return one.is_request() && other.is_request() && one.command == other.command &&
           one.address == other.address;
}

/// True if `other` follows too quickly to be in another slot.
bool follows_at_once(const ReceivedSensorFrame& one, const ReceivedSensorFrame& other) {
    return one.end && other.start && *other.start - *one.end <= kLongestSensorPause;
}

}  // namespace

SensorConversation::SensorConversation(std::function<void(const SensorExchange&)> handler)
    : handler_(std::move(handler)) {}

void SensorConversation::take(const ReceivedSensorFrame& received) {
    if (received.frame.command == SensorCommand::power_up) {
        resolve(&received);
        report({.outcome = SensorOutcome::power_up, .asked = received});
    } else if (received.frame.is_request()) {
        take_request(received);
    } else {
        take_answer(received);
    }
}

void SensorConversation::take_request(const ReceivedSensorFrame& received) {
    if (pending_.empty() || !same_request(pending_.back().frame, received.frame)) {
        resolve(&received);
        pending_.push_back(received);
        return;
    }
    const bool timed = pending_.back().end && received.start;
    const bool discover = received.frame.command == SensorCommand::discover;
    if (!timed && discover && pending_.size() > 1) {
        // The first of three equal frames had no reply.
        leave_unanswered(pending_.front(), 0, &received);
        pending_.erase(pending_.begin());
    } else if (timed ? !follows_at_once(pending_.back(), received) : !discover) {
        resolve(&received);
    }
    pending_.push_back(received);
}

void SensorConversation::take_answer(const ReceivedSensorFrame& received) {
    if (!is_pending(received)) {
        resolve(&received);
        report({.outcome = SensorOutcome::unasked, .asked = received});
        return;
    }
    answer(pending_.front(), static_cast<unsigned>(pending_.size() - 1), pending_.back(), received);
    pending_.clear();
}

bool SensorConversation::is_pending(const ReceivedSensorFrame& received) const {
    return !pending_.empty() && pending_.back().frame.command == received.frame.command &&
           pending_.back().frame.address == received.frame.address;
}

void SensorConversation::finish() {
    resolve(nullptr);
}

/// Ends the pending request without a reply that has data. `next` is the following frame, if there
/// is one.
void SensorConversation::resolve(const ReceivedSensorFrame* next) {
    if (pending_.empty()) {
        return;
    }
    if (pending_.front().frame.command == SensorCommand::discover && pending_.size() > 1) {
        resolve_discover(next);
    } else {
        leave_unanswered(pending_.front(), static_cast<unsigned>(pending_.size() - 1), next);
    }
    pending_.clear();
}

/// Decides a request that came twice or more, by the rule at the class.
void SensorConversation::resolve_discover(const ReceivedSensorFrame* next) {
    const ReceivedSensorFrame& first = pending_.front();
    const ReceivedSensorFrame& last = pending_.back();
    const auto again = static_cast<unsigned>(pending_.size() - 1);
    const bool timed = first.end && last.start;
    const bool asks_type = next != nullptr && next->frame.command == SensorCommand::type &&
                           next->frame.address == first.frame.address;
    const bool ends_there = next == nullptr && timed && counts_.echoes == 0;
    if (asks_type || ends_there) {
        answer(first, again - 1, pending_[again - 1], last);
    } else if (timed) {
        leave_unanswered(first, again, next);
    } else {
        leave_unanswered(first, 0, &last);
        leave_unanswered(last, 0, next);
    }
}

void SensorConversation::leave_unanswered(const ReceivedSensorFrame& asked, unsigned echoes,
                                          const ReceivedSensorFrame* next) {
    const bool discover = asked.frame.command == SensorCommand::discover;
    SensorOutcome outcome = discover ? SensorOutcome::free : SensorOutcome::missed;
    if (next == nullptr) {
        outcome = SensorOutcome::cut;
    }
    report({.outcome = outcome,
            .asked = asked,
            .echoes = echoes,
            .asked_again = next != nullptr && same_request(asked.frame, next->frame)});
}

void SensorConversation::answer(const ReceivedSensorFrame& asked, unsigned echoes,
                                const ReceivedSensorFrame& asked_end,
                                const ReceivedSensorFrame& answer) {
    SensorExchange exchange{
        .outcome = SensorOutcome::answered, .asked = asked, .answer = answer, .echoes = echoes};
    if (asked_end.end && answer.start) {
        exchange.response_time = *answer.start - *asked_end.end;
    }
    const SensorFrame& frame = answer.frame;
    if (frame.command == SensorCommand::type && frame.data_size == 2) {
        addresses_[frame.address].type = {.id = frame.data[0], .size = frame.data[1]};
    }
    report(exchange);
}

void SensorConversation::report(SensorExchange exchange) {
    exchange.type = addresses_[exchange.asked.frame.address].type;
    count(exchange);
    handler_(exchange);
}

void SensorConversation::count(const SensorExchange& exchange) {
    const SensorFrame& asked = exchange.asked.frame;
    SensorAddressCounts& address = addresses_[asked.address];
    counts_.echoes += exchange.echoes;
    if (exchange.outcome == SensorOutcome::power_up) {
        ++counts_.power_up;
        return;
    }
    if (exchange.outcome == SensorOutcome::unasked) {
        ++counts_.unasked;
        return;
    }
    counts_.discover += asked.command == SensorCommand::discover ? 1U : 0U;
    counts_.type += asked.command == SensorCommand::type ? 1U : 0U;
    counts_.value += asked.command == SensorCommand::value ? 1U : 0U;
    if (exchange.outcome == SensorOutcome::free) {
        ++counts_.probes;
        ++address.probes;
        return;
    }
    ++counts_.requests;
    ++address.requests;
    if (exchange.outcome == SensorOutcome::answered) {
        ++counts_.replies;
        ++address.replies;
    } else if (exchange.outcome == SensorOutcome::missed) {
        ++counts_.misses;
        ++address.misses;
        counts_.misses_asked_again += exchange.asked_again ? 1U : 0U;
    }
    if (exchange.response_time) {
        address.response_times.push_back(*exchange.response_time);
    }
}

}  // namespace tribus
