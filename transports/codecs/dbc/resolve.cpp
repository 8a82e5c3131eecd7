#include "transports/codecs/dbc/resolve.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "transports/codecs/dbc/attributes.h"
#include "transports/codecs/dbc/usable_parts.h"

namespace tribus {
namespace {

class Resolver {
  public:
    explicit Resolver(DbcStatements statements) : statements_(std::move(statements)) {}

    DbcFile resolve();

  private:
    /// Attributes of a message, and its signals by their short names.
    struct Entry {
        std::unordered_map<std::string_view, std::size_t> signals;
        DbcMessageAttributes attributes{};
    };
    /// A signal, by its place among the statements.
    struct Place {
        std::size_t message = 0;
        std::size_t signal = 0;
    };

    void index();
    void index_signals(std::size_t at);
    void apply_faults();
    void apply_kinds();
    void apply_selectors();
    void default_selectors();
    void check_selectors();
    void check_selectors(std::size_t at);
    void apply_value_texts();
    void apply_attributes();
    void apply_long_names();
    void check_names();
    void check_signal_names(DbcMessageStatement& statement);

    bool is_known(std::uint32_t id) const;
    std::optional<Place> place_of(const DbcReference& reference) const;
    DbcMessage* message_of(const DbcReference& reference);
    DbcSignal* signal_of(const DbcReference& reference);
    /// Keeps the first fault.
    static void blame(std::optional<DbcMistake>& fault, DbcMistake mistake) {
        if (!fault) {
            fault = std::move(mistake);
        }
    }
    void blame(const Place& place, DbcMistake mistake) {
        blame(statements_.messages[place.message].signal_faults[place.signal], std::move(mistake));
    }

    DbcStatements statements_;
    std::unordered_map<std::uint32_t, std::size_t> by_id_;
    std::vector<Entry> entries_;
};

DbcFile Resolver::resolve() {
    index();
    apply_faults();
    apply_kinds();
    apply_selectors();
    default_selectors();
    check_selectors();
    apply_attributes();
    apply_value_texts();
    apply_long_names();
    check_names();
    return usable_dbc_parts(std::move(statements_));
}

void Resolver::index() {
    entries_.resize(statements_.messages.size());
    for (std::size_t at = 0; at < statements_.messages.size(); ++at) {
        DbcMessageStatement& statement = statements_.messages[at];
        index_signals(at);
        if (!statement.file_id) {
            continue;
        }
        const auto [found, added] = by_id_.emplace(*statement.file_id, at);
        if (!added) {
            // What other statements say of the id may mean either.
            DbcMessageStatement& first = statements_.messages[found->second];
            const DbcMistake mistake = dbc_mistake_at(
                statement.name_place, "message " + statement.message.name +
                                          " has the id of message " + first.message.name +
                                          " in line " + std::to_string(first.message.line));
            blame(first.fault, mistake);
            blame(statement.fault, mistake);
        }
    }
}

void Resolver::index_signals(std::size_t at) {
    DbcMessageStatement& statement = statements_.messages[at];
    for (std::size_t signal = 0; signal < statement.signal_names.size(); ++signal) {
        const auto [found, added] =
            entries_[at].signals.emplace(statement.signal_names[signal], signal);
        if (!added) {
            const DbcSignal& first = statement.message.signals[found->second];
            const DbcMistake mistake =
                dbc_mistake_at(statement.signal_places[signal],
                               "message " + statement.message.name + " has another signal " +
                                   first.name + " in line " + std::to_string(first.line));
            blame({at, found->second}, mistake);
            blame({at, signal}, mistake);
        }
    }
}

bool Resolver::is_known(std::uint32_t id) const {
    return by_id_.contains(id) ||
           std::ranges::find(statements_.placeholders, id) != statements_.placeholders.end();
}

std::optional<Resolver::Place> Resolver::place_of(const DbcReference& reference) const {
    const auto message = by_id_.find(reference.message);
    if (message == by_id_.end()) {
        return std::nullopt;
    }
    const auto& signals = entries_[message->second].signals;
    const auto signal = signals.find(reference.signal);
    return signal == signals.end() ? std::nullopt
                                   : std::optional(Place{message->second, signal->second});
}

DbcMessage* Resolver::message_of(const DbcReference& reference) {
    const auto found = by_id_.find(reference.message);
    return found == by_id_.end() ? nullptr : &statements_.messages[found->second].message;
}

DbcSignal* Resolver::signal_of(const DbcReference& reference) {
    const auto place = place_of(reference);
    return place ? &statements_.messages[place->message].message.signals[place->signal] : nullptr;
}

void Resolver::apply_faults() {
    for (DbcFaultStatement& statement : statements_.faults) {
        const auto found = by_id_.find(statement.message);
        if (found == by_id_.end()) {
            statements_.warnings.push_back(std::move(statement.mistake));
        } else {
            blame(statements_.messages[found->second].fault, std::move(statement.mistake));
        }
    }
}

void Resolver::apply_kinds() {
    for (const DbcKindStatement& statement : statements_.kinds) {
        const auto place = place_of(statement.of);
        if (!place) {
            const auto message = by_id_.find(statement.of.message);
            const bool whole =
                message == by_id_.end() || !statements_.messages[message->second].fault;
            if (message != by_id_.end() ? whole : !is_known(statement.of.message)) {
                statements_.warnings.push_back(dbc_mistake_at(
                    statement.place,
                    "SIG_VALTYPE_ is about signal " + utf8_from_dbc(statement.of.signal) +
                        " of the message with id " + std::to_string(statement.of.message) +
                        ", which the file does not have"));
            }
            continue;
        }
        DbcSignal& signal = statements_.messages[place->message].message.signals[place->signal];
        const unsigned needed = statement.kind == DbcValueKind::float32   ? 32
                                : statement.kind == DbcValueKind::float64 ? 64
                                                                          : signal.bit_length;
        if (signal.bit_length != needed) {
            blame(*place, dbc_mistake_at(statement.place,
                                         "signal " + signal.name +
                                             " is declared as a floating-point number of " +
                                             std::to_string(needed) + " bits, but is " +
                                             std::to_string(signal.bit_length) + " bits long"));
            continue;
        }
        signal.kind = statement.kind;
    }
}

/// Several statements about one signal add up: some tools write one for each range.
void Resolver::apply_selectors() {
    for (const DbcSelectorStatement& statement : statements_.selectors) {
        const auto place = place_of(statement.of);
        if (!place) {
            continue;
        }
        std::vector<DbcSignal>& all = statements_.messages[place->message].message.signals;
        DbcSignal& signal = all[place->signal];
        const auto& signals = entries_[place->message].signals;
        const auto selector = signals.find(statement.selector);
        if (selector == signals.end()) {
            blame(*place, dbc_mistake_at(statement.selector_place,
                                         "signal " + signal.name + " depends on " +
                                             utf8_from_dbc(statement.selector) +
                                             ", which is not a signal of its message"));
            continue;
        }
        if (signal.selector && *signal.selector != selector->second) {
            blame(*place,
                  dbc_mistake_at(statement.selector_place,
                                 "signal " + signal.name + " already depends on another signal"));
            continue;
        }
        if (!signal.selector) {
            signal.selected_by.clear();
        }
        signal.selector = selector->second;
        signal.page_unknown = false;
        signal.selected_by.insert(signal.selected_by.end(), statement.ranges.begin(),
                                  statement.ranges.end());
        all[selector->second].is_selector = true;
    }
}

/// Without SG_MUL_VAL_, mN depends on the only selector of the message. With several selectors or
/// none, the selector is unknown.
void Resolver::default_selectors() {
    for (DbcMessageStatement& statement : statements_.messages) {
        std::vector<DbcSignal>& signals = statement.message.signals;
        const auto first = std::ranges::find_if(signals, &DbcSignal::is_selector);
        const bool one = std::ranges::count_if(signals, &DbcSignal::is_selector) == 1;
        for (DbcSignal& signal : signals) {
            if (signal.selected_by.empty() || signal.selector) {
                continue;
            }
            if (one && &signal != &*first) {
                signal.selector = static_cast<std::size_t>(first - signals.begin());
            } else {
                signal.selected_by.clear();
                signal.page_unknown = true;
            }
        }
    }
}

void Resolver::check_selectors() {
    for (std::size_t at = 0; at < statements_.messages.size(); ++at) {
        check_selectors(at);
    }
}

void Resolver::check_selectors(std::size_t at) {
    DbcMessageStatement& statement = statements_.messages[at];
    const std::vector<DbcSignal>& signals = statement.message.signals;
    for (std::size_t i = 0; i < signals.size(); ++i) {
        const DbcSignal* signal = &signals[i];
        if (signal->is_selector && signal->kind != DbcValueKind::integer) {
            blame({at, i}, dbc_mistake_at(statement.signal_places[i],
                                          "signal " + signal->name +
                                              " selects others, so it must be an integer"));
        }
        for (std::size_t depth = 0; signal->selector; ++depth) {
            if (depth == kDeepestDbcMultiplexing) {
                blame({at, i},
                      dbc_mistake_at(statement.signal_places[i],
                                     "signal " + signals[i].name + " depends on more than " +
                                         std::to_string(kDeepestDbcMultiplexing) +
                                         " selectors, or on itself"));
                break;
            }
            signal = &signals[*signal->selector];
        }
    }
}

void Resolver::apply_value_texts() {
    for (DbcValueTextStatement& statement : statements_.value_texts) {
        if (DbcSignal* const signal = signal_of(statement.of); signal != nullptr) {
            std::move(statement.texts.begin(), statement.texts.end(),
                      std::back_inserter(signal->value_texts));
        }
    }
}

void Resolver::apply_attributes() {
    for (const DbcAttributeStatement& statement : statements_.attributes) {
        const auto found = by_id_.find(statement.of.message);
        if (found != by_id_.end() && statement.of.signal.empty()) {
            entries_[found->second].attributes[static_cast<std::size_t>(statement.attribute)] =
                &statement.value;
        }
    }
    for (std::size_t at = 0; at < entries_.size(); ++at) {
        DbcMessageStatement& statement = statements_.messages[at];
        if (const auto applied =
                apply_dbc_attributes(statements_.definitions, entries_[at].attributes,
                                     statement.length_place, statement.message);
            !applied) {
            blame(statement.fault, applied.error());
        }
    }
}

void Resolver::apply_long_names() {
    for (const DbcAttributeStatement& statement : statements_.attributes) {
        if (statement.value.text.empty()) {
            continue;
        }
        if (statement.attribute == DbcAttribute::message_long_name) {
            if (DbcMessage* const message = message_of(statement.of); message != nullptr) {
                message->name = statement.value.text;
            }
        } else if (statement.attribute == DbcAttribute::signal_long_name) {
            if (DbcSignal* const signal = signal_of(statement.of); signal != nullptr) {
                signal->name = statement.value.text;
            }
        }
    }
}

/// Whoever names one of two could mean the other. Long names may clash even if short ones do not.
void Resolver::check_names() {
    std::unordered_map<std::string_view, DbcMessageStatement*> messages;
    for (DbcMessageStatement& statement : statements_.messages) {
        const DbcMessage& message = statement.message;
        check_signal_names(statement);
        if (message.name.empty()) {
            continue;
        }
        const auto [found, added] = messages.emplace(message.name, &statement);
        if (!added) {
            DbcMessageStatement& first = *found->second;
            const DbcMistake mistake = dbc_mistake_at(
                statement.name_place, "there is another message " + message.name + " in line " +
                                          std::to_string(first.message.line));
            blame(first.fault, mistake);
            blame(statement.fault, mistake);
        }
    }
}

void Resolver::check_signal_names(DbcMessageStatement& statement) {
    const std::vector<DbcSignal>& signals = statement.message.signals;
    std::unordered_map<std::string_view, std::size_t> seen;
    for (std::size_t at = 0; at < signals.size(); ++at) {
        const auto [first, added] = seen.emplace(signals[at].name, at);
        if (!added) {
            const DbcMistake mistake = dbc_mistake_at(
                statement.signal_places[at],
                "message " + statement.message.name + " has another signal " + signals[at].name +
                    " in line " + std::to_string(signals[first->second].line));
            blame(statement.signal_faults[first->second], mistake);
            blame(statement.signal_faults[at], mistake);
        }
    }
}

}  // namespace

DbcFile resolve_dbc(DbcStatements statements) {
    return Resolver(std::move(statements)).resolve();
}

}  // namespace tribus
