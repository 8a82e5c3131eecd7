#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
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

/// Collects the mistakes of one file: the texts of some, and the number of all. Thread-bound.
class Mistakes {
  public:
    /// Nobody reads more of them, and each text costs time.
    static constexpr std::size_t kMostTexts = 100;

    explicit Mistakes(std::string_view file) : file_(file) {}

    void add(Location where, std::string text) { add({file_, where, std::move(text)}); }
    /// Adds a mistake with `out_of_reach`.
    void add_out_of_reach(Location where, std::string text) {
        add({file_, where, std::move(text), true});
    }
    void add(Mistake mistake);
    void add(const Mistakes& others);
    bool empty() const { return mistakes_.empty(); }
    /// Whether the text of a further mistake is of no use. `count` takes it then.
    bool full() const { return mistakes_.size() >= kMostTexts; }
    void count() { count(1, false); }
    /// Whether there is a mistake on that line.
    bool on_line(unsigned line) const;
    const std::string& file() const { return file_; }
    /// Without those on lines where `others` has a mistake.
    Mistakes without_lines_of(const Mistakes& others) const;
    /// Sorted by line and column. Mistakes at the same place keep their order. If some have no
    /// text, the last one is of the whole file, and says how many.
    std::vector<Mistake> sorted() const;

  private:
    void count(std::size_t further, bool out_of_reach);

    std::string file_;
    std::vector<Mistake> mistakes_;
    /// Those without a text.
    std::size_t further_ = 0;
    bool further_out_of_reach_ = true;
};

/// Hint for a wrong word: `did you mean "x"? Allowed: "x", "y"` or `allowed: ...`.
std::string suggestion(std::string_view wrong, std::span<const std::string_view> allowed);

}  // namespace tribus
