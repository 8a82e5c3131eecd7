#include "tests/sim/reload_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/sim/simulation.h"

namespace tribus::test {

std::unique_ptr<ReloadRun::Stage> ReloadRun::stage_of(const std::string& text) {
    auto stage = std::make_unique<Stage>();
    stage->configuration = configuration_of(text);
    stage->engine = build_engine(stage->configuration);
    stage->values = build_value_engine(stage->configuration, *stage->engine);
    return stage;
}

ReloadRun::ReloadRun(const std::string& text)
    : stage_(stage_of(text)),
      loop_(
          std::make_unique<VirtualLoop>(*stage_->engine, *this, Instant{}, stage_->values.get())) {}

std::size_t ReloadRun::input_index(const std::string& name) const {
    const auto& inputs = stage_->configuration.inputs;
    const auto found = std::ranges::find(inputs, name, &InputConfig::name);
    EXPECT_NE(found, inputs.end()) << name;
    return static_cast<std::size_t>(found - inputs.begin());
}

void ReloadRun::receive(const std::string& input, std::span<const std::uint8_t> bytes, Instant at) {
    loop_->receive(input_station(input_index(input)), bytes, at);
}

void ReloadRun::receive(const std::string& input, const CanFrame& frame, Instant at) {
    loop_->receive(input_station(input_index(input)), frame, at);
}

void ReloadRun::reload(const std::string& text, Instant at) {
    auto next = stage_of(text);
    const CarryOver plan = plan_carry_over(stage_->configuration, next->configuration);
    EXPECT_TRUE(plan.obstacles.empty()) << plan.obstacles.front();
    if (!plan.leaving.empty()) {
        at = loop_->retire(plan.leaving, at);
    }
    loop_->run_until(at);
    {
        const HeapTrap trap;
        next->engine->start(at);
        next->engine->continue_from(*stage_->engine, plan.engine, at);
        if (next->values && stage_->values) {
            next->values->start(at);
            next->values->continue_from(*stage_->values, plan.values, plan.engine);
        }
        allocations_ += trap.allocations();
    }
    std::swap(stage_, next);
    loop_->go_on_with(*stage_->engine, stage_->values.get(), at);
}

void ReloadRun::wrote(Station station, Instant at, const Transmission& sent) {
    const Configuration& configuration = stage_->configuration;
    const std::string name =
        station.kind == StationKind::output       ? configuration.outputs[station.index].name
        : station.kind == StationKind::sensor_bus ? configuration.sensor_buses[station.index].name
                                                  : "node " + std::to_string(station.index);
    said_[name].push_back({at,
                           {sent.bytes().begin(), sent.bytes().end()},
                           {sent.can_frames().begin(), sent.can_frames().end()}});
}

std::size_t ReloadRun::bus_index(const std::string& name) const {
    const auto& buses = stage_->configuration.sensor_buses;
    const auto found = std::ranges::find(buses, name, &SensorBusConfig::name);
    EXPECT_NE(found, buses.end()) << name;
    return static_cast<std::size_t>(found - buses.begin());
}

void ReloadRun::receive_on_bus(const std::string& bus, std::span<const std::uint8_t> bytes,
                               Instant at) {
    loop_->receive({StationKind::sensor_bus, bus_index(bus)}, bytes, at);
}

SensorBusState ReloadRun::bus_state(const std::string& bus) const {
    return stage_->values->bus_state(bus_index(bus));
}

std::optional<double> ReloadRun::value(const std::string& name, Instant now) const {
    const ValueBoard& board = stage_->values->board();
    const auto index = board.find(name);
    EXPECT_TRUE(index) << name;
    return index ? board.fresh(*index, now) : std::nullopt;
}

const Input& ReloadRun::input(const std::string& name) const {
    return stage_->engine->inputs()[input_index(name)];
}

const Output& ReloadRun::output(const std::string& name) const {
    const auto outputs = stage_->engine->outputs();
    return *std::ranges::find(outputs, name, &Output::name);
}

}  // namespace tribus::test
