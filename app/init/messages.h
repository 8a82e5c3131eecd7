#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/finding.h"

namespace tribus::init {

/// Messages of `init` for the user, in lines of at most `columns`, except commands. Thread-bound.
class Messages {
  public:
    Messages(std::ostream& out, std::size_t columns, bool colour)
        : out_(out), columns_(columns), colour_(colour) {}

    /// Prints a text after `first`; further lines are indented by the length of `first`.
    void say(std::string_view text, std::string_view first = {});
    /// Prints a line unchanged, such as a command to copy.
    void line(std::string_view text);
    /// Prints short texts side by side, in as many columns as fit.
    void side_by_side(const std::vector<std::string>& texts);
    void findings(const std::vector<doctor::Finding>& findings);
    /// Prints the prompt of an answer.
    void prompt();

  private:
    std::ostream& out_;
    std::size_t columns_;
    bool colour_;
};

}  // namespace tribus::init
