#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace tribus {

enum class MonitorKey : std::uint8_t { next, previous, page_down, page_up, pause, quit };

/// The keys in the bytes that a terminal sends; unknown keys are skipped. Pure.
std::vector<MonitorKey> keys_in(std::string_view bytes);

}  // namespace tribus
