#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/language/document.h"
#include "config/language/mistakes.h"

namespace tribus {

/// Upper limit of the size of a file: 1,000 pipelines with 18 rules each have 1.4 MB.
inline constexpr std::size_t kMostConfigurationBytes = 4UL * 1024UL * 1024UL;
/// Upper limit of the mistakes of syntax that are searched for in one file.
inline constexpr std::size_t kMostSyntaxMistakes = 32;
/// Upper limit of the bytes that are parsed for it, about a second: each mistake costs some thirty
/// attempts.
inline constexpr std::size_t kMostReparsedBytes = 8UL * 1024UL * 1024UL;

/// The text that was left out in order to read the rest of a file. A name or key that stands only
/// in it is not missing.
class LostText {
  public:
    /// Adds a line that was left out. `header_line`: the line of the header of its table.
    void add_line(std::string_view line, unsigned header_line);

    /// Whether a lost line contains the word (letters, digits, `_`, `-`).
    bool mentions(std::string_view word) const;
    /// Whether the table whose header stands in that line has lost text.
    bool affects(Location table) const { return header_lines_.count(table.line) != 0; }

  private:
    std::set<std::string, std::less<>> words_;
    std::set<unsigned> header_lines_;
};

/// A file as far as it could be read.
struct Document {
    Table root;
    LostText lost;
    /// False: only the mistakes of syntax are known, and `root` is empty.
    bool readable = true;
};

/// Reads TOML and continues after mistakes of syntax: it repairs a line if the intention is clear,
/// and leaves it out otherwise. Adds each such mistake to `mistakes`. Accepts any bytes.
Document read_document(std::string_view text, Mistakes& mistakes);

}  // namespace tribus
