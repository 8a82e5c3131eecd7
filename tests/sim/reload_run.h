#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "pipelines/virtual_time/virtual_loop.h"
#include "tests/support/heap_trap.h"

namespace tribus::test {

/// Frame that an output wrote, and when.
struct Said {
    Instant at;
    std::vector<std::uint8_t> bytes;
    std::vector<CanFrame> frames;

    bool operator==(const Said&) const = default;
};

/// Runs one configuration after another under virtual time. Inputs and outputs are addressed by
/// their names in the configuration that runs.
class ReloadRun final : public StationObserver {
  public:
    explicit ReloadRun(const std::string& text);

    void receive(const std::string& input, std::span<const std::uint8_t> bytes, Instant at);
    void receive(const std::string& input, const CanFrame& frame, Instant at);
    /// Replaces the running configuration by `text` as the program does: removed outputs write
    /// their last frames first.
    void reload(const std::string& text, Instant at);
    void run_until(Instant at) { loop_->run_until(at); }

    const std::vector<Said>& said(const std::string& output) { return said_[output]; }
    const Input& input(const std::string& name) const;
    const Output& output(const std::string& name) const;
    /// Heap allocations in all reloads so far.
    std::uint64_t allocations() const { return allocations_; }

    /// A node has the name "node 0", and so on, by its place.
    void wrote(Station station, Instant at, const Transmission& sent) override;
    void receive_on_bus(const std::string& bus, std::span<const std::uint8_t> bytes, Instant at);
    SensorBusState bus_state(const std::string& bus) const;
    std::optional<double> value(const std::string& name, Instant now) const;

  private:
    struct Stage {
        Configuration configuration;
        std::unique_ptr<ValueEngine> values;
        std::unique_ptr<Engine> engine;
    };
    static std::unique_ptr<Stage> stage_of(const std::string& text);
    std::size_t input_index(const std::string& name) const;
    std::size_t bus_index(const std::string& name) const;

    std::unique_ptr<Stage> stage_;
    std::map<std::string, std::vector<Said>> said_;
    std::unique_ptr<VirtualLoop> loop_;
    std::uint64_t allocations_ = 0;
};

}  // namespace tribus::test
