#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "transports/links/unique_fd.h"

namespace tribus {

/// Writes lines to a stream that may be closed or full, or that nobody reads. It never waits and
/// never fails: a line for which there is no room is lost, and the next one that is written says
/// how many were. SIGPIPE and SIGXFSZ must be ignored. Thread-bound.
class LineWriter {
  public:
    explicit LineWriter(int descriptor);

    /// `line` has no line end.
    void write(std::string_view line);

  private:
    bool put(std::string_view text);
    bool put_line(std::string_view line);
    std::ptrdiff_t put_some(std::string_view text) const;

    int descriptor_;
    /// The same pipe or terminal, opened so that writing does not wait.
    UniqueFd own_;
    std::uint64_t lost_ = 0;
    /// Only a part of the latest line was written.
    bool torn_ = false;
};

}  // namespace tribus
