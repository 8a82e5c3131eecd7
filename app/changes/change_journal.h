#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/appliance/appliance.h"
#include "app/changes/told_change.h"
#include "app/state_text/wait_text.h"
#include "config/build/carry_over.h"
#include "core/time.h"

namespace tribus {

/// The latest changes of state of all parts, each once and with its sentence: log, sockets and
/// recorder read them by their number. Changes of inputs, outputs, CAN interfaces and DroneCAN
/// nodes are those that the data thread wrote at their moment; a value remembers how long it was
/// stale. Thread-bound to the main thread.
class ChangeJournal {
  public:
    /// So many are kept.
    static constexpr std::size_t kChanges = 1024;

    /// From now on it follows `appliance`, which has just started. What the start itself told of
    /// missing devices is no change.
    void begin(const Appliance& appliance, Instant now, Duration wall_now);
    /// An appliance has replaced the one before between two frames: takes the last changes of that
    /// one. Then call `go_on_with`.
    void take_the_last_before(const Appliance& appliance, Instant now, Duration wall_now) {
        take(appliance.changes(), appliance.changes_before(), nullptr, {now, wall_now});
    }
    void go_on_with(const Appliance& appliance, const CarryOver& carry_over, Instant now,
                    Duration wall_now);

    /// Takes the changes since the last call. Call it a few times a second, and before somebody is
    /// told the newest number.
    void look(const Appliance& appliance, Instant now, Duration wall_now);
    /// Takes changes of devices.
    void add(std::span<const Appliance::DeviceEvent> events, Instant now, Duration wall_now);
    /// Gives the change its number.
    void add(ToldChange change);

    /// Number of the newest change. 0: there was none.
    std::uint64_t newest() const { return newest_; }
    /// Number of the oldest one that is kept, or of the next one.
    std::uint64_t oldest() const { return newest_ - changes_.size() + 1; }
    /// At most `most` changes after that number, the oldest first.
    std::vector<ToldChange> since(std::uint64_t number, std::size_t most = kChanges) const;

  private:
    struct OutputMemory {
        WaitWatch wait{};
        std::string wait_key{};
        std::string waits_for{};
        std::string text{};
        std::string input{};   ///< in control
        bool changed = false;  ///< since the last look at what it waits for
        bool waits = true;     ///< it may wait for something
    };
    struct ValueMemory {
        std::size_t index = 0;
        std::string name{};
        Duration lasts{};
        std::uint64_t gaps = 0;
        std::optional<bool> fresh{};  ///< as told; nothing: it had no number yet
    };
    struct Wall {
        Instant now;
        Duration wall_now;

        Duration at(Instant instant) const { return wall_now - (now - instant); }
    };

    void take_names(const Appliance& appliance);
    void take_values(const Appliance& appliance);
    void take(const ChangeRing& ring, std::uint64_t newest, const Appliance* appliance, Wall wall);
    void add(const Change& change, const Appliance* appliance, Wall wall);
    void add_input(const Change& change, const Appliance* appliance, Wall wall);
    void add_output(const Change& change, const Appliance* appliance, Wall wall);
    void look_at_waits(const Appliance& appliance, Wall wall);
    void look_at_values(const Appliance& appliance, Wall wall);
    void compare_buses_and_nodes(const Appliance& appliance, Wall wall);
    void tell_value(ValueMemory& memory, bool fresh, Instant at, Wall wall);
    ToldChange of_bus(std::size_t port, CanBusState state) const;
    ToldChange of_node(std::size_t node, const dronecan::NodeState& state) const;
    ToldChange of_output(std::size_t output, Instant at, const OutputState& state, bool sends,
                         Wall wall) const;
    std::string text_of(const Change& change, const Appliance* appliance) const;
    void tell_renamed(std::size_t output, const std::string& was, const OutputStatus& status,
                      Wall wall);
    void tell_restarted(Wall wall);
    void tell_lost(Instant at, Wall wall);
    std::string word_before(const ToldChange& change);
    std::string votes_text(std::size_t output, std::uint32_t before, std::uint32_t now) const;
    void note(ToldChange change, Instant at, Wall wall);

    std::vector<std::string> input_names_;
    std::vector<std::string> output_names_;
    /// Indices of the inputs of each output.
    std::vector<std::vector<std::size_t>> inputs_of_;
    std::vector<OutputMemory> outputs_;
    /// Devices of the ports.
    std::vector<std::string> ports_;
    /// Interface and configured id of each DroneCAN node.
    std::vector<std::pair<std::string, int>> nodes_;
    /// Values that are no facts of inputs and outputs, which are told anyway.
    std::vector<ValueMemory> values_;
    /// The latest word of each other part.
    std::map<std::pair<std::string_view, std::string>, std::string> words_;
    /// Names of devices that have not been there yet.
    std::set<std::string> never_there_;
    std::uint64_t taken_ = 0;  ///< number of the newest change taken from the data thread
    std::uint64_t lost_ = 0;   ///< changes that came too fast, and were not told yet
    std::uint64_t newest_ = 0;
    std::deque<ToldChange> changes_;
};

}  // namespace tribus
