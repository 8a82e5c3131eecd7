#include "transports/codecs/sent_number.h"

#include <cmath>

namespace tribus {

void SentNumber::find(const ValueBoard& board, std::string_view name, std::string_view unit) {
    const auto index = board.find(name);
    if (!index) {
        return;
    }
    const std::string_view own = board.value(*index).unit;
    const auto conversion = unit_conversion(own, unit);
    const bool measures_something_else = !conversion && !unit.empty() && is_known_unit(own);
    if (!measures_something_else) {
        board_ = &board;
        index_ = *index;
        conversion_ = conversion.value_or(UnitConversion{});
    }
}

std::optional<double> SentNumber::fresh(Instant now) const {
    const auto number = board_ == nullptr ? std::nullopt : board_->fresh(index_, now);
    return number && std::isfinite(*number) ? std::optional(conversion_.apply(*number))
                                            : std::nullopt;
}

}  // namespace tribus
