#pragma once

#include <algorithm>
#include <cstdint>

namespace tribus {

/// How many numbers an end of a link reserves at a time, and how many before they are used up it
/// asks for the next ones.
struct NumberBlocks {
    std::uint64_t block = 0;
    std::uint64_t ahead = 0;
};

/// No number is as high: nobody gets there in thousands of years, and sums of two below it do not
/// overflow.
inline constexpr std::uint64_t kEndOfNumbers = (std::uint64_t{1} << 63U) - 1;

/// Numbers that an end of a link uses once for ever, also over restarts: each only after it is
/// stored that it and all below it may have been used. Those of a sender follow its clock, so that
/// receivers see how much time lies between two of them. Who stores that derives from it, and says
/// in which thread. All functions: for the thread that runs the link, unless they say otherwise.
class NumberReservation {
  public:
    NumberReservation() = default;
    NumberReservation(const NumberReservation&) = delete;
    NumberReservation& operator=(const NumberReservation&) = delete;
    virtual ~NumberReservation() = default;

    /// The least number that was not used.
    std::uint64_t next() const { return next_; }
    /// The number that belongs to a step of the clock. Only for a sender.
    virtual std::uint64_t at(std::uint64_t step) = 0;
    /// Those of a receiver by one of its keys, which move the numbers of no other key: a stolen key
    /// cannot use up those of the next one. `id`: another one for each key. It lasts as long as
    /// this. Main thread.
    virtual NumberReservation& of_key(std::uint32_t /*id*/) { return *this; }
    /// Uses `number`, which is `next` or above it, and all below it. False if it is too high or not
    /// reserved yet. Asks for more before they are used up.
    bool use(std::uint64_t number, const NumberBlocks& blocks) {
        if (number >= kEndOfNumbers) {
            return false;
        }
        const std::uint64_t end = reserved();
        if (number + blocks.ahead >= end) {
            want(std::min(number + blocks.block, kEndOfNumbers));
        }
        if (number >= end) {
            return false;
        }
        next_ = std::max(next_, number + 1);
        return true;
    }

  protected:
    /// Those below `first` were used before this start. Call it before the first `use`.
    void begin(std::uint64_t first) { next_ = first; }

  private:
    /// The end of the numbers that may be used.
    virtual std::uint64_t reserved() const = 0;
    /// The numbers below `end` shall be reserved. May come again and again.
    virtual void want(std::uint64_t end) = 0;

    std::uint64_t next_ = 0;
};

}  // namespace tribus
