#pragma once

#include <filesystem>
#include <string_view>

/// Recordings of real receivers, and vectors. Some of them are under licences of their own, so they
/// stand beside the project, not in it.
namespace tribus::test {

/// What a test says that lacks one. It fails then: without recordings it has shown nothing.
inline constexpr std::string_view kNoCaptures =
    "no recordings in " TRIBUS_SHARED_DIR
    "/captures; configure with -DTRIBUS_SHARED=FOLDER, where "
    "FOLDER/captures holds them";

inline std::filesystem::path capture(std::string_view name) {
    return std::filesystem::path(TRIBUS_SHARED_DIR) / "captures" / name;
}

}  // namespace tribus::test
