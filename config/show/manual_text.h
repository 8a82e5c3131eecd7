#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

/// The markup of the texts of the manual. Pure.
namespace tribus {

enum class BlockKind : std::uint8_t { paragraph, list, code };

struct ManualBlock {
    BlockKind kind = BlockKind::paragraph;
    /// A paragraph has one text, a list its items, code its lines.
    std::vector<std::string> texts;
};

/// Returns the blocks of a text. An empty line ends a block; items of a list begin with `- `; code
/// is between lines of ```.
std::vector<ManualBlock> blocks_of(std::string_view text);

/// Returns `text` with each `from` replaced by `to`.
std::string replaced(std::string text, std::string_view from, std::string_view to);

}  // namespace tribus
