#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <sys/types.h>

#include <tl/expected.hpp>

namespace tribus {

/// Writes all of `text` to a descriptor. False on an error, which is in errno. Blocks.
bool write_all(int descriptor, std::string_view text);

/// Replaces a file by this text: also if the power fails, the old text or the new one is there. The
/// new file has the permissions of the old one, or `usual`, and its owner and group, as far as this
/// user may give them; one that root makes where none was belongs to the owner of the folder. Also
/// in a folder of another user nothing is followed (`new_file`). Blocks until it is on the disk.
/// The error is a sentence; the old text stays.
tl::expected<void, std::string> replace_file(const std::filesystem::path& file,
                                             std::string_view text, mode_t usual);

/// The file behind `file` if that is a link. The link stays if this one is replaced.
std::filesystem::path linked_file(const std::filesystem::path& file);

/// Its two halves, for a file that one process writes and another one puts in place. The successor
/// is a hidden file beside `file`, and on the disk when this returns.
tl::expected<void, std::string> write_successor(const std::filesystem::path& file,
                                                std::string_view text, mode_t usual);
std::filesystem::path successor_of(const std::filesystem::path& file);
/// The successor takes the place of the file, in one step.
tl::expected<void, std::string> put_successor_in_place(const std::filesystem::path& file);
void remove_successor(const std::filesystem::path& file);

}  // namespace tribus
