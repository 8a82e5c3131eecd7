#pragma once

#include <cstdint>

namespace tribus {

/// Numbers that an end of a link uses once for ever, also over restarts: each only after it is
/// stored that it and all below it may have been used. Without a start none may be used. Pure.
class NumberReservation {
  public:
    /// Those below `first` were used before this start.
    void start(std::uint64_t first) {
        started_ = true;
        next_ = first;
        reserved_ = first;
    }
    /// It is stored that all numbers below `end` may have been used.
    void reserve(std::uint64_t end) { reserved_ = end; }

    bool started() const { return started_; }
    /// The least number that was not used.
    std::uint64_t next() const { return next_; }
    /// The end of the numbers that may be used.
    std::uint64_t reserved() const { return reserved_; }
    /// The end of the numbers that shall be reserved.
    std::uint64_t wanted() const { return wanted_; }

    void want(std::uint64_t end) { wanted_ = end; }
    /// `number` and all below it are used.
    void use(std::uint64_t number) { next_ = number + 1; }

  private:
    bool started_ = false;
    std::uint64_t next_ = 0;
    std::uint64_t reserved_ = 0;
    std::uint64_t wanted_ = 0;
};

}  // namespace tribus
