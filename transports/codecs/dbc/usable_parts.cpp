#include "transports/codecs/dbc/usable_parts.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace tribus {
namespace {

/// Takes out the signals with faults, and those that depend on them.
void take_faulty_signals_out(DbcMessageStatement& statement) {
    std::vector<DbcSignal>& signals = statement.message.signals;
    std::vector<std::optional<DbcMistake>>& faults = statement.signal_faults;
    for (std::size_t depth = 0; depth < kDeepestDbcMultiplexing; ++depth) {
        for (std::size_t at = 0; at < signals.size(); ++at) {
            const auto selector = signals[at].selector;
            if (selector && !faults[at] && faults[*selector]) {
                faults[at] = faults[*selector];
            }
        }
    }
    std::vector<std::size_t> places(signals.size());
    std::vector<DbcSignal> usable;
    for (std::size_t at = 0; at < signals.size(); ++at) {
        places[at] = usable.size();
        if (faults[at]) {
            statement.message.unusable.push_back({signals[at].name, *faults[at]});
        } else {
            usable.push_back(std::move(signals[at]));
        }
    }
    for (DbcSignal& signal : usable) {
        if (signal.selector) {
            signal.selector = places[*signal.selector];
        }
    }
    signals = std::move(usable);
}

}  // namespace

DbcFile usable_dbc_parts(DbcStatements statements) {
    DbcFile file;
    file.warnings = std::move(statements.warnings);
    file.messages.reserve(statements.messages.size());
    for (DbcMessageStatement& statement : statements.messages) {
        if (statement.fault) {
            file.warnings.push_back(*statement.fault);
            file.unusable.push_back({statement.message.name, std::move(*statement.fault)});
            continue;
        }
        if (std::ranges::any_of(statement.signal_faults,
                                [](const auto& fault) { return fault.has_value(); })) {
            take_faulty_signals_out(statement);
        }
        for (const DbcUnusable& signal : statement.message.unusable) {
            file.warnings.push_back(signal.why);
        }
        file.messages.push_back(std::move(statement.message));
    }
    const auto place = [](const DbcMistake& mistake) {
        return std::pair(mistake.line, mistake.column);
    };
    std::ranges::stable_sort(file.warnings, {}, place);
    const auto same_place = [&](const DbcMistake& a, const DbcMistake& b) {
        return place(a) == place(b);
    };
    file.warnings.erase(std::unique(file.warnings.begin(), file.warnings.end(), same_place),
                        file.warnings.end());
    return file;
}

}  // namespace tribus
