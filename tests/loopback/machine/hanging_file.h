#pragma once

#include <pthread.h>

#include <array>
#include <atomic>
#include <string>

#include "app/daemon/preparation.h"
#include "tests/support/device_stand_in.h"
#include "tests/support/seen_within.h"

namespace tribus::test {

/// A file on a disk that does not answer: who opens it waits until `answer`.
class HangingFile : public DeviceStandIn {
  public:
    explicit HangingFile(const std::string& path) : DeviceStandIn(path) {}
    ~HangingFile() override {
        answer();
        EXPECT_TRUE(seen_within([] { return !Preparation::any_abandoned(); }));
    }

    void answer() {
        answers_ = true;
        answers_.notify_all();
    }
    /// Name of the thread that opens it; empty before one does.
    std::string thread() const { return opens_ ? thread_.data() : ""; }
    Answer open() override {
        ::pthread_getname_np(::pthread_self(), thread_.data(), thread_.size());
        opens_ = true;
        answers_.wait(false);
        return {};
    }

  private:
    std::atomic<bool> answers_ = false;
    std::array<char, 16> thread_{};
    std::atomic<bool> opens_ = false;
};

}  // namespace tribus::test
