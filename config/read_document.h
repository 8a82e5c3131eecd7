#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "config/mistakes.h"

namespace tribus {

/// No useful configuration comes near it; bounds the time that mistakes take to find.
inline constexpr std::size_t kMostConfigurationBytes = 256UL * 1024UL;
/// After so many, further syntax mistakes of one file are not looked for.
inline constexpr std::size_t kMostSyntaxMistakes = 32;
/// Nor after so much parsing, about a second: each mistake costs some thirty tries to read on.
inline constexpr std::size_t kMostReparsedBytes = 8UL * 1024UL * 1024UL;

/// What had to be left out of a file to read the rest of it. A name or key that only stood in there
/// is not missing.
class LostText {
  public:
    void add_line(std::string_view line, unsigned header_line);

    /// A word (letters, digits, `_`, `-`) of a lost line.
    bool mentions(std::string_view word) const;
    /// The table whose header stands in that line has lost something.
    bool hurts(Location table) const { return header_lines_.count(table.line) != 0; }

  private:
    std::set<std::string, std::less<>> words_;
    std::set<unsigned> header_lines_;
};

struct Document {
    Table root;
    LostText lost;
    /// Nothing was found that can be judged: only the mistakes of syntax are known.
    bool readable = true;
};

/// Reads TOML, and reads on behind a mistake of syntax: the line is repaired where it is clear what
/// was meant, else left out. Every such mistake is added to `mistakes`. Any bytes are allowed.
Document read_document(std::string_view text, Mistakes& mistakes);

}  // namespace tribus
