#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The little markup in which the texts of the manual are written. Pure.
namespace tribus {

enum class BlockKind : std::uint8_t { paragraph, list, code };

struct ManualBlock {
    BlockKind kind = BlockKind::paragraph;
    /// Of a paragraph one text, of a list its items, of code its lines.
    std::vector<std::string> texts;
};

/// Blocks with an empty line between them: a list begins with `- `, code stands between fences.
std::vector<ManualBlock> blocks_of(std::string_view text);

/// Lines of at most `width` characters, where words allow that; all but the first are indented by
/// `indent` blanks. Without the last end of line.
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent = 0);

/// Every occurrence of `from` becomes `to`.
std::string replaced(std::string text, std::string_view from, std::string_view to);

}  // namespace tribus
