#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// Characters of a user's text. Pure and reentrant.
namespace tribus {

/// Stands for a byte that has no meaning.
inline constexpr char32_t kReplacementCharacter = 0xFFFD;

/// Length in bytes of the UTF-8 character at the start of `text`; 0 if it is not valid.
std::size_t utf8_length(std::string_view text);

bool is_utf8(std::string_view text);

/// The character at the start of `text`, which must be valid UTF-8.
char32_t utf8_character(std::string_view text);

void append_utf8(std::string& text, char32_t character);

/// The character of a byte in Windows-1252, which has all printable ones of ISO 8859-1.
/// kReplacementCharacter for its five gaps.
char32_t windows_1252_character(char byte);

}  // namespace tribus
