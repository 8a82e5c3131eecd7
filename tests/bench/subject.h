#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "tests/bench/lane.h"
#include "tests/bench/process.h"
#include "tests/bench/relay.h"

namespace tribus::bench {

/// How `tribus run` is configured to carry frames.
struct ApplianceSettings {
    std::string program = "/proc/self/exe";
    Carries carries = Carries::same;
    /// Least time between two frames of an output. Long enough that `follow` waits for the next
    /// frame instead of repeating the last one; short enough that a late frame seldom delays the
    /// next.
    Duration period = std::chrono::milliseconds(5);
    std::optional<int> priority;  ///< real-time priority; empty: none
    std::optional<int> cpu;
    std::size_t outputs_per_input = 1;  ///< outputs after the first are only drained
    std::vector<std::string> environment;
    /// Words before the program: another program that runs and watches it.
    std::vector<std::string> in_front{};
};

/// The table [runtime] of the configuration.
std::string runtime_text(const ApplianceSettings& settings);

/// Starts `tribus run` with this configuration text. The error is a sentence.
tl::expected<Process, std::string> run_configuration(const std::string& text,
                                                     const ApplianceSettings& settings);
/// Waits until `tribus run` reports its start. The error is its output otherwise.
tl::expected<void, std::string> wait_until_started(Process& process);

/// The configuration text for the devices of these lanes.
std::string configuration_text(const std::vector<Lane>& lanes, const ApplianceSettings& settings,
                               const std::vector<Pty>& further_outputs);

/// A process that carries frames along its lanes. It ends with its object. Thread-bound.
class Subject {
  public:
    /// The bare relay.
    static tl::expected<Subject, std::string> relay(std::size_t lanes,
                                                    const RelaySettings& settings);
    /// `tribus run`.
    static tl::expected<Subject, std::string> appliance(std::size_t lanes,
                                                        const ApplianceSettings& settings);
    /// Any other program, with one lane; {in} and {out} in a word stand for its devices.
    static tl::expected<Subject, std::string> command(const std::vector<std::string>& words);

    std::vector<Lane>& lanes() { return lanes_; }
    Lane& lane() { return lanes_.front(); }
    Process& process() { return process_; }
    std::optional<ProcessUsage> usage() const { return usage_of(process_.id()); }

    /// Sends on each lane, every 7 ms, until a frame has come out of every lane. The error says why
    /// that fails.
    tl::expected<void, std::string> wait_until_it_carries();

    /// Discards what came out of the outputs after the first.
    void drain_further_outputs();

    /// Frames that came out, that did not come out, and that came out broken.
    std::uint64_t arrived() const;
    std::uint64_t lost() const;
    std::uint64_t torn() const;

  private:
    Subject(std::vector<Lane> lanes, Process process, std::vector<Pty> further_outputs);

    std::vector<Lane> lanes_;
    std::vector<Pty> further_outputs_;
    Process process_;
};

/// Waits until frames come through. What it returns ends where the caller lets go of it; a
/// parameter would live until the caller's expression ends, beside the next subject.
tl::expected<Subject, std::string> carrying(tl::expected<Subject, std::string> started);

}  // namespace tribus::bench
