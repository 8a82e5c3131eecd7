#pragma once

/// What a standard stream can show.
namespace tribus {

/// Whether the stream is a terminal that obeys control sequences; one with TERM=dumb does not.
bool is_screen(int descriptor);

/// Whether the stream may have colours: a screen whose user does not forbid them by NO_COLOR
/// (https://no-color.org).
bool shows_colour(int descriptor);

}  // namespace tribus
