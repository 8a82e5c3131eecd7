#include "pipelines/realtime/thread_notices.h"

#include <mutex>
#include <utility>

namespace tribus {
namespace {

/// The threads of links have no object in common with the main thread.
struct Notices {
    std::mutex mutex;
    std::vector<std::string> texts;
};

Notices& notices() {
    static Notices all;
    return all;
}

}  // namespace

void add_thread_notice(std::string text) {
    const std::scoped_lock lock(notices().mutex);
    notices().texts.push_back(std::move(text));
}

std::vector<std::string> take_thread_notices() {
    const std::scoped_lock lock(notices().mutex);
    return std::exchange(notices().texts, {});
}

}  // namespace tribus
