#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"

namespace tribus {

/// One mistake in a configuration, written for the person who corrects it.
struct Mistake {
    std::string file;
    Location where;    ///< line 0: the file as a whole
    std::string text;  ///< "what is wrong; what is allowed", one line
    /// The file, or a file that it names, cannot be read. Its content may be correct, and another
    /// attempt may succeed, for example after its disk is mounted.
    bool out_of_reach = false;
};

/// Whether all of these mistakes may disappear without a change of the configuration.
bool may_be_temporary(std::span<const Mistake> mistakes);

/// Formats a mistake as `file:line:column: what is wrong; what is allowed`.
std::string format_mistake(const Mistake& mistake);

/// Collects the mistakes of one file. Thread-bound.
class Mistakes {
  public:
    explicit Mistakes(std::string_view file) : file_(file) {}

    void add(Location where, std::string text) {
        mistakes_.push_back({file_, where, std::move(text)});
    }
    /// Adds a mistake with `out_of_reach`.
    void add_out_of_reach(Location where, std::string text) {
        mistakes_.push_back({file_, where, std::move(text), true});
    }
    void add(Mistake mistake) { mistakes_.push_back(std::move(mistake)); }
    void add(const Mistakes& others) {
        mistakes_.insert(mistakes_.end(), others.mistakes_.begin(), others.mistakes_.end());
    }
    bool empty() const { return mistakes_.empty(); }
    /// Whether there is a mistake on that line.
    bool on_line(unsigned line) const;
    const std::string& file() const { return file_; }
    /// Sorted by line and column. Mistakes at the same place keep their order.
    std::vector<Mistake> sorted() const;

  private:
    std::string file_;
    std::vector<Mistake> mistakes_;
};

/// Hint for a wrong word: `did you mean "x"? Allowed: "x", "y"` or `allowed: ...`.
std::string suggestion(std::string_view wrong, std::span<const std::string_view> allowed);

}  // namespace tribus
