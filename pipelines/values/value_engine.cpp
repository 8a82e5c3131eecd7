#include "pipelines/values/value_engine.h"

#include <algorithm>
#include <utility>

namespace tribus {

ValueEngine::ValueEngine(ValueEngineSettings settings)
    : board_(std::move(settings.values)),
      messages_(std::move(settings.messages)),
      health_(std::move(settings.health)),
      channels_(std::move(settings.channels)),
      machine_(std::move(settings.machine)),
      constants_(std::move(settings.constants)) {
    for (SensorBusSettings& bus : settings.buses) {
        if (auto* sensor = std::get_if<SensorRoleSettings>(&bus)) {
            buses_.emplace_back(std::make_unique<SensorRole>(std::move(*sensor)));
        } else {
            buses_.emplace_back(
                std::make_unique<ReceiverRole>(std::move(std::get<ReceiverRoleSettings>(bus))));
        }
        roles_.push_back(std::visit([](const auto& role) -> SensorBusRole* { return role.get(); },
                                    buses_.back()));
    }
    std::size_t most_values = 0;
    for (const ValueMessageSettings& message : messages_) {
        most_values = std::max(most_values, message.values.size());
    }
    readings_.resize(most_values);
    make_health_watch();
    ran_.reserve(buses_.size());
    transmissions_.resize(buses_.size());
}

/// Covers the inputs and outputs that named values refer to.
void ValueEngine::make_health_watch() {
    std::size_t inputs = 0;
    std::size_t outputs = 0;
    for (const HealthValue& health : health_) {
        std::size_t& count = std::holds_alternative<InputFact>(health.fact) ? inputs : outputs;
        count = std::max(count, health.index + 1);
    }
    if (!health_.empty()) {
        health_watch_.emplace(inputs, outputs);
    }
}

void ValueEngine::start(Instant now) {
    for (const ConstantValue& constant : constants_) {
        board_.set(constant.value, constant.number, now);
    }
    if (health_watch_) {
        next_health_ = now;
    }
    for (SensorBusRole* role : roles_) {
        role->start(now);
    }
}

void ValueEngine::continue_from(ValueEngine& before, const ValueCarry& carry,
                                const EngineCarry& engine) {
    board_.continue_from(before.board_, carry.values);
    for (std::size_t i = 0; i < messages_.size(); ++i) {
        if (const CarriedFrom from = carry.messages[i]) {
            std::swap(messages_[i].reader, before.messages_[*from].reader);
        }
    }
    for (std::size_t i = 0; i < buses_.size(); ++i) {
        const CarriedFrom from = carry.buses[i];
        if (!from) {
            continue;
        }
        if (const auto* sensor = std::get_if<0>(&buses_[i])) {
            (*sensor)->continue_from(*std::get<0>(before.buses_[*from]));
        } else {
            std::get<1>(buses_[i])->continue_from(*std::get<1>(before.buses_[*from]));
        }
    }
    if (health_watch_ && before.health_watch_) {
        health_watch_->continue_from(*before.health_watch_, engine);
    }
}

CanValueReader* ValueEngine::can_reader(std::size_t message) const {
    const auto* reader = std::get_if<std::unique_ptr<CanValueReader>>(&messages_[message].reader);
    return reader == nullptr ? nullptr : reader->get();
}

ByteValueReader* ValueEngine::byte_reader(std::size_t message) const {
    const auto* reader = std::get_if<std::unique_ptr<ByteValueReader>>(&messages_[message].reader);
    return reader == nullptr ? nullptr : reader->get();
}

std::span<const CanIdMatch> ValueEngine::wanted_ids(std::size_t message) const {
    const CanValueReader* reader = can_reader(message);
    return reader == nullptr ? std::span<const CanIdMatch>() : reader->wanted();
}

bool ValueEngine::uses_fd(std::size_t message) const {
    const CanValueReader* reader = can_reader(message);
    return reader != nullptr && reader->uses_fd();
}

void ValueEngine::receive(std::size_t message, const CanFrame& frame, Instant at) {
    CanValueReader* reader = can_reader(message);
    if (reader == nullptr) {
        return;
    }
    if (const auto of = reader->take(frame, at, readings_)) {
        note_readings(messages_[message], *of);
    }
}

void ValueEngine::receive_message(std::size_t message, std::span<const std::uint8_t> bytes,
                                  Instant now) {
    ByteValueReader* reader = byte_reader(message);
    while (reader != nullptr && reader->next(bytes, now, readings_)) {
        note_readings(messages_[message], now);
    }
}

void ValueEngine::message_damaged(std::size_t message) {
    if (ByteValueReader* reader = byte_reader(message)) {
        reader->damaged_byte();
    }
}

void ValueEngine::message_lost(std::size_t message) {
    if (ByteValueReader* reader = byte_reader(message)) {
        reader->reset();
    }
}

/// Puts the latest readings on the board.
void ValueEngine::note_readings(const ValueMessageSettings& source, Instant at) {
    for (std::size_t i = 0; i < source.values.size(); ++i) {
        const auto value = source.values[i];
        const ValueReading& reading = readings_[i];
        if (value && reading.state == ValueReading::State::number) {
            board_.set(*value, reading.number, at);
        } else if (value && reading.state == ValueReading::State::not_available) {
            board_.remove(*value);
        }
    }
}

void ValueEngine::set_machine(std::size_t index, std::optional<double> number, Instant at) {
    if (number) {
        board_.set(machine_[index], *number, at);
    } else {
        board_.remove(machine_[index]);
    }
}

void ValueEngine::update_health(const Engine& engine, Instant now) {
    health_watch_->look(engine, now);
    for (const HealthValue& health : health_) {
        const auto number = std::visit(
            [&](auto fact) { return health_watch_->number(engine, health.index, fact, now); },
            health.fact);
        if (number) {
            board_.set(health.value, *number, now);
        } else {
            board_.remove(health.value);
        }
    }
}

void ValueEngine::update_channels(const Engine& engine, Instant now) {
    for (const ChannelValue& told : channels_) {
        const ChannelFrame* frame = nullptr;
        if (told.of_output && engine.outputs()[told.index].sends()) {
            frame = &engine.outputs()[told.index].latest();
        } else if (!told.of_output && engine.inputs()[told.index].link().alive(now)) {
            frame = &engine.inputs()[told.index].control();
        }
        if (frame != nullptr && frame->has(told.channel)) {
            board_.set(told.value, frame->pulses()[told.channel].microseconds(), now);
        } else {
            board_.remove(told.value);
        }
    }
}

Instant ValueEngine::poll(const Engine& engine, Instant now) {
    if (now >= next_health_) {
        update_health(engine, now);
        update_channels(engine, now);
        next_health_ = now + HealthWatch::kPeriod;
    }
    Instant next = next_health_;
    ran_.clear();
    for (std::size_t bus = 0; bus < roles_.size(); ++bus) {
        if (roles_[bus]->due() <= now) {
            transmissions_[bus] = Transmission(roles_[bus]->run(now, board_));
            if (!transmissions_[bus].empty()) {
                ran_.push_back(bus);
            }
        }
        next = std::min(next, roles_[bus]->due());
    }
    return next;
}

SensorBusState ValueEngine::bus_state(std::size_t bus) const {
    SensorBusState state;
    if (const auto* sensor = std::get_if<std::unique_ptr<SensorRole>>(&buses_[bus])) {
        state.sensor = (*sensor)->counts();
        state.echo = (*sensor)->echo();
        state.first_address = (*sensor)->first_address().value_or(0);
        state.latest_request = (*sensor)->latest_request();
        return state;
    }
    const ReceiverRole& receiver = *std::get<std::unique_ptr<ReceiverRole>>(buses_[bus]);
    state.is_receiver = true;
    state.receiver = receiver.counts();
    state.echo = receiver.echo();
    std::ranges::copy(receiver.found(), state.found.begin());
    state.found_count = receiver.found().size();
    state.faults = receiver.faults();
    return state;
}

}  // namespace tribus
