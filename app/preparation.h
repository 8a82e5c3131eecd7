#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/appliance.h"
#include "config/mistakes.h"
#include "config/schema.h"

namespace tribus {

/// A configuration on its way to an appliance that can be started, on a thread of its own: a file
/// of 11 MB, or a disk that does not answer, keeps the main thread from nothing. Thread-bound to
/// the main thread.
class Preparation {
  public:
    using Result = tl::expected<std::unique_ptr<Appliance>, std::vector<Mistake>>;

    /// Of the file as it is now.
    static std::unique_ptr<Preparation> of_file(const std::string& path);
    static std::unique_ptr<Preparation> of(const Configuration& configuration);
    Preparation(const Preparation&) = delete;
    Preparation& operator=(const Preparation&) = delete;
    /// Does not wait for its end: what is not done yet goes on for nothing.
    ~Preparation();

    /// Readable once it is done.
    int descriptor() const;
    bool done() const;
    /// Once, when it is done.
    Result take();

    /// Threads go on of which nobody waits for the result. The process must end without tearing
    /// down what those may use.
    static bool any_forsaken();

  private:
    struct Work;
    explicit Preparation(std::shared_ptr<Work> work) : work_(std::move(work)) {}
    static std::unique_ptr<Preparation> begin(std::function<Result()> prepare);
    static void* main(void* given);

    std::shared_ptr<Work> work_;
};

}  // namespace tribus
