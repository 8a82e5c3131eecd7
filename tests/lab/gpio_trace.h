#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <vector>

namespace tribus::test {

/// Each level that the kernel sets an output to while it lives, of whatever line, by its own trace.
class LevelTrace {
  public:
    LevelTrace();
    LevelTrace(const LevelTrace&) = delete;
    LevelTrace& operator=(const LevelTrace&) = delete;
    ~LevelTrace();

    std::vector<std::string> levels() const;
    /// When the level changed. Of one line only.
    std::vector<std::chrono::steady_clock::time_point> edges() const;
    std::size_t edges_after(std::chrono::steady_clock::time_point instant) const;
};

}  // namespace tribus::test
