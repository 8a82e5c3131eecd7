#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace tribus::test {

/// Levels to which the kernel sets outputs of any line during the object's lifetime, from its
/// trace.
class LevelTrace {
  public:
    LevelTrace();
    LevelTrace(const LevelTrace&) = delete;
    LevelTrace& operator=(const LevelTrace&) = delete;
    ~LevelTrace();

    std::vector<std::string> levels() const;
    /// Times of the level changes. Only if one line is traced.
    std::vector<std::chrono::steady_clock::time_point> edges() const;
    std::size_t edges_after(std::chrono::steady_clock::time_point instant) const;
};

}  // namespace tribus::test
