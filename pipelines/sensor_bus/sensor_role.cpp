#include "pipelines/sensor_bus/sensor_role.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace tribus {
namespace {

using namespace std::chrono_literals;

/// After power-on a receiver is silent for this time before it discovers sensors
/// (docs/protocols/ibus.md, "Sensor bus: timing"), and it finds the sensors before us in the chain
/// first.
constexpr Duration kRestartSilence = 500ms;
/// A prepared answer that is older is prepared again when the request comes: two slots.
constexpr Duration kPreparedFor = 16ms;
/// Upper limit of the confidence in the request period. Each request on time adds one. From
/// kTrustedConfidence on, the period may show that a request was read late. That costs kCostOfLate,
/// so that a second one in a row is not trusted: the receiver has another period, or none.
constexpr int kMostConfidence = 64;
constexpr int kTrustedConfidence = 32;
constexpr int kCostOfLate = 24;

}  // namespace

SensorRole::SensorRole(SensorRoleSettings settings)
    : settings_(std::move(settings)),
      first_address_(settings_.first_address),
      answers_(settings_.sensors.size()) {}

void SensorRole::start(Instant now) {
    prepared_at_ = now - kPreparedFor;
}

void SensorRole::continue_from(const SensorRole& before) {
    parser_ = before.parser_;
    echo_ = before.echo_;
    requests_ = before.requests_;
    first_address_ = before.first_address_;
    latest_request_ = before.latest_request_;
    std::ranges::copy(before.answers_, answers_.begin());
    prepared_at_ = before.prepared_at_;
    pending_ = before.pending_;
    reply_ = before.reply_;
    reply_length_ = before.reply_length_;
    reply_at_ = before.reply_at_;
    reply_until_ = before.reply_until_;
    period_confidence_ = before.period_confidence_;
    counts_ = before.counts_;
}

void SensorRole::receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) {
    if (settings_.receives_echo) {
        echo_.cancel(bytes, now);
    }
    if (pending_ && !bytes.empty()) {
        withhold();
    }
    bool frame_came = false;
    while (const auto frame = parser_.next(bytes, now)) {
        take(*frame, now, !bytes.empty(), board);
        frame_came = true;
    }
    // Without a frame there is no hurry, because the next request is a slot away.
    if (frame_came && !pending_) {
        prepare_all(now, board);
    }
}

void SensorRole::damaged_byte(Instant now) {
    if (settings_.receives_echo && echo_.cancel_damaged(now)) {
        return;
    }
    if (pending_) {
        withhold();
    }
    parser_.damaged_byte(now);
}

void SensorRole::device_lost(ValueBoard& /*board*/) {
    pending_ = false;
    latest_request_.reset();
    first_address_ = settings_.first_address;
}

void SensorRole::take(const SensorFrame& frame, Instant now, bool more_follows, ValueBoard& board) {
    const bool restarted = frame.command == SensorCommand::power_up || !latest_request_ ||
                           now - *latest_request_ >= kRestartSilence;
    if (restarted) {
        first_address_ = settings_.first_address;
        requests_ = {};
        period_confidence_ = 0;
    }
    latest_request_ = now;
    if (!frame.is_request() || frame.command == SensorCommand::power_up) {
        return;
    }
    ++counts_.requests;
    if (!first_address_ && frame.command == SensorCommand::discover) {
        first_address_ = frame.address;
    }
    if (!more_follows) {
        requests_.arrived(now);
    }
    if (!first_address_ || frame.address < *first_address_ ||
        frame.address >= *first_address_ + settings_.sensors.size()) {
        return;
    }
    if (more_follows) {
        ++counts_.late;
        return;
    }
    answer(frame, static_cast<std::size_t>(frame.address - *first_address_), now, board);
}

void SensorRole::answer(const SensorFrame& frame, std::size_t sensor, Instant now,
                        ValueBoard& board) {
    if (!prepare_reply(frame, sensor, now, board)) {
        ++counts_.stale;
        return;
    }
    reply_at_ = now + settings_.reply_after;
    reply_until_ = now + settings_.reply_within;
    if (read_late(now)) {
        ++counts_.late;
        return;
    }
    pending_ = true;
}

bool SensorRole::prepare_reply(const SensorFrame& frame, std::size_t sensor, Instant now,
                               ValueBoard& board) {
    const SensorType& type = settings_.sensors[sensor].type;
    std::array<std::uint8_t, 2> type_data{type.id, type.size};
    std::span<const std::uint8_t> data;
    if (frame.command == SensorCommand::type) {
        data = type_data;
    } else if (frame.command == SensorCommand::value) {
        const bool usable = answers_[sensor].available && now <= answers_[sensor].until &&
                            now - prepared_at_ < kPreparedFor;
        if (!usable) {
            prepare(sensor, now, board);
        }
        if (!answers_[sensor].available) {
            return false;
        }
        data = std::span(answers_[sensor].data).first(type.size);
    }
    reply_length_ = encode_sensor_frame(frame.command, frame.address, data, reply_);
    return true;
}

/// Whether this program was delayed when the request came, judged by the period of the requests:
/// the answer would be late although the request was read just now.
bool SensorRole::read_late(Instant now) {
    const Duration behind = now - std::min(now, requests_.fitted());
    const bool late = behind + settings_.reply_after > settings_.reply_within;
    const bool trusted = period_confidence_ >= kTrustedConfidence;
    period_confidence_ =
        std::clamp(period_confidence_ + (late ? -kCostOfLate : 1), 0, kMostConfidence);
    return late && trusted;
}

void SensorRole::withhold() {
    pending_ = false;
    ++counts_.late;
}

std::span<const std::uint8_t> SensorRole::run(Instant now, ValueBoard& /*board*/) {
    if (!pending_ || now < reply_at_) {
        return {};
    }
    if (now > reply_until_) {
        withhold();
        return {};
    }
    pending_ = false;
    return {reply_.data(), reply_length_};
}

void SensorRole::written(Instant now, ValueBoard& board) {
    ++counts_.answered;
    if (settings_.receives_echo) {
        echo_.sent({reply_.data(), reply_length_}, now);
    }
    prepare_all(now, board);
}

void SensorRole::prepare_all(Instant now, const ValueBoard& board) {
    prepared_at_ = now;
    for (std::size_t sensor = 0; sensor < answers_.size(); ++sensor) {
        prepare(sensor, now, board);
    }
}

void SensorRole::prepare(std::size_t sensor, Instant now, const ValueBoard& board) {
    Answer& answer = answers_[sensor];
    answer = {.data = {}, .available = true, .until = kNever};
    for (std::size_t field = 0; field < settings_.sensors[sensor].type.fields.size(); ++field) {
        answer.available = fill(sensor, field, now, board) && answer.available;
    }
}

/// Returns false if there is no number to send.
bool SensorRole::fill(std::size_t sensor, std::size_t field, Instant now, const ValueBoard& board) {
    const SensorSettings& settings = settings_.sensors[sensor];
    const SensorField& meaning = settings.type.fields[field];
    Answer& answer = answers_[sensor];
    const auto& source = settings.sources[field];
    const auto number = source ? board.fresh(source->value, now) : std::nullopt;
    const auto data = std::span(answer.data).first(settings.type.size);
    if (number) {
        answer.until = std::min(answer.until, board.fresh_until(source->value));
        put_raw(meaning, raw_of(meaning, *number * source->factor + source->offset), data);
        return true;
    }
    if (meaning.not_available) {
        put_raw(meaning, *meaning.not_available, data);
        return true;
    }
    if (settings.when_stale) {
        put_raw(meaning, raw_of(meaning, *settings.when_stale), data);
        return true;
    }
    return !source;
}

}  // namespace tribus
