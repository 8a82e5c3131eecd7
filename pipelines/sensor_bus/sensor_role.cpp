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
      answers_(settings_.sensors.size()),
      ongoing_{.first_address = settings_.first_address} {}

void SensorRole::start(Instant now) {
    ongoing_.prepared_at = now - kPreparedFor;
}

void SensorRole::continue_from(const SensorRole& before) {
    ongoing_ = before.ongoing_;
    std::ranges::copy(before.answers_, answers_.begin());
}

void SensorRole::receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) {
    if (settings_.receives_echo) {
        ongoing_.echo.cancel(bytes, now);
    }
    if (ongoing_.pending && !bytes.empty()) {
        withhold();
    }
    bool frame_came = false;
    while (const auto frame = ongoing_.parser.next(bytes, now)) {
        take(*frame, now, !bytes.empty(), board);
        frame_came = true;
    }
    // Without a frame there is no hurry, because the next request is a slot away.
    if (frame_came && !ongoing_.pending) {
        prepare_all(now, board);
    }
}

void SensorRole::damaged_byte(Instant now) {
    if (settings_.receives_echo && ongoing_.echo.cancel_damaged(now)) {
        return;
    }
    if (ongoing_.pending) {
        withhold();
    }
    ongoing_.parser.damaged_byte(now);
}

void SensorRole::device_lost(ValueBoard& /*board*/) {
    ongoing_.pending = false;
    ongoing_.latest_request.reset();
    ongoing_.first_address = settings_.first_address;
}

void SensorRole::take(const SensorFrame& frame, Instant now, bool more_follows, ValueBoard& board) {
    const bool restarted = frame.command == SensorCommand::power_up || !ongoing_.latest_request ||
                           now - *ongoing_.latest_request >= kRestartSilence;
    if (restarted) {
        ongoing_.first_address = settings_.first_address;
        ongoing_.requests = {};
        ongoing_.period_confidence = 0;
    }
    ongoing_.latest_request = now;
    if (!frame.is_request() || frame.command == SensorCommand::power_up) {
        return;
    }
    ++ongoing_.counts.requests;
    if (!ongoing_.first_address && frame.command == SensorCommand::discover) {
        ongoing_.first_address = frame.address;
    }
    if (!more_follows) {
        ongoing_.requests.arrived(now);
    }
    if (!ongoing_.first_address || frame.address < *ongoing_.first_address ||
        frame.address >= *ongoing_.first_address + settings_.sensors.size()) {
        return;
    }
    if (more_follows) {
        ++ongoing_.counts.late;
        return;
    }
    answer(frame, static_cast<std::size_t>(frame.address - *ongoing_.first_address), now, board);
}

void SensorRole::answer(const SensorFrame& frame, std::size_t sensor, Instant now,
                        ValueBoard& board) {
    if (!prepare_reply(frame, sensor, now, board)) {
        ++ongoing_.counts.stale;
        return;
    }
    ongoing_.reply_at = now + settings_.reply_after;
    ongoing_.reply_until = now + settings_.reply_within;
    if (read_late(now)) {
        ++ongoing_.counts.late;
        return;
    }
    ongoing_.pending = true;
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
                            now - ongoing_.prepared_at < kPreparedFor;
        if (!usable) {
            prepare(sensor, now, board);
        }
        if (!answers_[sensor].available) {
            return false;
        }
        data = std::span(answers_[sensor].data).first(type.size);
    }
    ongoing_.reply_length = encode_sensor_frame(frame.command, frame.address, data, ongoing_.reply);
    return true;
}

/// Whether this program was delayed when the request came, judged by the period of the requests:
/// the answer would be late although the request was read just now.
bool SensorRole::read_late(Instant now) {
    const Duration behind = now - std::min(now, ongoing_.requests.fitted());
    const bool late = behind + settings_.reply_after > settings_.reply_within;
    const bool trusted = ongoing_.period_confidence >= kTrustedConfidence;
    ongoing_.period_confidence =
        std::clamp(ongoing_.period_confidence + (late ? -kCostOfLate : 1), 0, kMostConfidence);
    return late && trusted;
}

void SensorRole::withhold() {
    ongoing_.pending = false;
    ++ongoing_.counts.late;
}

std::span<const std::uint8_t> SensorRole::run(Instant now, ValueBoard& /*board*/) {
    if (!ongoing_.pending || now < ongoing_.reply_at) {
        return {};
    }
    if (now > ongoing_.reply_until) {
        withhold();
        return {};
    }
    ongoing_.pending = false;
    return {ongoing_.reply.data(), ongoing_.reply_length};
}

void SensorRole::written(Instant now, ValueBoard& board) {
    ++ongoing_.counts.answered;
    if (settings_.receives_echo) {
        ongoing_.echo.sent({ongoing_.reply.data(), ongoing_.reply_length}, now);
    }
    prepare_all(now, board);
}

void SensorRole::prepare_all(Instant now, const ValueBoard& board) {
    ongoing_.prepared_at = now;
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
        const double sent = *number * source->factor + source->offset;
        if (!lacks_sign_for(meaning, sent)) {
            put_raw(meaning, raw_of(meaning, sent), data);
            return true;
        }
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
