#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>

#include "tests/mutation/switch.h"

/// Linked into programs of googletest: writes for each test how many milliseconds it computed, how
/// many it took, and which mutations it reached, if TRIBUS_MUTATIONS_REACHED names a file.
namespace tribus_mutation {
namespace {

class Record : public testing::EmptyTestEventListener {
  public:
    explicit Record(const std::string& file) : lines_(file + ".tests") {
        struct stat status {};
        size_ = stat(file.c_str(), &status) == 0 ? static_cast<std::size_t>(status.st_size) : 0;
    }

    void OnTestStart(const testing::TestInfo& /*test*/) override { started_ = std::clock(); }

    void OnTestEnd(const testing::TestInfo& test) override {
        lines_ << test.test_suite_name() << '.' << test.name() << ' '
               << (test.result()->Failed()    ? "failed"
                   : test.result()->Skipped() ? "skipped"
                                              : "passed")
               << ' ' << (std::clock() - started_) * 1000 / CLOCKS_PER_SEC << ' '
               << test.result()->elapsed_time();
        for (std::size_t number = 0; number < size_; ++number) {
            if (reached[number] != 0) {
                lines_ << ' ' << number;
            }
        }
        lines_ << std::endl;
        std::memset(reached, 0, size_);
    }

  private:
    std::ofstream lines_;
    std::size_t size_;
    std::clock_t started_ = 0;
};

[[maybe_unused]] const bool kListens = [] {
    const char* file = std::getenv("TRIBUS_MUTATIONS_REACHED");
    if (file != nullptr && reached != nullptr) {
        testing::UnitTest::GetInstance()->listeners().Append(new Record(file));
    }
    return true;
}();

}  // namespace
}  // namespace tribus_mutation
