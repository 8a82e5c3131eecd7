#include "config/check/lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <variant>

#include "config/schema/notation.h"
#include "core/quotes.h"
#include "pipelines/engine/output.h"
#include "pipelines/rules/line_words.h"

namespace tribus {
namespace {

/// Compares names only. Whether a number and a name are the same line is known to the chip alone.
bool same_line(const GpioPlace& a, const GpioPlace& b) {
    const bool by_name = std::holds_alternative<std::string>(a.line);
    const bool any_chip = by_name && (a.chip.empty() || b.chip.empty());
    return a.line == b.line && (any_chip || chip_path(a) == chip_path(b));
}

void check_places(const Draft& draft, Mistakes& mistakes) {
    for (const LineDraft& line : draft.lines) {
        for (const LineDraft& other : draft.lines) {
            if (&other == &line) {
                break;
            }
            // A place that could not be read is like no other.
            if (line.place_sound && same_line(line.config.place, other.config.place)) {
                mistakes.add(line.config.where,
                             fmt::format("line {} is already used by [{}.{}] in line {} of the "
                                         "file; a line has one role",
                                         in_quotes(to_text(line.config.place)),
                                         other.config.of_output ? "output" : "gpio",
                                         other.config.name, other.config.where.line));
                break;
            }
        }
    }
}

/// Each half of the wave needs a frame.
void check_period(const LineDraft& line, const Draft& draft, Mistakes& mistakes) {
    const OutputDraft* slowest = nullptr;
    for (const std::size_t index : line.config.task.outputs) {
        const OutputDraft& output = draft.outputs[index];
        if (!output.period_sound || !output.port_sound || !output.settings_sound) {
            return;
        }
        if (slowest == nullptr || output.config.schedule.period > slowest->config.schedule.period) {
            slowest = &output;
        }
    }
    if (slowest == nullptr || !line.period_sound ||
        line.config.task.period >= 2 * slowest->config.schedule.period) {
        return;
    }
    const Duration period = slowest->config.schedule.period;
    mistakes.add(
        line.period.value_or(line.where),
        fmt::format(
            "the period of the wave of line {} is {}{}, but output {} sends every {}: some half "
            "periods of the wave would have no frame; allowed: at least {}, recommended: {}",
            in_quotes(line.config.name), in_quotes(format_duration(line.config.task.period)),
            line.period ? "" : " by default", in_quotes(slowest->config.name),
            in_quotes(format_duration(period)), in_quotes(format_duration(2 * period)),
            in_quotes(format_duration(4 * period))));
}

void check_button(std::size_t index, const Draft& draft, Reading reading) {
    const LineDraft& line = draft.lines[index];
    const bool used = std::ranges::any_of(draft.pipelines, [&](const PipelineConfig& pipeline) {
        return std::ranges::any_of(pipeline.channels, [&](const ChannelRule& rule) {
            const auto* from = std::get_if<FromLine>(&rule.source);
            return from != nullptr && from->line == index;
        });
    });
    if (!used && !draft.channels_uncertain && !reading.lost.mentions(line.config.name)) {
        reading.mistakes.add(
            line.where,
            fmt::format("no channel is made from button {}, so it would have no effect; name it in "
                        "[pipeline.NAME.channels], such as 12 = {{ line = {} }}, or leave it out",
                        in_quotes(line.config.name), in_quotes(line.config.name)));
    }
}

void check_select(const LineDraft& line, const Draft& draft, Mistakes& mistakes) {
    const std::size_t input = line.config.task.input;
    const bool chooses = std::ranges::any_of(draft.pipelines, [&](const PipelineConfig& pipeline) {
        const auto& inputs = pipeline.selection.inputs;
        return inputs.size() > 1 && std::ranges::find(inputs, input) != inputs.end();
    });
    if (input != kNoInput && !chooses && !draft.inputs_uncertain) {
        mistakes.add(
            line.where,
            fmt::format(
                "line {} selects input {}, but no pipeline has that input and a second one to "
                "select from; name further inputs in its \"from\", or leave the line out",
                in_quotes(line.config.name), in_quotes(draft.inputs[input].config.name)));
    }
}

}  // namespace

void check_lines(const Draft& draft, Reading reading) {
    if (draft.lines.size() > kMostLines) {
        reading.mistakes.add(
            draft.lines[kMostLines].where,
            fmt::format("there are {} lines; allowed: at most {}", draft.lines.size(), kMostLines));
        return;
    }
    check_places(draft, reading.mistakes);
    for (std::size_t i = 0; i < draft.lines.size(); ++i) {
        const LineDraft& line = draft.lines[i];
        const LineRole role = line.config.task.role;
        if (line.role_sound && role == LineRole::fresh) {
            check_period(line, draft, reading.mistakes);
        } else if (line.role_sound && role == LineRole::button) {
            check_button(i, draft, reading);
        } else if (line.role_sound && role == LineRole::select) {
            check_select(line, draft, reading.mistakes);
        }
    }
}

}  // namespace tribus
