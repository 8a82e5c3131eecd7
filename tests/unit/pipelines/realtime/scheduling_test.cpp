#include "pipelines/realtime/scheduling.h"

#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "transports/links/start_thread.h"

namespace tribus::test::scheduling_test {
namespace {

/// Ends the process with 0 if the stack of this thread is in memory, from here to its end and at
/// most what a real-time thread uses, once it is made real-time. Beyond here lies thread-local
/// storage, of which sanitizers have much.
void* prepare_and_look(void* /*nothing*/) {
    std::ignore = make_realtime({.priority = 1, .cpu = std::nullopt, .realtime = true});
    pthread_attr_t attributes;
    ::pthread_getattr_np(::pthread_self(), &attributes);
    void* end = nullptr;
    std::size_t size = 0;
    ::pthread_attr_getstack(&attributes, &end, &size);
    ::pthread_attr_destroy(&attributes);
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    char* const here = static_cast<char*>(__builtin_frame_address(0));
    const std::size_t pages =
        std::min(static_cast<std::size_t>(here - static_cast<char*>(end)), kRealtimeStackBytes) /
        page;
    char* const lowest = here - reinterpret_cast<std::uintptr_t>(here) % page - (pages - 1) * page;
    std::vector<unsigned char> present(pages);
    bool all = ::mincore(lowest, pages * page, present.data()) == 0;
    for (const unsigned char one : present) {
        all = all && (one & 1) != 0;
    }
    std::_Exit(all ? 0 : 1);
}

/// With a stack of `bytes`, of which thread-local storage takes some.
[[noreturn]] void run_on_stack(std::size_t bytes) {
    pthread_attr_t attributes;
    pthread_t thread{};
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, bytes);
    ::pthread_create(&thread, &attributes, &prepare_and_look, nullptr);
    ::pthread_join(thread, nullptr);
    std::_Exit(2);
}

[[noreturn]] void run_on_started_thread() {
    pthread_t thread{};
    std::ignore = start_thread(thread, kRealtimeStackBytes, &prepare_and_look, nullptr);
    ::pthread_join(thread, nullptr);
    std::_Exit(2);
}

/// Real time is for the process, so each test has one of its own.
TEST(Scheduling, BringsTheWholeStackIntoMemory) {
    EXPECT_EXIT(run_on_started_thread(), ::testing::ExitedWithCode(0), "");
}

/// So does a library with much thread-local storage.
TEST(Scheduling, GoesNotBeyondTheEndOfAStackThatIsSmallerThanUsual) {
    EXPECT_EXIT(run_on_stack(kRealtimeStackBytes - 32 * 1024), ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace tribus::test::scheduling_test
