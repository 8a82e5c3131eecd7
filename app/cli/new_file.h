#pragma once

#include <filesystem>
#include <string>

#include <sys/types.h>

#include "transports/links/unique_fd.h"

/// Files that a program writes in a folder of another user, root in that of the service for
/// example: who owns the folder could put a pipe, a link or a file of somebody else there.
namespace tribus {

/// The folder of `file`, for `...at` functions and `new_file`. Invalid with errno if it cannot be
/// opened.
UniqueFd folder_of(const std::filesystem::path& file);

/// Makes a file in `folder`, for writing. What has that name is removed first; nothing is followed,
/// truncated or waited for. If root makes it, it belongs to the owner of the folder. Invalid with
/// errno if that fails.
UniqueFd new_file(int folder, const std::string& name, mode_t mode);

/// Gives what root has made in a folder to the owner of the folder, so that the service can use it.
/// No effect for other users. False with errno if that fails.
bool give_to_owner(int folder, int made);

}  // namespace tribus
