#include "transports/codecs/dbc/resolve.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "transports/codecs/dbc/attributes.h"

namespace tribus {
namespace {

using Result = tl::expected<void, DbcMistake>;

class Resolver {
  public:
    explicit Resolver(DbcStatements statements) : statements_(std::move(statements)) {}

    tl::expected<DbcFile, DbcMistake> resolve();

  private:
    /// Attributes of a message, and its signals by their short names.
    struct Entry {
        std::unordered_map<std::string_view, std::size_t> signals;
        DbcMessageAttributes attributes{};
    };

    Result index();
    Result index_signals(std::size_t at);
    Result apply_kinds();
    Result apply_selectors();
    void default_selectors();
    Result check_selectors() const;
    void apply_value_texts();
    Result apply_attributes();
    void apply_long_names();
    Result check_names() const;

    DbcMessage* message_of(const DbcReference& reference);
    DbcSignal* signal_of(const DbcReference& reference);

    DbcStatements statements_;
    std::unordered_map<std::uint32_t, std::size_t> by_id_;
    std::vector<Entry> entries_;
};

tl::expected<DbcFile, DbcMistake> Resolver::resolve() {
    const Result result = index()
                              .and_then([this] { return apply_kinds(); })
                              .and_then([this] { return apply_selectors(); })
                              .and_then([this]() -> Result {
                                  default_selectors();
                                  return check_selectors();
                              })
                              .and_then([this] { return apply_attributes(); });
    if (!result) {
        return tl::unexpected(result.error());
    }
    apply_value_texts();
    apply_long_names();
    if (const Result names = check_names(); !names) {
        return tl::unexpected(names.error());
    }
    DbcFile file;
    file.messages.reserve(statements_.messages.size());
    for (DbcMessageStatement& statement : statements_.messages) {
        file.messages.push_back(std::move(statement.message));
    }
    return file;
}

Result Resolver::index() {
    entries_.resize(statements_.messages.size());
    for (std::size_t at = 0; at < statements_.messages.size(); ++at) {
        const DbcMessageStatement& statement = statements_.messages[at];
        const auto [found, added] = by_id_.emplace(statement.file_id, at);
        if (!added) {
            const DbcMessage& first = statements_.messages[found->second].message;
            return dbc_mistake(statement.name_place, "message " + statement.message.name +
                                                         " has the id of message " + first.name +
                                                         " in line " + std::to_string(first.line));
        }
        if (Result indexed = index_signals(at); !indexed) {
            return indexed;
        }
    }
    return {};
}

Result Resolver::index_signals(std::size_t at) {
    const DbcMessageStatement& statement = statements_.messages[at];
    for (std::size_t signal = 0; signal < statement.signal_names.size(); ++signal) {
        const auto [found, added] =
            entries_[at].signals.emplace(statement.signal_names[signal], signal);
        if (!added) {
            const DbcSignal& first = statement.message.signals[found->second];
            return dbc_mistake(statement.signal_places[signal],
                               "message " + statement.message.name + " has another signal " +
                                   first.name + " in line " + std::to_string(first.line));
        }
    }
    return {};
}

DbcMessage* Resolver::message_of(const DbcReference& reference) {
    const auto found = by_id_.find(reference.message);
    return found == by_id_.end() ? nullptr : &statements_.messages[found->second].message;
}

DbcSignal* Resolver::signal_of(const DbcReference& reference) {
    const auto message = by_id_.find(reference.message);
    if (message == by_id_.end()) {
        return nullptr;
    }
    const auto& signals = entries_[message->second].signals;
    const auto signal = signals.find(reference.signal);
    return signal == signals.end()
               ? nullptr
               : &statements_.messages[message->second].message.signals[signal->second];
}

Result Resolver::apply_kinds() {
    for (const DbcKindStatement& statement : statements_.kinds) {
        DbcSignal* const signal = signal_of(statement.of);
        if (signal == nullptr) {
            continue;
        }
        const unsigned needed = statement.kind == DbcValueKind::float32   ? 32
                                : statement.kind == DbcValueKind::float64 ? 64
                                                                          : signal->bit_length;
        if (signal->bit_length != needed) {
            return dbc_mistake(statement.place, "signal " + signal->name +
                                                    " is declared as a floating-point number of " +
                                                    std::to_string(needed) + " bits, but is " +
                                                    std::to_string(signal->bit_length) +
                                                    " bits long");
        }
        signal->kind = statement.kind;
    }
    return {};
}

/// Several statements about one signal add up: some tools write one for each range.
Result Resolver::apply_selectors() {
    for (const DbcSelectorStatement& statement : statements_.selectors) {
        DbcSignal* const signal = signal_of(statement.of);
        if (signal == nullptr) {
            continue;
        }
        const auto& signals = entries_[by_id_.at(statement.of.message)].signals;
        const auto selector = signals.find(statement.selector);
        if (selector == signals.end()) {
            return dbc_mistake(statement.selector_place,
                               "signal " + signal->name + " depends on " +
                                   utf8_from_dbc(statement.selector) +
                                   ", which is not a signal of its message");
        }
        if (signal->selector && *signal->selector != selector->second) {
            return dbc_mistake(statement.selector_place,
                               "signal " + signal->name + " already depends on another signal");
        }
        if (!signal->selector) {
            signal->selected_by.clear();
        }
        signal->selector = selector->second;
        signal->page_unknown = false;
        signal->selected_by.insert(signal->selected_by.end(), statement.ranges.begin(),
                                   statement.ranges.end());
        message_of(statement.of)->signals[selector->second].is_selector = true;
    }
    return {};
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

Result Resolver::check_selectors() const {
    for (const DbcMessageStatement& statement : statements_.messages) {
        const auto& signals = statement.message.signals;
        for (std::size_t at = 0; at < signals.size(); ++at) {
            const DbcSignal* signal = &signals[at];
            if (signal->is_selector && signal->kind != DbcValueKind::integer) {
                return dbc_mistake(
                    statement.signal_places[at],
                    "signal " + signal->name + " selects others, so it must be an integer");
            }
            for (std::size_t depth = 0; signal->selector; ++depth) {
                if (depth == kDeepestDbcMultiplexing) {
                    return dbc_mistake(statement.signal_places[at],
                                       "signal " + signals[at].name + " depends on more than " +
                                           std::to_string(kDeepestDbcMultiplexing) +
                                           " selectors, or on itself");
                }
                signal = &signals[*signal->selector];
            }
        }
    }
    return {};
}

void Resolver::apply_value_texts() {
    for (DbcValueTextStatement& statement : statements_.value_texts) {
        if (DbcSignal* const signal = signal_of(statement.of); signal != nullptr) {
            std::move(statement.texts.begin(), statement.texts.end(),
                      std::back_inserter(signal->value_texts));
        }
    }
}

Result Resolver::apply_attributes() {
    for (const DbcAttributeStatement& statement : statements_.attributes) {
        const auto found = by_id_.find(statement.of.message);
        if (found != by_id_.end() && statement.of.signal.empty()) {
            entries_[found->second].attributes[static_cast<std::size_t>(statement.attribute)] =
                &statement.value;
        }
    }
    for (std::size_t at = 0; at < entries_.size(); ++at) {
        DbcMessageStatement& statement = statements_.messages[at];
        Result result = apply_dbc_attributes(statements_.definitions, entries_[at].attributes,
                                             statement.length_place, statement.message);
        if (!result) {
            return result;
        }
    }
    return {};
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

/// Long names may clash even if short ones do not.
Result Resolver::check_names() const {
    std::unordered_map<std::string_view, unsigned> messages;
    for (const DbcMessageStatement& statement : statements_.messages) {
        const DbcMessage& message = statement.message;
        const auto [first, added] = messages.emplace(message.name, message.line);
        if (!added) {
            return dbc_mistake(statement.name_place, "there is another message " + message.name +
                                                         " in line " +
                                                         std::to_string(first->second));
        }
        std::unordered_map<std::string_view, unsigned> signals;
        for (std::size_t at = 0; at < message.signals.size(); ++at) {
            const DbcSignal& signal = message.signals[at];
            const auto [other, unique] = signals.emplace(signal.name, signal.line);
            if (!unique) {
                return dbc_mistake(statement.signal_places[at],
                                   "message " + message.name + " has another signal " +
                                       signal.name + " in line " + std::to_string(other->second));
            }
        }
    }
    return {};
}

}  // namespace

tl::expected<DbcFile, DbcMistake> resolve_dbc(DbcStatements statements) {
    return Resolver(std::move(statements)).resolve();
}

}  // namespace tribus
