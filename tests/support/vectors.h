#pragma once

#include <filesystem>
#include <fstream>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

/// Byte vectors with their sources (tests/vectors/README.md).
namespace tribus::test {

inline std::filesystem::path vector_file(std::string_view name) {
    return std::filesystem::path(TRIBUS_SOURCE_DIR) / "tests" / "vectors" / name;
}

/// Returns the content of a JSON file of tests/vectors.
template <class Json = nlohmann::json>
Json vectors(std::string_view name) {
    std::ifstream file(vector_file(name));
    EXPECT_TRUE(file) << vector_file(name);
    return file ? Json::parse(file) : Json{};
}

}  // namespace tribus::test
