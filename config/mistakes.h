#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema.h"

namespace tribus {

/// One thing that is wrong with a configuration, written for the person who must correct it.
struct Mistake {
    std::string file;
    Location where;    ///< line 0: the file as a whole
    std::string text;  ///< "what is wrong; what is allowed", one line
    /// The file, or one that it names, cannot be read: nothing in it need be wrong, and another try
    /// may go well, once its disk is mounted.
    bool out_of_reach = false;
};

/// All of these may be gone at another try, though nobody mends anything.
bool may_pass(std::span<const Mistake> mistakes);

/// `file:line:column: what is wrong; what is allowed`
std::string format_mistake(const Mistake& mistake);

/// Collects the mistakes of one file. Thread-bound.
class Mistakes {
  public:
    explicit Mistakes(std::string_view file) : file_(file) {}

    void add(Location where, std::string text) {
        mistakes_.push_back({file_, where, std::move(text)});
    }
    void add_out_of_reach(Location where, std::string text) {
        mistakes_.push_back({file_, where, std::move(text), true});
    }
    bool empty() const { return mistakes_.empty(); }
    bool on_line(unsigned line) const;
    const std::string& file() const { return file_; }
    /// By line and column; what was found first stands first.
    std::vector<Mistake> sorted() const;

  private:
    std::string file_;
    std::vector<Mistake> mistakes_;
};

/// What may stand in the place of `wrong`: `did you mean "x"? Allowed: "x", "y"` or `allowed: ...`.
std::string suggestion(std::string_view wrong, std::span<const std::string_view> allowed);

}  // namespace tribus
