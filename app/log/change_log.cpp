#include "app/log/change_log.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>

#include <fmt/format.h>

#include "app/journal/log.h"
#include "app/journal/log_fields.h"
#include "core/counted.h"

namespace tribus {
namespace {

/// The parts that are logged, with the fields of their entries.
struct PartFields {
    std::string_view part;
    std::string_view name;
    std::string_view state;
};
constexpr std::array<PartFields, 6> kParts{{{"input", "TRIBUS_INPUT", "TRIBUS_CAUSE"},
                                            {"output", "TRIBUS_OUTPUT", "TRIBUS_STATE"},
                                            {"device", "TRIBUS_DEVICE", ""},
                                            {"bus", "TRIBUS_INTERFACE", ""},
                                            {"node", "TRIBUS_INTERFACE", ""},
                                            {"daemon", "", ""}}};

const PartFields* fields_of(const ToldChange& change) {
    const auto found = std::ranges::find(kParts, change.part, &PartFields::part);
    return found == kParts.end() ? nullptr : found;
}

bool is_loss(const ToldChange& change) {
    return change.part == "input" && change.now != "good" && change.now != "unproved";
}

double in_seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

}  // namespace

void ChangeLog::hold(const ToldChange& change, Memory& memory) {
    const std::size_t text = std::hash<std::string>{}(change.text);
    if (std::exchange(memory.text, text) == text) {
        return;
    }
    // The line of the output that waits for it says what it lacks.
    if (change.part == "input" && change.now == "unproved" && !memory.held) {
        memory.lost_at = kNever;
        return;
    }
    if (!memory.held) {
        memory.held = std::make_unique<Held>();
        memory.held->first = change.at;
    }
    Held& held = *memory.held;
    if (is_loss(change) && change.was != "never_seen") {
        memory.lost_at = std::min(memory.lost_at, change.at);
    } else if (!is_loss(change) && memory.lost_at != kNever) {
        const Duration lasted = change.at - std::exchange(memory.lost_at, kNever);
        held.shortest = std::min(held.shortest, lasted);
        held.longest = std::max(held.longest, lasted);
        ++held.losses;
    }
    ++held.changes;
    held.latest = change;
}

std::string ChangeLog::note_of(const Held& held) {
    if (held.changes < 2) {
        return "";
    }
    const std::string losses =
        held.losses == 0
            ? ""
            : fmt::format(": {} of {:.0f} to {:.0f} ms in {:.1f} s",
                          counted(held.losses, "loss", "losses"), 1e3 * in_seconds(held.shortest),
                          1e3 * in_seconds(held.longest), in_seconds(held.latest.at - held.first));
    return fmt::format(" ({} before this not logged{})", counted(held.changes - 1, "change"),
                       losses);
}

void ChangeLog::log_held(Memory& memory) {
    const auto held = std::exchange(memory.held, nullptr);
    const ToldChange& change = held->latest;
    const PartFields& fields = *fields_of(change);
    const std::string name =
        change.part == "device" ? fmt::format("{} {}", change.kind, change.name) : change.name;
    const LogFields entry({fields.name, name}, {fields.state, change.state});
    log_at(change.level, "{}{}", line_of(change), note_of(*held));
}

void ChangeLog::look(const ChangeJournal& changes, Instant now) {
    const auto log_if_it_may = [now](Memory& memory) {
        if (memory.held && memory.limit.pass(now)) {
            log_held(memory);
        }
    };
    for (const ToldChange& change : changes.since(number_)) {
        if (fields_of(change) != nullptr) {
            Memory& memory = parts_[{change.part, change.name}];
            hold(change, memory);
            log_if_it_may(memory);
        }
    }
    number_ = changes.newest();
    for (auto& [part, memory] : parts_) {
        log_if_it_may(memory);
    }
}

void ChangeLog::flush() {
    for (auto& [part, memory] : parts_) {
        if (memory.held) {
            log_held(memory);
        }
        memory.text = 0;
    }
}

}  // namespace tribus
