#include "config/check/absent_channels.h"

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "core/channel_frame.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// The channels that a rule reads, one bit each.
std::uint32_t read_by(const ChannelSource& source) {
    if (const auto* from = std::get_if<FromChannel>(&source)) {
        return 1U << from->channel;
    }
    if (const auto* on = std::get_if<Switch>(&source)) {
        return 1U << on->channel;
    }
    std::uint32_t channels = 0;
    if (const auto* mix = std::get_if<Mix>(&source)) {
        for (const MixTerm& term : mix->terms) {
            channels |= 1U << term.channel;
        }
    }
    return channels;
}

/// The channels that every good frame of the protocol has.
std::uint32_t received(const InputConfig& input) {
    const auto sure = input.protocol->sure_channels;
    return sure == nullptr ? kAllChannels : sure(input.settings).value_or(kAllChannels);
}

/// The channels that every good frame has after the input's own map.
std::uint32_t given(const InputConfig& input) {
    const std::uint32_t came = received(input);
    std::uint32_t channels = came;
    for (const ChannelRule& rule : input.channels) {
        const std::uint32_t bit = 1U << rule.output;
        channels = (read_by(rule.source) & ~came) == 0 ? channels | bit : channels & ~bit;
    }
    return channels;
}

/// `sure`: the channels that `input` certainly has.
void look_at(const std::vector<ChannelRule>& rules, const std::vector<Location>& places,
             const InputConfig& input, std::uint32_t sure, Mistakes& remarks) {
    for (std::size_t i = 0; i < rules.size(); ++i) {
        const std::uint32_t unsure = read_by(rules[i].source) & ~sure;
        if (unsure != 0) {
            remarks.add(
                places[i],
                fmt::format(
                    "channel {} is made from channel {}, which input {} ({}) may lack; while it is "
                    "absent, an output whose format cannot mark absent channels sends its preset",
                    rules[i].output + 1, std::countr_zero(unsure) + 1, in_quotes(input.name),
                    input.protocol->name));
        }
    }
}

}  // namespace

std::vector<Mistake> maps_of_absent_channels(const Configuration& configuration) {
    Mistakes remarks(configuration.file);
    for (const InputConfig& input : configuration.inputs) {
        look_at(input.channels, input.channels_where, input, received(input), remarks);
    }
    for (const PipelineConfig& pipeline : configuration.pipelines) {
        for (const std::size_t index : pipeline.selection.inputs) {
            const InputConfig& input = configuration.inputs[index];
            look_at(pipeline.channels, pipeline.channels_where, input, given(input), remarks);
        }
    }
    return remarks.sorted();
}

}  // namespace tribus
