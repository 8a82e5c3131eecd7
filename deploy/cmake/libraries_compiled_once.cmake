# Debian has fmt compiled only as a shared library, which needs a shared libstdc++ too: both take 0.6 ms
# of a start of 2.2 ms, and 0.2 MB of locked memory, more than DaemonMemoryUse allows. So fmt and spdlog
# are compiled in (deploy/debian/copyright). In its header-only form every file that formats a text
# compiles all of fmt again: half of the time that app and config take. So one file has it, and the
# others link that; likewise with spdlog, of which a file that logs would compile 8 s.
file(CONFIGURE OUTPUT fmt_once.cpp CONTENT "#include <fmt/format.h>\n")
add_library(tribus_fmt STATIC "${CMAKE_CURRENT_BINARY_DIR}/fmt_once.cpp")
# fmt marks with FMT_API what it gives to others. In the header-only form that is inline; the attribute
# makes GCC emit it all the same. With Clang each file compiles its own.
target_compile_definitions(tribus_fmt PRIVATE FMT_HEADER_ONLY
    $<$<CXX_COMPILER_ID:GNU>:FMT_API=__attribute__\(\(used\)\)>
    PUBLIC $<$<CXX_COMPILER_ID:Clang>:FMT_HEADER_ONLY>)
target_compile_options(tribus_fmt PRIVATE $<$<NOT:$<CONFIG:Debug>>:-Og>)
target_include_directories(tribus_fmt SYSTEM PUBLIC
    $<TARGET_PROPERTY:fmt::fmt,INTERFACE_INCLUDE_DIRECTORIES>)

# Headers that nearly all sources of the start include, compiled once for all layers.
file(CONFIGURE OUTPUT start_headers.cpp CONTENT "")
add_library(tribus_start_headers OBJECT "${CMAKE_CURRENT_BINARY_DIR}/start_headers.cpp")
target_link_libraries(tribus_start_headers PRIVATE tribus_fmt tribus_warnings)
tribus_start_options(tribus_start_headers)
target_precompile_headers(tribus_start_headers PRIVATE <algorithm> <array> <charconv> <chrono>
    <filesystem> <functional> <map> <memory> <optional> <span> <string> <string_view> <variant>
    <vector> <fmt/format.h> <tl/expected.hpp>)

set(spdlog_parts spdlog common details/backtracer details/log_msg details/log_msg_buffer details/os
    details/periodic_worker details/registry logger pattern_formatter sinks/ansicolor_sink
    sinks/base_sink sinks/sink sinks/stdout_color_sinks)
list(TRANSFORM spdlog_parts REPLACE "(.+)" "#include <spdlog/\\1-inl.h>\n")
list(JOIN spdlog_parts "" spdlog_parts)
file(CONFIGURE OUTPUT spdlog_once.cpp @ONLY CONTENT [[
@spdlog_parts@
#include <mutex>
#include <spdlog/details/null_mutex.h>
template class spdlog::sinks::base_sink<std::mutex>;
template class spdlog::sinks::base_sink<spdlog::details::null_mutex>;
template class spdlog::sinks::ansicolor_sink<spdlog::details::console_mutex>;
template class spdlog::sinks::ansicolor_sink<spdlog::details::console_nullmutex>;
template class spdlog::sinks::ansicolor_stderr_sink<spdlog::details::console_mutex>;
template class spdlog::sinks::ansicolor_stderr_sink<spdlog::details::console_nullmutex>;
template std::shared_ptr<spdlog::logger>
spdlog::stderr_color_st<spdlog::synchronous_factory>(const std::string&, spdlog::color_mode);
]])
add_library(tribus_spdlog STATIC "${CMAKE_CURRENT_BINARY_DIR}/spdlog_once.cpp")
tribus_start_options(tribus_spdlog)
target_precompile_headers(tribus_spdlog REUSE_FROM tribus_start_headers)
target_compile_definitions(tribus_spdlog PUBLIC SPDLOG_COMPILED_LIB SPDLOG_FMT_EXTERNAL)
target_include_directories(tribus_spdlog SYSTEM PUBLIC
    $<TARGET_PROPERTY:spdlog::spdlog,INTERFACE_INCLUDE_DIRECTORIES>)
target_link_libraries(tribus_spdlog PUBLIC tribus_fmt Threads::Threads)
