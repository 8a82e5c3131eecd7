#include "app/web/recordings/plot_states.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <vector>

#include "app/state_text/cause_text.h"
#include "config/build/build.h"
#include "config/language/key_file.h"
#include "core/link_cause.h"
#include "pipelines/virtual_time/virtual_loop.h"

namespace tribus::web {
namespace {

/// For what the judgement of an input needs besides its timeout.
constexpr Duration kSettling = std::chrono::milliseconds(200);

/// An output that hears of no good input for so long is in failsafe.
Duration settling_time(const Configuration& configuration, std::size_t output) {
    Duration longest{};
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        const auto found = std::ranges::find(pipeline.outputs, output);
        if (found == pipeline.outputs.end()) {
            continue;
        }
        const auto place = static_cast<std::size_t>(found - pipeline.outputs.begin());
        longest = std::max(longest, pipeline.failsafe[place].hold);
    }
    Duration timeout{};
    for (const InputConfig& input : configuration.inputs) {
        timeout = std::max(timeout, input.supervision.timeout);
    }
    return longest + timeout + kSettling;
}

std::vector<bool> inputs_without_their_key(const Configuration& configuration) {
    std::vector<bool> without;
    for (const InputConfig& input : configuration.inputs) {
        without.push_back(are_secrets_forbidden() &&
                          std::ranges::any_of(input.settings, [](const auto& setting) {
                              return std::holds_alternative<KeyFile>(setting.second);
                          }));
    }
    return without;
}

/// Notes the states of the outputs of pipelines. The engine begins in failsafe, whatever the real
/// one did before the recording: an output is known from its first control on, or when no input was
/// good for so long that it must be in failsafe.
class StateWatch final : public StationObserver {
  public:
    StateWatch(const Engine& engine, const Configuration& configuration, RecordingPlot& plot)
        : engine_(engine),
          plot_(plot),
          was_good_(engine.inputs().size()),
          known_(engine.outputs().size()),
          has_no_key_(inputs_without_their_key(configuration)) {
        for (std::size_t i = 0; i < engine.outputs().size(); ++i) {
            known_from_.push_back(Instant{} + settling_time(configuration, i));
            plot.states.push_back({engine.outputs()[i].name(), PlotStates(plot.span)});
            look(i, Instant{});
        }
    }

    void wrote(Station /*station*/, Instant /*at*/, const Transmission& /*sent*/) override {}
    void polled(Instant at) override {
        for (std::size_t i = 0; i < was_good_.size(); ++i) {
            was_good_[i] = was_good_[i] || engine_.inputs()[i].state().cause == LinkCause::good;
        }
        for (const std::size_t output : engine_.ran()) {
            look(output, at);
        }
    }
    void finish(Instant at) {
        for (PlottedStates& output : plot_.states) {
            output.states.finish(at.time_since_epoch());
        }
    }

  private:
    void look(std::size_t index, Instant at) {
        const Output& output = engine_.outputs()[index];
        if (output.inputs().empty()) {
            return;
        }
        // Its frames do not count here, whatever they were to the daemon.
        const bool unproved = std::ranges::any_of(
            output.inputs(), [this](std::size_t input) { return has_no_key_[input]; });
        const bool heard = std::ranges::any_of(
            output.inputs(), [this](std::size_t input) { return was_good_[input]; });
        known_[index] = known_[index] || output.stage() == OutputStage::control ||
                        (!heard && at >= known_from_[index]);
        plot_.states[index].states.set(at.time_since_epoch(),
                                       known_[index] && !unproved
                                           ? output_state_word(output.stage(), output.sends())
                                           : "unknown");
    }

    const Engine& engine_;
    RecordingPlot& plot_;
    std::vector<bool> was_good_;
    std::vector<bool> known_;
    std::vector<bool> has_no_key_;  ///< by input
    std::vector<Instant> known_from_;
};

}  // namespace

std::optional<std::string> simulate_states(const Configuration& configuration,
                                           std::span<const SimulatedSource> sources,
                                           const std::map<std::size_t, std::string>& files,
                                           RecordingPlot& plot) {
    auto arrivals = Arrivals::open(files, sources);
    if (!arrivals) {
        return arrivals.error();
    }
    const auto engine = build_engine(configuration);
    const auto values = build_value_engine(configuration, *engine);
    StateWatch watch(*engine, configuration, plot);
    VirtualLoop loop(*engine, watch, Instant{}, values.get());
    const Instant end(plot.span.to);
    auto arrival = arrivals->next();
    for (; arrival && *arrival != nullptr && (*arrival)->at < end; arrival = arrivals->next()) {
        arrive(loop, sources[(*arrival)->source], **arrival);
    }
    if (arrival) {
        loop.run_until(end);
    }
    watch.finish(loop.now());
    return arrival ? std::nullopt : std::optional(arrival.error());
}

}  // namespace tribus::web
