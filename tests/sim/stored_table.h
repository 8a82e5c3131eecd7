#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace tribus::test {

/// Key behaviour is kept as a table beside the tests: `now` must be what tests/sim/`file` holds.
inline void expect_stored(const std::string& file, const std::string& now) {
    const std::string path = std::string(TRIBUS_SOURCE_DIR) + "/tests/sim/" + file;
    if (std::getenv("TRIBUS_STORE") != nullptr) {
        std::ofstream(path) << now;
    }
    std::ostringstream stored;
    stored << std::ifstream(path).rdbuf();
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    EXPECT_EQ(now, stored.str()) << "If the change is wanted, store it and say why in the commit:\n"
                                    "TRIBUS_STORE=1 build/tests/sim_tests --gtest_filter="
                                 << test->test_suite_name() << "." << test->name();
}

}  // namespace tribus::test
