#include "transports/links/start_thread.h"

#include <pthread.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <semaphore>
#include <thread>

#include <gtest/gtest.h>

namespace tribus::test::start_thread_test {
namespace {

constexpr std::size_t kAsked = std::size_t{128} * 1024;

/// More than the kernel's page would leave over by chance. The C library keeps it on each stack.
constexpr std::size_t kThreadLocalBytes = 20000;
thread_local volatile std::uint8_t thread_locals[kThreadLocalBytes];

/// Leaves in `*room` how much of its stack a thread has when it begins.
void* measure(void* room) {
    thread_locals[0] = 1;
    pthread_attr_t attributes;
    ::pthread_getattr_np(::pthread_self(), &attributes);
    void* end = nullptr;
    std::size_t size = 0;
    ::pthread_attr_getstack(&attributes, &end, &size);
    ::pthread_attr_destroy(&attributes);
    *static_cast<std::size_t*>(room) =
        reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0)) -
        reinterpret_cast<std::uintptr_t>(end);
    return nullptr;
}

std::size_t room_of_thread(std::size_t asked) {
    pthread_t thread{};
    std::size_t room = 0;
    EXPECT_EQ(start_thread(thread, asked, &measure, &room), 0);
    ::pthread_join(thread, nullptr);
    return room;
}

TEST(StartThread, GivesTheWholeStackThatIsAskedForBesideThreadLocalStorage) {
    EXPECT_GE(room_of_thread(kAsked), kAsked);
}

/// An upper bound, because all of it may be locked into memory.
TEST(StartThread, GivesLittleMore) {
    EXPECT_LE(room_of_thread(kAsked), kAsked + kThreadLocalBytes + 64 * 1024);
}

TEST(StartThread, GivesAtLeastWhatAThreadNeeds) {
    EXPECT_GT(room_of_thread(1), 0U);
}

/// In a process of its own: it is for all threads.
TEST(StartThread, GivesOtherThreadsSuchAStackToo) {
    EXPECT_EXIT(
        {
            std::size_t room = 0;
            const bool set = set_usual_stack(kAsked) == 0;
            std::thread([&room] { measure(&room); }).join();
            std::_Exit(set && room >= kAsked && room <= kAsked + kThreadLocalBytes + 64 * 1024 ? 0
                                                                                               : 1);
        },
        ::testing::ExitedWithCode(0), "");
}

/// What a thread says of itself. It may outlive its test.
std::binary_semaphore has_said(0);
int detach_state = -1;

void* tell_whether_detached(void* /*none*/) {
    pthread_attr_t attributes;
    ::pthread_getattr_np(::pthread_self(), &attributes);
    ::pthread_attr_getdetachstate(&attributes, &detach_state);
    ::pthread_attr_destroy(&attributes);
    has_said.release();
    return nullptr;
}

TEST(StartThread, StartsThreadsThatAreJoinedUnlessToldOtherwise) {
    pthread_t thread{};
    ASSERT_EQ(start_thread(thread, kAsked, &tell_whether_detached, nullptr), 0);
    has_said.acquire();
    EXPECT_EQ(detach_state, PTHREAD_CREATE_JOINABLE);
    ::pthread_join(thread, nullptr);
}

TEST(StartThread, StartsThreadsThatNobodyJoins) {
    pthread_t thread{};
    ASSERT_EQ(start_thread(thread, kAsked, &tell_whether_detached, nullptr, ThreadKind::detached),
              0);
    has_said.acquire();
    EXPECT_EQ(detach_state, PTHREAD_CREATE_DETACHED);
}

TEST(StartThread, SaysThatAStackIsTooLarge) {
    pthread_t thread{};
    EXPECT_NE(start_thread(thread, std::numeric_limits<std::size_t>::max() / 4, &measure, nullptr),
              0);
}

}  // namespace
}  // namespace tribus::test::start_thread_test
