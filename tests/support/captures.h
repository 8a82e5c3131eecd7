#pragma once

#include <filesystem>
#include <string_view>

/// Recordings of real receivers, and test vectors. Some have licences of their own, so they are not
/// part of the project.
namespace tribus::test {

/// Failure message of a test without recordings. The test fails because it has shown nothing.
inline constexpr std::string_view kNoCaptures =
    "no recordings in " TRIBUS_SHARED_DIR
    "/captures; configure with -DTRIBUS_SHARED=FOLDER, where "
    "FOLDER/captures holds them";

inline std::filesystem::path capture(std::string_view name) {
    return std::filesystem::path(TRIBUS_SHARED_DIR) / "captures" / name;
}

}  // namespace tribus::test
