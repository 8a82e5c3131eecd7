#include "pipelines/engine/health_watch.h"

#include <algorithm>
#include <chrono>

namespace tribus {
namespace {

double in_seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

/// The link quality of a frame, or of statistics, that is older than this is unknown.
constexpr Duration kQualityLasts = std::chrono::seconds(1);

std::optional<double> link_quality(const Input& input, Instant now) {
    const ChannelFrame& latest = input.latest();
    const bool known =
        latest.link_quality != kNoLinkQuality && now - latest.received <= kQualityLasts;
    return known ? std::optional<double>(latest.link_quality) : std::nullopt;
}

/// A number of the latest statistics of the radio link. The statistics must not be too old.
template <class Number>
std::optional<double> radio_number(const Input& input,
                                   std::optional<Number> RadioStatistics::*number, Instant now) {
    const RadioStatistics* statistics = input.decoder().radio_statistics();
    const bool known = statistics != nullptr && (statistics->*number).has_value() &&
                       now - statistics->received <= kQualityLasts;
    return known ? std::optional<double>(*(statistics->*number)) : std::nullopt;
}

double yes_or_no(bool yes) {
    return yes ? 1 : 0;
}

}  // namespace

HealthWatch::HealthWatch(std::size_t inputs, std::size_t outputs)
    : inputs_(inputs), outputs_(outputs) {}

void HealthWatch::continue_from(const HealthWatch& before, const EngineCarry& carry) {
    const auto take = [](auto& looks, const auto& looks_before, const auto& carried) {
        for (std::size_t i = 0; i < looks.size(); ++i) {
            if (carried[i].from && *carried[i].from < looks_before.size()) {
                looks[i] = looks_before[*carried[i].from];
            }
        }
    };
    take(inputs_, before.inputs_, carry.inputs);
    take(outputs_, before.outputs_, carry.outputs);
    looked_at_ = before.looked_at_;
    looks_ = before.looks_;
}

void HealthWatch::look(const Engine& engine, Instant now) {
    const std::size_t place = place_of(looks_++);
    looked_at_[place] = now;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
        const InputCounts& counts = engine.inputs()[i].counts();
        inputs_[i][place] = {.frames = counts.frames,
                             .lost = counts.frame_lost_frames + counts.failsafe_frames};
    }
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        outputs_[i][place] = {.frames = engine.outputs()[i].counts().frames};
    }
}

const HealthWatch::Counts& HealthWatch::newest(const Looks& looks) const {
    return looks[place_of(looks_ - 1)];
}

const HealthWatch::Counts& HealthWatch::oldest(const Looks& looks) const {
    return looks[looks_ < kLooks ? 0 : place_of(looks_)];
}

Duration HealthWatch::watched() const {
    return looks_ < 2 ? Duration::zero()
                      : looked_at_[place_of(looks_ - 1)] -
                            looked_at_[looks_ < kLooks ? 0 : place_of(looks_)];
}

double HealthWatch::rate(const Looks& looks) const {
    return static_cast<double>(newest(looks).frames - oldest(looks).frames) / in_seconds(watched());
}

/// Share of the frames expected at the input's interval that did not come or were marked as lost.
double HealthWatch::loss_ratio(const Engine& engine, std::size_t input) const {
    const Looks& looks = inputs_[input];
    const auto frames = static_cast<double>(newest(looks).frames - oldest(looks).frames);
    const auto lost = static_cast<double>(newest(looks).lost - oldest(looks).lost);
    const Duration interval = engine.inputs()[input].arrivals().interval();
    const double due =
        interval > Duration::zero() ? in_seconds(watched()) / in_seconds(interval) : frames;
    // One frame more or less in a second is normal.
    const double expected = due - frames > 1 ? due : frames;
    const double good = std::max(frames - lost, 0.0);
    return expected > 0 ? 100 * (1 - good / expected) : 100;
}

std::optional<double> HealthWatch::number(const Engine& engine, std::size_t input, InputFact fact,
                                          Instant now) const {
    const Input& source = engine.inputs()[input];
    const bool nothing_counted = watched() == Duration::zero();
    switch (fact) {
        case InputFact::frame_rate:
            return nothing_counted ? std::nullopt : std::optional(rate(inputs_[input]));
        case InputFact::loss_ratio:
            return nothing_counted || !source.link().ever_good()
                       ? std::nullopt
                       : std::optional(loss_ratio(engine, input));
        case InputFact::age:
            return source.link().ever_good()
                       ? std::optional(1000 * in_seconds(now - source.control().received))
                       : std::nullopt;
        case InputFact::good:
            return yes_or_no(engine.input_state(input, now).cause == LinkCause::good);
        case InputFact::cause:
            return static_cast<double>(engine.input_state(input, now).cause);
        case InputFact::link_quality:
            return link_quality(source, now);
        case InputFact::rssi:
            return radio_number(source, &RadioStatistics::rssi_dbm, now);
        case InputFact::snr:
            return radio_number(source, &RadioStatistics::snr_db, now);
        case InputFact::power:
            return radio_number(source, &RadioStatistics::power_mw, now);
        case InputFact::mode:
            return radio_number(source, &RadioStatistics::mode, now);
    }
    return std::nullopt;
}

std::optional<double> HealthWatch::number(const Engine& engine, std::size_t output, OutputFact fact,
                                          Instant /*now*/) const {
    const OutputStage stage = engine.outputs()[output].stage();
    switch (fact) {
        case OutputFact::frame_rate:
            return watched() == Duration::zero() ? std::nullopt
                                                 : std::optional(rate(outputs_[output]));
        case OutputFact::failsafe:
            return yes_or_no(stage == OutputStage::failsafe || stage == OutputStage::cannot_send);
        case OutputFact::holding:
            return yes_or_no(stage == OutputStage::holding);
        case OutputFact::cannot_send:
            return yes_or_no(stage == OutputStage::cannot_send);
    }
    return std::nullopt;
}

}  // namespace tribus
