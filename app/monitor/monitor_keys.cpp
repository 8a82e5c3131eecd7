#include "app/monitor/monitor_keys.h"

#include <array>
#include <utility>

namespace tribus {

std::vector<MonitorKey> keys_in(std::string_view bytes) {
    // Cursor keys in both modes of a terminal (ECMA-48 CUU and CUD, DEC's application mode).
    constexpr std::array<std::pair<std::string_view, MonitorKey>, 15> kKeys{{
        {"\x1b[A", MonitorKey::previous},
        {"\x1bOA", MonitorKey::previous},
        {"\x1b[Z", MonitorKey::previous},
        {"k", MonitorKey::previous},
        {"\x1b[B", MonitorKey::next},
        {"\x1bOB", MonitorKey::next},
        {"\t", MonitorKey::next},
        {"j", MonitorKey::next},
        {"\x1b[5~", MonitorKey::page_up},
        {"u", MonitorKey::page_up},
        {"\x1b[6~", MonitorKey::page_down},
        {"d", MonitorKey::page_down},
        {"p", MonitorKey::pause},
        {" ", MonitorKey::pause},
        {"q", MonitorKey::quit},
    }};
    std::vector<MonitorKey> keys;
    while (!bytes.empty()) {
        std::size_t length = 1;
        for (const auto& [text, key] : kKeys) {
            if (bytes.starts_with(text)) {
                keys.push_back(key);
                length = text.size();
                break;
            }
        }
        bytes.remove_prefix(length);
    }
    return keys;
}

}  // namespace tribus
