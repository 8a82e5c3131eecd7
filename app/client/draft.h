#pragma once

#include <string>
#include <string_view>

namespace tribus {

/// Writes the draft that the daemon with that control socket reads; the request `draft` has made
/// the folder. The daemon's user and group may write there and may be others than this program's,
/// root for example: so the place comes from `socket`, not from an answer, and nothing there is
/// followed. False with errno if it cannot be written.
bool write_draft(const std::string& socket, std::string_view text);

}  // namespace tribus
