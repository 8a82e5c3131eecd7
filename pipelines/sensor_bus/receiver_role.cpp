#include "pipelines/sensor_bus/receiver_role.h"

#include <algorithm>
#include <utility>

namespace tribus {
namespace {

/// As genuine receivers (docs/protocols/ibus.md, "Sensor bus: timing"): ten power-up frames, then
/// 508 ms of silence.
constexpr int kPowerUpFrames = 10;
constexpr int kSilentSlots = 66;
constexpr std::uint8_t kPowerUpByte = 0xF0;
/// The sizes of nearly all sensors.
constexpr std::uint8_t kShortValue = 2;
constexpr std::uint8_t kLongValue = 4;
/// A sensor that never reported its type is gone after this many discover requests without an
/// answer. If other sensors are before it, it gets one each half second only.
constexpr int kGoneAfter = 8;
/// Longer values do not fit into a raw value.
constexpr std::size_t kLongestRaw = 4;

}  // namespace

bool is_readable(const SensorType& type, std::uint8_t size) {
    const auto is_usual = [](std::uint8_t one) { return one == kShortValue || one == kLongValue; };
    return type.size == size || (is_usual(type.size) && is_usual(size));
}

ReceiverRole::ReceiverRole(ReceiverRoleSettings settings) : settings_(std::move(settings)) {
    for (const SensorType& type : settings_.types.all()) {
        types_by_id_[type.id] = &type;
        const std::uint8_t other = type.size == kShortValue ? kLongValue : kShortValue;
        if (is_readable(type, other)) {
            resized_.push_back(with_size(type, other));
        }
    }
}

void ReceiverRole::start(Instant now) {
    ongoing_.next_slot = now;
    ongoing_.stage = settings_.power_up_frames ? Stage::power_up : Stage::polling;
}

bool ReceiverRole::receives_echo() const {
    const bool known = settings_.power_up_frames && ongoing_.stage != Stage::power_up;
    return settings_.wires == Wires::one ||
           (settings_.wires == Wires::automatic && (!known || ongoing_.echo.counts().returned > 0));
}

void ReceiverRole::receive(std::span<const std::uint8_t> bytes, Instant now, ValueBoard& board) {
    if (receives_echo()) {
        ongoing_.echo.cancel(bytes, now);
    }
    while (const auto frame = ongoing_.parser.next(bytes, now)) {
        take(*frame, now, board);
    }
}

void ReceiverRole::damaged_byte(Instant now) {
    if (!receives_echo() || !ongoing_.echo.cancel_damaged(now)) {
        ongoing_.parser.damaged_byte(now);
    }
}

std::span<const std::uint8_t> ReceiverRole::run(Instant now, ValueBoard& board) {
    if (now < ongoing_.next_slot) {
        return {};
    }
    ongoing_.next_slot += settings_.slot * ((now - ongoing_.next_slot) / settings_.slot + 1);
    conclude(board);
    const auto request = next_request();
    return request ? send(*request) : std::span<const std::uint8_t>{};
}

/// Evaluates the slot that has ended.
void ReceiverRole::conclude(ValueBoard& board) {
    const auto unanswered = std::exchange(ongoing_.open, std::nullopt);
    if (!unanswered || unanswered->command == SensorCommand::power_up) {
        return;
    }
    if (unanswered->command == SensorCommand::discover) {
        int& misses = sensors_[unanswered->address - 1U].misses;
        misses = std::min(misses + 1, kGoneAfter);
        if (misses == kGoneAfter) {
            fault_of(unanswered->address) = {};
        }
        return;
    }
    ++ongoing_.counts.misses;
    if (unanswered->command == SensorCommand::value) {
        value_missed(unanswered->address, board);
    } else {
        type_missed(*unanswered);
    }
}

void ReceiverRole::type_missed(const Request& request) {
    if (!std::exchange(ongoing_.repeated, !ongoing_.repeated)) {
        ongoing_.follow_up = request;
    } else if (request.address > found_count_) {
        fault_of(request.address) = {.kind = SensorFault::Kind::no_type};
    }
}

/// Asks once more in the next slot, as genuine receivers do. Then the other sensors have their
/// turn, so that a sensor without a value costs them little.
void ReceiverRole::value_missed(std::uint8_t address, ValueBoard& board) {
    const std::size_t sensor = address - 1U;
    if (++sensors_[sensor].misses >= settings_.drop_after) {
        drop_from(sensor, board);
        ongoing_.repeated = false;
        ongoing_.follow_up = Request{SensorCommand::discover, address};
    } else if (!std::exchange(ongoing_.repeated, !ongoing_.repeated)) {
        ongoing_.follow_up = Request{SensorCommand::value, address};
    }
}

std::optional<ReceiverRole::Request> ReceiverRole::next_request() {
    ++ongoing_.slots_in_stage;
    if (ongoing_.stage == Stage::power_up) {
        if (ongoing_.slots_in_stage <= kPowerUpFrames) {
            return Request{SensorCommand::power_up, 0};
        }
        ongoing_.stage = Stage::silence;
        ongoing_.slots_in_stage = 1;
    }
    if (ongoing_.stage == Stage::silence) {
        if (ongoing_.slots_in_stage <= kSilentSlots) {
            return std::nullopt;
        }
        ongoing_.stage = Stage::polling;
    }
    ++ongoing_.slots_since_probe;
    const auto follow_up = std::exchange(ongoing_.follow_up, std::nullopt);
    return follow_up ? follow_up : next_poll();
}

ReceiverRole::Request ReceiverRole::next_poll() {
    const auto next_free = static_cast<std::uint8_t>(found_count_ + 1);
    const bool probe =
        ongoing_.slots_since_probe >= settings_.probe_every && found_count_ < kMostSensors;
    if (found_count_ == 0 || probe) {
        ongoing_.slots_since_probe = 0;
        return {SensorCommand::discover, next_free};
    }
    ongoing_.next_polled = ongoing_.next_polled % found_count_ + 1;
    return {SensorCommand::value, static_cast<std::uint8_t>(ongoing_.next_polled)};
}

std::span<const std::uint8_t> ReceiverRole::send(const Request& request) {
    if (request.command == SensorCommand::power_up) {
        ongoing_.wire = {kSensorRequestBytes, kPowerUpByte, 0x0B, 0xFF};
        ongoing_.wire_length = kSensorRequestBytes;
    } else {
        ongoing_.wire_length =
            encode_sensor_frame(request.command, request.address, {}, ongoing_.wire);
    }
    ongoing_.open = request;
    return {ongoing_.wire.data(), ongoing_.wire_length};
}

void ReceiverRole::written(Instant now, ValueBoard& /*board*/) {
    ++ongoing_.counts.requests;
    if (receives_echo()) {
        ongoing_.echo.sent({ongoing_.wire.data(), ongoing_.wire_length}, now);
    }
}

void ReceiverRole::dropped() {
    ++ongoing_.counts.dropped;
    ongoing_.open.reset();
    if (ongoing_.stage == Stage::power_up) {
        ongoing_.slots_in_stage = 0;
    }
}

void ReceiverRole::device_lost(ValueBoard& board) {
    for (std::size_t sensor = 0; sensor < kMostSensors; ++sensor) {
        forget_reading(sensor, board);
    }
    ongoing_.counts.lost_sensors += found_count_;
    found_count_ = 0;
    ongoing_.faults = {};
    ongoing_.open.reset();
    ongoing_.follow_up.reset();
    ongoing_.repeated = false;
    ongoing_.slots_in_stage = 0;
    ongoing_.stage = settings_.power_up_frames ? Stage::power_up : Stage::polling;
}

std::size_t ReceiverRole::size_due(const SensorFrame& frame) const {
    constexpr std::size_t kTypeBytes = 2;
    const std::size_t sensor = frame.address - 1U;
    switch (frame.command) {
        case SensorCommand::type:
            return kTypeBytes;
        case SensorCommand::value:
            return sensor < found_count_ ? found_[sensor].size : 0;
        default:
            return 0;
    }
}

void ReceiverRole::take(const SensorFrame& frame, Instant now, ValueBoard& board) {
    if (ongoing_.open != Request{frame.command, frame.address} || frame.address == 0 ||
        frame.data_size != size_due(frame)) {
        refuse(frame);
        return;
    }
    ongoing_.open.reset();
    ongoing_.repeated = false;
    ++ongoing_.counts.replies;
    const std::size_t sensor = frame.address - 1U;
    switch (frame.command) {
        case SensorCommand::discover:
            sensors_[frame.address - 1U].misses = 0;
            ongoing_.follow_up = Request{SensorCommand::type, frame.address};
            break;
        case SensorCommand::type:
            take_type(frame, board);
            break;
        default:
            sensors_[sensor].misses = 0;
            fault_of(frame.address) = {};
            read_value(sensor, frame.payload(), now, board);
            break;
    }
}

/// A value of another size than was told may come from another sensor that was plugged in instead:
/// after as many of them as a sensor may miss, its type is asked for again.
void ReceiverRole::refuse(const SensorFrame& frame) {
    ++ongoing_.counts.wrong;
    const bool is_value = frame.command == SensorCommand::value && !frame.is_request() &&
                          ongoing_.open == Request{frame.command, frame.address};
    if (!is_value) {
        return;
    }
    ongoing_.open.reset();
    ongoing_.repeated = false;
    fault_of(frame.address) = {.kind = SensorFault::Kind::wrong_size, .sent_size = frame.data_size};
    int& misses = sensors_[frame.address - 1U].misses;
    if (++misses >= settings_.drop_after) {
        misses = 0;
        ongoing_.follow_up = Request{SensorCommand::type, frame.address};
    }
}

/// The type of the next sensor, or once more that of one whose values have the wrong size.
void ReceiverRole::take_type(const SensorFrame& frame, ValueBoard& board) {
    const std::size_t sensor = frame.address - 1U;
    const FoundSensor found{.type = frame.data[0], .size = frame.data[1]};
    if (sensor < found_count_ && found_[sensor] != found) {
        drop_from(sensor, board);
    }
    if (sensor == found_count_) {
        fault_of(frame.address) = {};
        add_sensor(found);
    }
}

void ReceiverRole::add_sensor(const FoundSensor& found) {
    const std::size_t sensor = found_count_;
    found_[sensor] = found;
    sensors_[sensor] = {.type = type_of(found), .by_type = places_of_first(found.type)};
    ++found_count_;
    if (found_count_ < kMostSensors) {
        ongoing_.follow_up =
            Request{SensorCommand::discover, static_cast<std::uint8_t>(found_count_ + 1)};
    }
}

void ReceiverRole::continue_from(const ReceiverRole& before) {
    ongoing_ = before.ongoing_;
    // Types and indices come from the tables of this role.
    for (const FoundSensor& found : before.found()) {
        found_[found_count_] = found;
        sensors_[found_count_] = {.type = type_of(found),
                                  .by_type = places_of_first(found.type),
                                  .misses = before.sensors_[found_count_].misses};
        ++found_count_;
    }
}

const SensorType* ReceiverRole::type_of(const FoundSensor& found) const {
    const SensorType* type = types_by_id_[found.type];
    if (type == nullptr || type->size == found.size) {
        return type;
    }
    const auto resized = std::ranges::find_if(resized_, [&](const SensorType& candidate) {
        return candidate.id == found.type && candidate.size == found.size;
    });
    return resized == resized_.end() ? nullptr : &*resized;
}

/// Null if a sensor that was found earlier has the same type.
const TypePlaces* ReceiverRole::places_of_first(std::uint8_t type) const {
    const auto places = std::ranges::find(settings_.first_of_type, type, &TypePlaces::type);
    const bool first = std::ranges::find(found(), type, &FoundSensor::type) == found().end();
    return first && places != settings_.first_of_type.end() ? &*places : nullptr;
}

void ReceiverRole::read_value(std::size_t sensor, std::span<const std::uint8_t> data, Instant now,
                              ValueBoard& board) {
    const Sensor& known = sensors_[sensor];
    const ReadingPlaces& places = settings_.readings[sensor];
    const std::uint8_t tag = found_[sensor].type;
    const std::size_t fields = known.type == nullptr ? 0 : known.type->fields.size();
    for (std::size_t i = 0; i < fields; ++i) {
        const SensorField& field = known.type->fields[i];
        const auto raw = raw_in(field, data);
        const auto number = raw ? number_of(field, *raw) : std::nullopt;
        const auto tell = [&](const std::vector<std::size_t>& values) {
            if (i < values.size() && number) {
                board.set(values[i], *number, now, tag);
            } else if (i < values.size()) {
                board.remove(values[i]);
            }
        };
        tell(places.fields);
        if (known.by_type != nullptr) {
            tell(known.by_type->fields);
        }
    }
    const auto signed_raw = fields == 1 ? raw_in(known.type->fields[0], data) : std::nullopt;
    if (data.size() <= kLongestRaw) {
        board.set(places.raw,
                  signed_raw ? static_cast<double>(*signed_raw)
                             : static_cast<double>(*plain_raw_in(data)),
                  now, tag);
    }
}

/// The readings of the sensors behind it stay until they are stale, because most are found again at
/// once.
void ReceiverRole::drop_from(std::size_t sensor, ValueBoard& board) {
    forget_reading(sensor, board);
    ongoing_.counts.lost_sensors += found_count_ - sensor;
    found_count_ = sensor;
    std::fill(ongoing_.faults.begin() + static_cast<std::ptrdiff_t>(sensor), ongoing_.faults.end(),
              SensorFault{});
    ongoing_.next_polled = 0;
}

void ReceiverRole::forget_reading(std::size_t sensor, ValueBoard& board) {
    board.remove(settings_.readings[sensor].raw);
    for (const std::size_t value : settings_.readings[sensor].fields) {
        board.remove(value);
    }
    if (sensors_[sensor].by_type != nullptr) {
        for (const std::size_t value : sensors_[sensor].by_type->fields) {
            board.remove(value);
        }
    }
}

}  // namespace tribus
