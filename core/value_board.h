#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/time.h"

namespace tribus {

/// A number that has a name: a signal of a CAN message, the reading of a sensor, the health of a
/// link, a fact of the machine, a constant.
struct NamedValue {
    std::string name;
    std::string unit;  ///< "V", "degC"; empty where it is not known or has none
    /// A number that is older is stale. `kForever`: it never is.
    Duration lasts{};
};

/// For values that do not grow stale.
inline constexpr Duration kForever = Duration::max();

/// Every named value of a configuration, each with its latest number and the instant of that.
/// Latest value only: a newer number replaces an older one. No heap after construction. Thread-
/// bound: the data thread's, once it runs.
class ValueBoard {
  public:
    explicit ValueBoard(std::vector<NamedValue> values)
        : values_(std::move(values)), entries_(values_.size()) {}

    /// The numbers of `before` at the places that `from` gives for each value; the others stay.
    void continue_from(const ValueBoard& before, std::span<const std::optional<std::size_t>> from) {
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            entries_[i] = from[i] ? before.entries_[*from[i]] : entries_[i];
        }
    }

    std::size_t size() const { return values_.size(); }
    const NamedValue& value(std::size_t index) const { return values_[index]; }
    /// Looks through all: for the start, not for the data path.
    std::optional<std::size_t> find(std::string_view name) const;

    /// `tag` is for those who know this value: a sensor's reading carries the id of its type.
    void set(std::size_t index, double number, Instant at, std::uint8_t tag = 0) {
        entries_[index] = {.number = number, .at = at, .ever = true, .available = true, .tag = tag};
    }
    /// Its source says that there is no number now. It keeps its tag and age.
    void remove(std::size_t index) { entries_[index].available = false; }

    /// The number, if there is one and it is not stale.
    std::optional<double> fresh(std::size_t index, Instant now) const {
        const Entry& entry = entries_[index];
        const bool fresh = entry.available && (values_[index].lasts == kForever ||
                                               now - entry.at <= values_[index].lasts);
        return fresh ? std::optional(entry.number) : std::nullopt;
    }
    /// The number that it had last, stale or not; only where there ever was one.
    double latest(std::size_t index) const { return entries_[index].number; }
    /// Whether it ever had a number.
    bool ever(std::size_t index) const { return entries_[index].ever; }
    /// Its source has a number now, stale or not.
    bool available(std::size_t index) const { return entries_[index].available; }
    /// Of the latest number; only where there ever was one.
    Instant at(std::size_t index) const { return entries_[index].at; }
    /// Of the latest number, stale or not; only where there ever was one.
    Duration age(std::size_t index, Instant now) const { return now - entries_[index].at; }
    std::uint8_t tag(std::size_t index) const { return entries_[index].tag; }
    /// The last instant at which `fresh` gives the number that it gives now; `kNever` for those
    /// that never grow stale or have none.
    Instant fresh_until(std::size_t index) const;

  private:
    struct Entry {
        double number = 0;
        Instant at{};
        bool ever = false;
        bool available = false;
        std::uint8_t tag = 0;
    };

    std::vector<NamedValue> values_;
    std::vector<Entry> entries_;
};

}  // namespace tribus
