#pragma once

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace tribus::test {

/// Lets this program open only so many more descriptors, as long as the object is there. Only where
/// no other thread opens any.
class FewerDescriptors {
  public:
    explicit FewerDescriptors(int most) {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        // The kernel gives the lowest ones that are free.
        int next = 0;
        for (int left = most; left > 0 || ::fcntl(next, F_GETFD) != -1; ++next) {
            left -= ::fcntl(next, F_GETFD) == -1 ? 1 : 0;
        }
        rlimit fewer = before_;
        fewer.rlim_cur = static_cast<rlim_t>(next);
        ::setrlimit(RLIMIT_NOFILE, &fewer);
    }
    FewerDescriptors(const FewerDescriptors&) = delete;
    FewerDescriptors& operator=(const FewerDescriptors&) = delete;
    ~FewerDescriptors() { ::setrlimit(RLIMIT_NOFILE, &before_); }

  private:
    rlimit before_{};
};

}  // namespace tribus::test
