#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

/// The secret of a paired browser.
namespace tribus::web {

/// 256 random bits in hex. The error is a sentence.
tl::expected<std::string, std::string> new_cookie();

/// SHA-256 in hex; empty for what cannot be a cookie.
std::string hash_of_cookie(std::string_view cookie);

}  // namespace tribus::web
