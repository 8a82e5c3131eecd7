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

/// A number with a name: a signal of a CAN message, a sensor reading, the health of a link, a fact
/// about the machine, a constant.
struct NamedValue {
    std::string name;
    std::string unit;  ///< "V", "degC"; empty if unknown or if it has none
    /// An older number is stale. `kForever`: it never becomes stale.
    Duration lasts{};
};

/// Lifetime of a value that never becomes stale.
inline constexpr Duration kForever = Duration::max();

/// When a value had no fresh number, between two that it had.
struct ValueGaps {
    std::uint64_t count = 0;
    /// When the latest one began; the instant of its end if the source had reported that it has no
    /// number.
    Instant stale_at{};
    /// Since then its numbers are fresh, or were. `kNever`: there was none yet.
    Instant fresh_since = kNever;
};

/// All named values of a configuration, each with its latest number and the instant of it. A newer
/// number replaces an older one. No heap after construction. Thread-bound: belongs to the data
/// thread once that runs.
class ValueBoard {
  public:
    explicit ValueBoard(std::vector<NamedValue> values)
        : values_(std::move(values)), entries_(values_.size()) {}

    /// Copies numbers of `before`: `from` gives for each value its index there, or nothing to keep
    /// the value.
    void continue_from(const ValueBoard& before, std::span<const std::optional<std::size_t>> from) {
        for (std::size_t i = 0; i < entries_.size(); ++i) {
            entries_[i] = from[i] ? before.entries_[*from[i]] : entries_[i];
        }
    }

    std::size_t size() const { return values_.size(); }
    /// Name, unit and lifetime of a value.
    const NamedValue& value(std::size_t index) const { return values_[index]; }
    /// Linear search: for the start, not for the data path.
    std::optional<std::size_t> find(std::string_view name) const;

    /// `tag` is for users that know this value: for a sensor reading it is the id of its type.
    void set(std::size_t index, double number, Instant at, std::uint8_t tag = 0) {
        Entry& entry = entries_[index];
        if (!entry.available || at - entry.at > values_[index].lasts) {
            end_gap(index, at);
        }
        entry.number = number;
        entry.at = at;
        entry.available = true;
        entry.tag = tag;
    }
    /// The source reports that it has no number now. Tag and age stay.
    void remove(std::size_t index) { entries_[index].available = false; }

    /// The number, unless there is none or it is stale.
    std::optional<double> fresh(std::size_t index, Instant now) const {
        const Entry& entry = entries_[index];
        const bool fresh = entry.available && (values_[index].lasts == kForever ||
                                               now - entry.at <= values_[index].lasts);
        return fresh ? std::optional(entry.number) : std::nullopt;
    }
    /// The latest number, stale or not. Valid only if `ever`.
    double latest(std::size_t index) const { return entries_[index].number; }
    /// Whether there ever was a number.
    bool ever(std::size_t index) const { return entries_[index].gaps.fresh_since != kNever; }
    /// Whether the source has a number now, stale or not.
    bool available(std::size_t index) const { return entries_[index].available; }
    /// Instant of the latest number. Valid only if `ever`.
    Instant at(std::size_t index) const { return entries_[index].at; }
    /// Age of the latest number, stale or not. Valid only if `ever`.
    Duration age(std::size_t index, Instant now) const { return now - entries_[index].at; }
    ValueGaps gaps(std::size_t index) const { return entries_[index].gaps; }
    std::uint8_t tag(std::size_t index) const { return entries_[index].tag; }
    /// The last instant at which `fresh` still returns the present number; `kNever` if the value
    /// never becomes stale or has no number.
    Instant fresh_until(std::size_t index) const;

  private:
    struct Entry {
        double number = 0;
        Instant at{};
        ValueGaps gaps{};
        bool available = false;
        std::uint8_t tag = 0;
    };

    void end_gap(std::size_t index, Instant at);

    std::vector<NamedValue> values_;
    std::vector<Entry> entries_;
};

}  // namespace tribus
