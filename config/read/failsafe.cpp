#include "config/read/failsafe.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "config/keys/keys.h"
#include "config/language/nearest.h"
#include "config/read/doubts.h"
#include "config/read/rules.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "transports/codecs/frame_encoder.h"

namespace tribus {
namespace {

/// Content of one failsafe table. Empty if there is no table.
struct Given {
    std::optional<TableContent> content;
    std::optional<ValueRule> release_when;
    std::optional<Presets> presets;
    Location preset_where;
    std::uint32_t preset_channels = 0;  ///< those that `preset` names, one bit each

    bool has(std::string_view key) const {
        return content && content->given(key) && content->sound(key);
    }
    bool has_mistaken(std::string_view key) const { return content && !content->sound(key); }
    bool has_mistaken_presets() const { return content && content->given("preset") && !presets; }
};

/// The channels that `preset` names, one bit each. A key that is no channel may mean any.
std::uint32_t named_in(const Value& preset) {
    const auto* table = preset.as<Table>();
    std::uint32_t channels = 0;
    for (const Entry& entry : table == nullptr ? std::vector<Entry>{} : table->entries) {
        const auto channel = channel_of(entry.key);
        channels |= channel ? 1U << *channel : kAllChannels;
    }
    return channels;
}

/// Presets are not limited: `min` and `max` are for what comes from the sticks.
void doubt_preset(std::size_t channel, Pulse preset, const ChannelRule& rule, Location where,
                  std::string_view whose, Mistakes& warnings) {
    if ((rule.min && preset < *rule.min) || (rule.max && preset > *rule.max)) {
        const auto limit = [](const std::optional<Pulse>& pulse) {
            return pulse ? format_number(pulse->microseconds()) : std::string("no limit");
        };
        warnings.add(where,
                     fmt::format("{} of channel {} is {} us, outside of its \"min\" and \"max\" "
                                 "({} to {}): presets are sent as they are; give a preset within "
                                 "them, or other limits",
                                 whose, channel + 1, format_number(preset.microseconds()),
                                 limit(rule.min), limit(rule.max)));
    }
}

void doubt_presets(const Value& value, const Presets& presets,
                   const std::vector<ChannelRule>& rules, Mistakes& warnings) {
    const Table& table = *value.as<Table>();
    for (const ChannelRule& rule : rules) {
        const Entry* own = table.find(std::to_string(rule.output + 1));
        const Entry* entry = own != nullptr ? own : table.find(kOtherChannels);
        doubt_preset(rule.output, presets[rule.output], rule,
                     entry != nullptr ? entry->value.where : value.where, "the preset", warnings);
    }
}

Given read_given(TableContent content, const std::vector<ChannelRule>& rules, Reading reading) {
    Given given;
    if (const Entry* release = content.find("release_when")) {
        given.release_when =
            read_value_rule({release->value, "\"release_when\"", "{ channel = 3, below = 1050 }",
                             "every value would release", release_rule_keys()},
                            reading);
        if (given.release_when) {
            doubt_rule(*given.release_when, RuleUse::release, "\"release_when\"",
                       reach_of(given.release_when->channel, rules), release->value.where,
                       reading.warnings);
        }
    }
    if (const Entry* preset = content.find("preset")) {
        given.presets = read_presets(preset->value, reading.mistakes);
        given.preset_where = preset->where;
        given.preset_channels = named_in(preset->value);
        if (given.presets) {
            doubt_presets(preset->value, *given.presets, rules, reading.warnings);
        }
    }
    const auto* slew = content.values().find_as<double>("slew");
    doubt_slew(slew == nullptr ? std::nullopt : std::optional(*slew), "slew", content.where("slew"),
               reading.warnings);
    given.content = std::move(content);
    return given;
}

std::vector<std::string_view> output_names(const PipelineConfig& pipeline, const Draft& draft) {
    std::vector<std::string_view> names;
    for (const std::size_t output : pipeline.outputs) {
        names.emplace_back(draft.outputs[output].config.name);
    }
    return names;
}

using GivenByOutput = std::map<std::string, Given, std::less<>>;

/// Reads all tables [pipeline.NAME.failsafe.output.NAME].
GivenByOutput read_outputs(const Value& value, const PipelineConfig& pipeline, const Draft& draft,
                           Reading reading) {
    GivenByOutput result;
    const std::string path = fmt::format("pipeline.{}.failsafe.output", pipeline.name);
    const auto* tables = value.as<Table>();
    if (tables == nullptr) {
        reading.mistakes.add(value.where,
                             fmt::format("[{}] is {}; allowed: a table for each output that "
                                         "differs, [{}.NAME]",
                                         path, describe(value), path));
        return result;
    }
    const auto names = output_names(pipeline, draft);
    for (const Entry& entry : tables->entries) {
        const bool known = std::find(names.begin(), names.end(), entry.key) != names.end();
        if (!known && !draft.outputs_uncertain && !reading.lost.mentions(entry.key)) {
            reading.mistakes.add(entry.where,
                                 fmt::format("[pipeline.{}] has no output {}; {}", pipeline.name,
                                             in_quotes(entry.key), suggestion(entry.key, names)));
        }
        const auto* table = entry.value.as<Table>();
        if (table == nullptr) {
            reading.mistakes.add(entry.value.where, fmt::format("{} in [{}] is {}; allowed: a "
                                                                "table, [{}.NAME]",
                                                                in_quotes(entry.key), path,
                                                                describe(entry.value), path));
            continue;
        }
        TableContent content =
            read_table({*table, entry.value.where, fmt::format("[{}.{}]", path, entry.key)},
                       output_failsafe_keys(), reading);
        result.emplace(entry.key, read_given(std::move(content), pipeline.channels, reading));
    }
    return result;
}

/// Whether it cannot, as far as the settings can be read.
bool cannot_say_failsafe(const OutputDraft& draft) {
    const OutputConfig& output = draft.config;
    return draft.settings_sound && !output.protocol->signals_failsafe(output.settings);
}

FailsafeSettings combine(const Given& own, const Given& shared, const OutputDraft& output) {
    FailsafeSettings settings;
    settings.action =
        cannot_say_failsafe(output) ? FailsafeAction::silence : FailsafeAction::preset;
    settings.presets = default_presets();
    for (const Given* given : {&shared, &own}) {
        if (given->content) {
            given->content->read_given_into(settings);
        }
        if (given->release_when) {
            settings.release_when = given->release_when;
        }
        settings.presets = given->presets.value_or(settings.presets);
    }
    if (!own.has("power_on") && !shared.has("power_on")) {
        settings.power_on = settings.recover;
    }
    return settings;
}

/// Held values that nothing marks are old values that look fresh.
void check_hold_time(const FailsafeSettings& settings, const Given& given, const OutputDraft& draft,
                     Mistakes& mistakes) {
    constexpr Duration kMostUnmarked = FailsafeSettings{}.hold;
    const OutputConfig& output = draft.config;
    if (settings.hold <= kMostUnmarked || !given.has("hold") || output.force ||
        !draft.settings_sound) {
        return;
    }
    const FrameEncoder encoder(output.protocol->make_encoder(output.settings));
    if (!encoder.encoder().marks_frame_lost()) {
        mistakes.add(given.content->where("hold"),
                     fmt::format("\"hold\" is {}, but {} of output {} cannot mark held values: "
                                 "for so long its receiver takes old values for fresh ones; "
                                 "allowed there: at most {}, or add force = true to [output.{}]",
                                 in_quotes(format_duration(settings.hold)),
                                 in_quotes(output.protocol->name), in_quotes(output.name),
                                 in_quotes(format_duration(kMostUnmarked)), output.name));
    }
}

std::size_t lowest_in(std::uint32_t channels) {
    return static_cast<std::size_t>(std::countr_zero(channels));
}

/// Some receivers move with the default presets.
void check_written_presets(const FailsafeSettings& settings, std::uint32_t written, Location where,
                           const OutputDraft& draft, Mistakes& mistakes) {
    const OutputConfig& output = draft.config;
    if (settings.action != FailsafeAction::preset || !draft.settings_sound ||
        output.protocol->moves_by_default == nullptr) {
        return;
    }
    const auto risk = output.protocol->moves_by_default(output.settings);
    if (!risk) {
        return;
    }
    std::uint32_t open = risk->channels & ~written;
    while (open != 0 && settings.presets[lowest_in(open)] == risk->standstill) {
        open &= open - 1;
    }
    if (open == 0) {
        return;
    }
    const std::size_t channel = lowest_in(open);
    // One motor among channels of other kinds must not give them its standstill.
    const std::string which =
        std::popcount(risk->channels) == 1
            ? fmt::format("{} = {}, other = 1500", channel + 1,
                          format_number(risk->standstill.microseconds()))
            : fmt::format("other = {}", format_number(risk->standstill.microseconds()));
    mistakes.add(where,
                 fmt::format("\"action\" is \"preset\", but the preset of channel {} is not "
                             "written: output {} drives motors, and they would get the default, "
                             "{} us, where {} us is standstill; write a preset for each of them, "
                             "such as preset = {{ {} }}, or leave \"action\" out",
                             channel + 1, in_quotes(output.name),
                             format_number(settings.presets[channel].microseconds()),
                             format_number(risk->standstill.microseconds()), which));
}

/// The default presets of an output that sends them, against the limits of its channels.
void doubt_default_presets(const FailsafeSettings& settings, const PipelineConfig& pipeline,
                           Mistakes& warnings) {
    for (std::size_t i = 0; i < pipeline.channels.size(); ++i) {
        const std::size_t channel = pipeline.channels[i].output;
        doubt_preset(channel, settings.presets[channel], pipeline.channels[i],
                     pipeline.channels_where[i], "the default preset", warnings);
    }
}

/// Rule: an output is silent or says failsafe; it never repeats old values without a mark.
void check_hold(const FailsafeSettings& settings, const Given& given, const OutputDraft& draft,
                Mistakes& mistakes) {
    if (settings.action == FailsafeAction::hold && cannot_say_failsafe(draft)) {
        const OutputConfig& output = draft.config;
        mistakes.add(given.content->where("action"),
                     fmt::format("\"action\" is \"hold\", but {} of output {} cannot say failsafe: "
                                 "it would repeat old values unmarked; allowed there: \"preset\", "
                                 "\"silence\"",
                                 in_quotes(output.protocol->name), in_quotes(output.name)));
    }
}

/// Reports presets that are written down but never sent, because the default action of the output
/// is silence.
void check_presets(const Given& given, bool used, Mistakes& mistakes) {
    if (given.presets && !used) {
        mistakes.add(given.preset_where,
                     "\"preset\" is not sent in failsafe: without \"action\", an output whose "
                     "protocol cannot say failsafe goes silent; add action = \"preset\", or action "
                     "= \"silence\" if \"preset\" is only for channels that the input lacks");
    }
}

}  // namespace

std::vector<FailsafeSettings> read_failsafe(const Entry* entry, const PipelineConfig& pipeline,
                                            const Draft& draft, Reading reading) {
    Given shared;
    GivenByOutput own;
    const auto* table = entry == nullptr ? nullptr : entry->value.as<Table>();
    const std::string title = fmt::format("[pipeline.{}.failsafe]", pipeline.name);
    if (table != nullptr) {
        shared =
            read_given(read_table({*table, entry->value.where, title}, failsafe_keys(), reading),
                       pipeline.channels, reading);
        if (const Entry* outputs = shared.content->find("output")) {
            own = read_outputs(outputs->value, pipeline, draft, reading);
        }
    } else if (entry != nullptr) {
        reading.mistakes.add(entry->value.where, fmt::format("{} is {}; allowed: a table", title,
                                                             describe(entry->value)));
    }
    std::vector<FailsafeSettings> result;
    bool doubted_defaults = false;
    // Without certainty, no mistake is reported.
    bool shared_used = shared.has("action") || shared.has_mistaken("action") ||
                       draft.outputs_uncertain || pipeline.outputs.empty();
    for (const std::size_t index : pipeline.outputs) {
        const OutputDraft& output = draft.outputs[index];
        const Given& mine = own[output.config.name];
        result.push_back(combine(mine, shared, output));
        const Given& acting = mine.has("action") ? mine : shared;
        check_hold(result.back(), acting, output, reading.mistakes);
        check_hold_time(result.back(), mine.has("hold") ? mine : shared, output, reading.mistakes);
        if (!mine.has_mistaken_presets() && !shared.has_mistaken_presets()) {
            check_written_presets(
                result.back(), mine.presets ? mine.preset_channels : shared.preset_channels,
                acting.has("action") ? acting.content->where("action") : output.where, output,
                reading.mistakes);
        }
        if (result.back().action == FailsafeAction::preset && !mine.presets && !shared.presets &&
            !std::exchange(doubted_defaults, true)) {
            doubt_default_presets(result.back(), pipeline, reading.warnings);
        }
        const bool presets_used = mine.has("action") || mine.has_mistaken("action") ||
                                  shared.has("action") || !cannot_say_failsafe(output);
        check_presets(mine, presets_used, reading.mistakes);
        shared_used = shared_used || (presets_used && !mine.presets);
    }
    check_presets(shared, shared_used, reading.mistakes);
    return result;
}

}  // namespace tribus
