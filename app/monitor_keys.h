#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace tribus {

enum class MonitorKey : std::uint8_t { next, previous, page_down, page_up, pause, quit };

/// What was pressed, from the bytes that a terminal sends; what is no key of ours is passed over.
/// Pure.
std::vector<MonitorKey> keys_in(std::string_view bytes);

}  // namespace tribus
