#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "core/time.h"
#include "core/unit.h"
#include "core/value_board.h"

namespace tribus {

/// A named value in the unit in which an encoder sends it. Thread-bound.
class SentNumber {
  public:
    /// Finds the value on the board, which must outlive this object. There will be no number if the
    /// board lacks the name, or if the unit of the value does not convert to `unit`, which `check`
    /// refuses. Where one of both is empty, the number is taken as it is. For the start.
    void find(const ValueBoard& board, std::string_view name, std::string_view unit);

    /// The number in the unit of `find`. Nothing if it is stale or not finite.
    std::optional<double> fresh(Instant now) const;
    /// The unit of the value itself; empty without one.
    std::string_view own_unit() const {
        return board_ == nullptr ? std::string_view() : board_->value(index_).unit;
    }

  private:
    const ValueBoard* board_ = nullptr;  ///< null: there is no number
    std::size_t index_ = 0;
    UnitConversion conversion_{};
};

}  // namespace tribus
