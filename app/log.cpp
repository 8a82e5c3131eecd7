#include "app/log.h"

#include <spdlog/spdlog.h>

namespace tribus {

void log_text(LogLevel level, std::string_view text) {
    const auto of_library = level == LogLevel::info      ? spdlog::level::info
                            : level == LogLevel::warning ? spdlog::level::warn
                                                         : spdlog::level::err;
    // A text of one argument is no format, so its braces stay.
    spdlog::default_logger_raw()->log(of_library, spdlog::string_view_t(text.data(), text.size()));
}

}  // namespace tribus
