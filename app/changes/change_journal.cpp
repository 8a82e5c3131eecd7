#include "app/changes/change_journal.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/state_text/cause_text.h"
#include "app/state_text/part_text.h"
#include "app/status/status.h"
#include "core/counted.h"

namespace tribus {
namespace {

std::string name_of_input(std::size_t input, std::span<const std::string> names) {
    return input == kNoInput ? "" : names[input];
}

bool same_state(OutputState a, const OutputState& b) {
    a.by_preset = b.by_preset;
    return a == b;
}

/// Until when the published figures say more of the changed part.
Instant published_at(const Change& change, const Appliance& appliance) {
    switch (change.part) {
        case Change::Part::input:
            return appliance.input_status(change.index).at;
        case Change::Part::output:
            return appliance.output_status(change.index).at;
        case Change::Part::bus:
        case Change::Part::node:
            break;
    }
    return change.at;
}

}  // namespace

std::string line_of(const ToldChange& change) {
    return fmt::format("{}{}{}: {}", change.kind, change.kind.empty() ? "" : " ", change.name,
                       change.text);
}

void ChangeJournal::add(ToldChange change) {
    change.number = ++newest_;
    changes_.push_back(std::move(change));
    if (changes_.size() > kChanges) {
        changes_.pop_front();
    }
}

/// Adds the change if its word is another one than before.
void ChangeJournal::note(ToldChange change, Instant at, Wall wall) {
    std::string& word = words_[{change.part, change.name}];
    if (word == change.now) {
        return;
    }
    change.was = std::exchange(word, change.now);
    change.field = "state";
    change.at = at;
    change.wall_time = wall.at(at);
    add(std::move(change));
}

void ChangeJournal::add(std::span<const Appliance::DeviceEvent> events, Instant now,
                        Duration wall_now) {
    // A device that was gone and is back within one round is told as gone, too.
    for (const Appliance::DeviceEvent& event : events) {
        const bool first = event.back && never_there_.erase(event.name) > 0;
        note({.part = "device",
              .name = event.name,
              .now = event.back ? "there" : "gone",
              .text = std::string(!event.back ? kGoneText
                                  : first     ? "is there"
                                              : "is back"),
              .level = event.back ? LogLevel::info : LogLevel::warning,
              .kind = event.kind},
             now, {now, wall_now});
    }
}

void ChangeJournal::look(const Appliance& appliance, Instant now, Duration wall_now) {
    const Wall wall{now, wall_now};
    take(appliance.changes(), appliance.changes().newest(), &appliance, wall);
    // A change that is not published yet may end the wait of an output.
    if (taken_ == appliance.changes().newest()) {
        look_at_waits(appliance, wall);
    }
    look_at_values(appliance, wall);
}

/// A change that is newer than the published figures of its part waits for the next ones, which say
/// more of it.
void ChangeJournal::take(const ChangeRing& ring, std::uint64_t newest, const Appliance* appliance,
                         Wall wall) {
    for (; taken_ < newest; ++taken_) {
        const auto change = ring.read(taken_ + 1);
        if (!change) {
            ++lost_;
            continue;
        }
        if (appliance != nullptr && change->at > published_at(*change, *appliance)) {
            return;
        }
        tell_lost(change->at, wall);
        add(*change, appliance, wall);
    }
    tell_lost(wall.now, wall);
}

void ChangeJournal::add(const Change& change, const Appliance* appliance, Wall wall) {
    switch (change.part) {
        case Change::Part::input:
            return add_input(change, appliance, wall);
        case Change::Part::output:
            return add_output(change, appliance, wall);
        case Change::Part::bus:
            return note(of_bus(change.index, change.now.bus), change.at, wall);
        case Change::Part::node:
            return note(of_node(change.index, change.now.node), change.at, wall);
    }
}

void ChangeJournal::tell_lost(Instant at, Wall wall) {
    if (const std::uint64_t lost = std::exchange(lost_, 0)) {
        add({.at = at,
             .wall_time = wall.at(at),
             .part = "daemon",
             .name = "changes",
             .field = "lost",
             .now = std::to_string(lost),
             .text = counted(lost, "change") +
                     " of state came faster than they were read, and nobody is told of them"});
    }
}

/// Returns the word of the part's last change, and remembers that of this one. After a stop or a
/// loss of changes the engine may know another one, but a reader does not.
std::string ChangeJournal::word_before(const ToldChange& change) {
    const auto [word, first] = words_.try_emplace({change.part, change.name}, change.was);
    return std::exchange(word->second, change.now);
}

void ChangeJournal::add_input(const Change& change, const Appliance* appliance, Wall wall) {
    const LinkState& link = change.now.link;
    InputStatus status{};
    if (appliance != nullptr && appliance->input_status(change.index).state.cause == link.cause) {
        status = appliance->input_status(change.index);
    }
    ToldChange told{.at = change.at,
                    .wall_time = wall.at(change.at),
                    .part = "input",
                    .name = input_names_[change.index],
                    .field = "cause",
                    .was = std::string(word_of(change.was.link.cause)),
                    .now = std::string(word_of(link.cause)),
                    .text = cause_text(link, status.implausible, status.fault.view()),
                    .state = word_of(link.cause),
                    .level = link.cause == LinkCause::good ? LogLevel::info : LogLevel::warning,
                    .kind = "input"};
    told.was = word_before(told);
    add(std::move(told));
}

/// "; outvoted by the others: backup", or that its inputs agree again. Bits as in `OutputState`.
std::string ChangeJournal::votes_text(std::size_t output, std::uint32_t before,
                                      std::uint32_t now) const {
    std::string names;
    for (std::size_t place = 0; place < inputs_of_[output].size(); ++place) {
        if ((now >> place & 1U) != 0) {
            names += fmt::format("{}{}", names.empty() ? "" : ", ",
                                 input_names_[inputs_of_[output][place]]);
        }
    }
    return !names.empty() ? "; outvoted by the others: " + names
           : before != 0  ? "; its inputs agree again"
                          : "";
}

/// The newest state of an output is told with what it waits for.
std::string ChangeJournal::text_of(const Change& change, const Appliance* appliance) const {
    const OutputState& state = change.now.output;
    const OutputStatus status =
        appliance == nullptr ? OutputStatus{} : appliance->output_status(change.index);
    const OutputWait wait = same_state(status.state, state) ? status.wait : OutputWait{};
    return output_sentence(state, wait, input_names_) +
           votes_text(change.index, change.was.output.outvoted, state.outvoted);
}

/// All but words and sentence of a change of an output that is in this state then.
ToldChange ChangeJournal::of_output(std::size_t output, Instant at, const OutputState& state,
                                    bool sends, Wall wall) const {
    return {.at = at,
            .wall_time = wall.at(at),
            .part = "output",
            .name = output_names_[output],
            .field = "state",
            .state = output_state_word(state.stage, sends),
            .input = name_of_input(state.input, input_names_),
            .level = is_fine(state) ? LogLevel::info : LogLevel::warning,
            .kind = "output"};
}

void ChangeJournal::add_output(const Change& change, const Appliance* appliance, Wall wall) {
    const OutputState& state = change.now.output;
    ToldChange told = of_output(change.index, change.at, state, change.now.sends, wall);
    told.was = output_state_word(change.was.output.stage, change.was.sends);
    told.now = told.state;
    told.text = text_of(change, appliance);
    OutputMemory& memory = outputs_[change.index];
    memory.changed = true;
    memory.waits = true;
    const std::string text = std::exchange(memory.text, told.text);
    memory.input = told.input;
    told.was = word_before(told);
    if (told.was == told.now && change.was.output.input != state.input) {
        told.field = "input";
        told.was = name_of_input(change.was.output.input, input_names_);
        told.now = told.input;
    } else if (told.was == told.now) {
        if (text == told.text) {
            return;
        }
        told.field = "text";
        told.was = text;
        told.now = told.text;
    }
    add(std::move(told));
}

/// Tells another wait of an output whose state stays the same.
void ChangeJournal::look_at_waits(const Appliance& appliance, Wall wall) {
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
        OutputMemory& memory = outputs_[i];
        if (!memory.waits) {
            continue;
        }
        const OutputStatus status = appliance.output_status(i);
        memory.waits = status.state.stage == OutputStage::failsafe ||
                       status.state.stage == OutputStage::holding;
        const bool changed = std::exchange(memory.changed, false);
        const std::string& key =
            memory.wait.look(wait_key(status.wait, input_names_), changed, wall.now);
        if (key == memory.wait_key) {
            continue;
        }
        memory.wait_key = key;
        const std::string was =
            std::exchange(memory.waits_for, wait_text(status.state, status.wait, input_names_));
        if (!changed && !key.empty()) {
            memory.text = "waits for " + memory.waits_for;
            ToldChange told = of_output(i, wall.now, status.state, status.sends, wall);
            told.field = "waits_for";
            told.was = was;
            told.now = memory.waits_for;
            told.text = memory.text;
            add(std::move(told));
        }
    }
}

void ChangeJournal::tell_value(ValueMemory& memory, bool fresh, Instant at, Wall wall) {
    const auto word = [](bool is) { return is ? "fresh" : "stale"; };
    if (memory.fresh && *memory.fresh != fresh) {
        add({.at = at,
             .wall_time = wall.at(at),
             .part = "value",
             .name = memory.name,
             .field = "state",
             .was = word(*memory.fresh),
             .now = word(fresh),
             .text = fmt::format("is {}", word(fresh)),
             .kind = "value"});
    }
    memory.fresh = fresh;
}

/// A value that was stale for a moment between two looks tells of its latest such moment.
void ChangeJournal::look_at_values(const Appliance& appliance, Wall wall) {
    for (ValueMemory& memory : values_) {
        const ValueStatus status = appliance.value_status(memory.index);
        if (!status.ever) {
            // Its source is another one than before a reload.
            if (memory.fresh) {
                tell_value(memory, false, wall.now, wall);
            }
            continue;
        }
        const std::uint64_t told = std::exchange(memory.gaps, status.gaps.count);
        if (memory.fresh && status.gaps.count > told) {
            tell_value(memory, false, status.gaps.stale_at, wall);
            tell_value(memory, true, status.gaps.fresh_since, wall);
        }
        const bool fresh = is_fresh(status, memory.lasts, wall.now);
        tell_value(memory, fresh,
                   fresh || !status.available ? wall.now : later(status.at, memory.lasts), wall);
    }
}

std::vector<ToldChange> ChangeJournal::since(std::uint64_t number, std::size_t most) const {
    const std::uint64_t first = std::max(number + 1, oldest());
    std::vector<ToldChange> found;
    for (std::uint64_t next = first; next <= newest_ && found.size() < most; ++next) {
        found.push_back(changes_[next - oldest()]);
    }
    return found;
}

}  // namespace tribus
