#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace tribus::test {

/// Compares `now` with the stored table tests/sim/`file`. Stored tables keep changes of key
/// behaviour visible.
inline void expect_stored(const std::string& file, const std::string& now) {
    const std::string path = std::string(TRIBUS_SOURCE_DIR) + "/tests/sim/" + file;
    if (std::getenv("TRIBUS_STORE") != nullptr) {
        std::ofstream(path) << now;
    }
    std::ostringstream stored;
    stored << std::ifstream(path).rdbuf();
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    EXPECT_EQ(now, stored.str())
        << "If this is intended, store it and give the reason in the commit:\n"
           "TRIBUS_STORE=1 build/tests/sim_tests --gtest_filter="
        << test->test_suite_name() << "." << test->name();
}

}  // namespace tribus::test
