#include "transports/codecs/sent_number.h"

#include <cmath>

namespace tribus {

void SentNumber::find(const ValueBoard& board, std::string_view name, std::string_view unit) {
    board_ = nullptr;
    const auto index = board.find(name);
    if (index && may_be_sent(board.value(*index).unit, unit)) {
        board_ = &board;
        index_ = *index;
        conversion_ = unit_conversion(board.value(*index).unit, unit).value_or(UnitConversion{});
    }
}

std::optional<double> SentNumber::fresh(Instant now) const {
    const auto number = board_ == nullptr ? std::nullopt : board_->fresh(index_, now);
    return number && std::isfinite(*number) ? std::optional(conversion_.apply(*number))
                                            : std::nullopt;
}

}  // namespace tribus
